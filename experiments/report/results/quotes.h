// Figures that a document quotes from the logs, filled in between markers, so that none is copied by hand:
//
//   path tracing reaches <!--= first-light/final relmse_median [cornell-box, path, sah] -->4.9e-4<!--/--> after 2.5 s
//
// A marker names a folder of results/ and one of its tables, a column by its key in the CSV, and a row: each word between the
// brackets is the text of one of the row's cells, with or without "builtin:" before it, and one row alone has them all. A
// second such figure behind "/" divides the first. "as" gives the notation: a format of {fmt}, with a factor before it where
// the unit is another, such as "as 1e3 * .1f" for milliseconds. Without it a figure has two digits, and a count all of its
// own: 4.9e-4, 0.57, 12, 4096.
#pragma once

#include "experiments/report/table_format.h"

#include <functional>
#include <string>
#include <string_view>

namespace etendue {

// The table of that name over the log of that folder; throws Error where there is none.
using TableSource = std::function<const Table&(const std::string& folder, const std::string& table)>;

// `text` with every marker's figure as the tables have it now. Throws Error{file:line:col} where a marker cannot be read, names
// what is not there, or fits several rows.
std::string fill_quotes(const std::string& file, std::string_view text, const TableSource& tables);

}  // namespace etendue
