// Do methods keep what they declare of themselves? On scenes with a closed form their bias is held against what they declare,
// and the share of pixels whose true error lies within one and two of the standard errors that the method itself states
// (Cache::standard_error) against that of errors that are normal and stated rightly: 68 % and 95 %. And do the means of images
// lie where an experiment expects them?
#pragma once

#include "experiments/report/predictions.h"
#include "framework/image/film.h"

#include <map>
#include <string>

namespace etendue {

inline constexpr double rounded_by = 1e-6;  // of the radiance: what single precision leaves of what has no noise

struct ReferenceRecord;
struct ReportData;

// "within_1", "within_2": shares of the pixels, by luminance; "stated", "true": root mean squares of the standard error and of
// the error. The reference counts as exact.
std::map<std::string, double> confidence_of(const Image& image, const Image& standard_error, const Image& reference);

// That a method does not state too little: on scenes with a closed form, medians over seeds at the last checkpoint.
Predictions confidence_predictions(const ReportData& data);

Predictions bias_predictions(const ReportData& data);  // against what methods declare

// The bias of each image, against what the experiment predicts of it: a row for each prediction, scene and configuration.
Predictions image_bias_predictions(const ReportData& data);

// Whether errors are measured against a closed form; and whether the reference's own variance is known, which that of an image
// that the experiment gives is not.
bool is_exact(const ReferenceRecord& reference);
bool knows_variance(const ReferenceRecord& reference);

}  // namespace etendue
