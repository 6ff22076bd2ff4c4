// The images of a report's page: half-floats at full size for its viewer, and thumbnails.
#pragma once

#include "experiments/report/report_data.h"
#include "framework/core/vec.h"

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace etendue {

// Holds what encode_halves wrote: in the page, or in a file beside it. Both are empty where there is none.
struct PixelText {
  std::string in_page, file;
};

struct PageFrame {  // the image at a checkpoint
  double time_s = 0;
  PixelText pixels;
  PixelText flip = {};  // as that of a PageImage
};

struct PageImage {
  std::string label, detail;
  const Configuration* configuration = nullptr;  // null: the reference
  std::string thumbnail = {};                    // PNG in base64, sRGB
  PixelText pixels = {};
  // Image less reference, where half-floats of the two would lose it: in units of their own.
  PixelText difference = {};
  double difference_unit = 1;
  PixelText flip = {};                 // FLIP of each pixel, where the experiment asks for that metric
  std::string exr = {};                // a link to the file
  std::optional<double> relmse = {};   // of the whole image, where it is known
  std::vector<PageFrame> frames = {};  // where images of checkpoints were kept
};

struct SceneImages {
  std::string scene;
  ivec2 size{0};
  double unit = 1;   // of the half-floats, a power of two
  double white = 1;  // W/(m² sr), shown as white without exposure
  // The ranges that the colours of the viewer's maps span (mapKinds in pixels.js): decades, and of signed errors these
  // themselves.
  std::map<std::string, std::pair<double, double>> ranges;
  std::vector<PageImage> images;  // the reference first, where its image was kept
  std::vector<std::string> notes;
};

struct ImagePlace {
  std::size_t budget_bytes = 12 << 20;  // of pixels in the page; beyond it they go to files beside it
  std::string directory = {};           // of the page: links to images start from there
  std::function<void(const std::string& name, const std::string& text)> write_beside = {};
};

// One image for each scene and integrator: the lowest seed's, of the first structure that kept one (structures change only the
// time).
std::vector<SceneImages> page_images(const ReportData& data, const ImagePlace& place);

// The colour at t in [0, 1] among colours 0xrrggbb that lie evenly from 0 to 1, as "#rrggbb".
std::string colour_among(std::span<const int> colours, double t);
// Those of viridis ([Smith2015]) at every tenth; it is perceptually uniform, and readable in grey and by the colour-blind.
std::vector<std::string> viridis_stops();

// Pixels are as the page's viewer reads them (pixels.js): half-floats, which keep noise as it is at 11 significant bits.
//
// The half-float nearest to `value` / `unit`, times `unit`; what is too large for one is the largest (65504 units).
double rounded_to_half(double value, double unit);

// Makes `size.x` x `size.y` pixels, in rows from the top, the text that decodeHalves reads: three planes of half-floats in
// units of `unit`, each row as differences of its neighbours' bits, all high bytes before all low ones, deflated (zlib), in
// base64.
std::string encode_halves(const std::vector<dvec3>& pixels, ivec2 size, double unit);
// One plane of them, in units of 1.
std::string encode_halves(const std::vector<double>& values, ivec2 size);

}  // namespace etendue
