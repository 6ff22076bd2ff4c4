// Figures and tables that a document quotes from the logs, filled in between markers, so that none is copied by hand.
//
// A figure names a folder of results/ and one of its tables, a column by its key in the CSV, and a row:
//
//   path tracing reaches <!--= first-light/final relmse_median [cornell-box, path, sah] -->4.9e-4<!--/--> after 2.5 s
//
// Between the brackets stand words, and one row alone has them all. A word is the text of a cell; a scene may do without
// "builtin:", a file without folder and ending. "KEY=TEXT" is the text of one column's cell ("remedy=" an empty one); any other
// "name=value" may also be a part of a cell, as "metric=tabellion" is of a method's name; "not " before a word turns it round.
// "least" or "most" before it takes the smallest or largest of many rows, each of which must have a number there or nothing,
// and "count FOLDER/TABLE [...]" says how many rows there are. A second figure behind "/" divides the first. "as" gives the
// notation: a format of {fmt}, with a factor before it where the unit is another ("as 1e3 * .1f" for milliseconds), or "text"
// for what the log's own table shows, often with its interval. Without it a figure has two digits, and a count all of its
// own: 4.9e-4, 0.57, 12, 4096.
//
// A table is generated from lines that state its columns and rows, one each, with its heading or label behind " : "; ";" ends a
// line, too:
//
//   <!--table first-light/final : method
//   column relmse_median [cornell-box] : Cornell box; column relmse_median [lambert-sphere] as .1e : sphere
//   row [path, sah] : path tracing
//   rows integrator [binned-sah]
//   -->
//   | method | Cornell box | sphere |
//   …
//   <!--/table-->
//
// A cell is the figure that has the words of its row and of its column; one that is no number stands as it is, and "–" stands
// for one that is not there. A row without any figure is an error. "rows KEY [...]" makes a row for each text that the column
// KEY has among the rows of those words, in their order, and "columns KEY relmse_median [...]" makes a column for each,
// whose heading the label ends.
#pragma once

#include "experiments/report/table_format.h"

#include <functional>
#include <string>
#include <string_view>

namespace etendue {

// The table of that name over the log of that folder; throws Error where there is none.
using TableSource = std::function<const Table&(const std::string& folder, const std::string& table)>;

// `text` with every marker's figure or table as the logs' tables have it now. Throws Error{file:line:col} where a marker cannot
// be read, names what is not there, or fits several rows.
std::string fill_quotes(const std::string& file, std::string_view text, const TableSource& tables);

}  // namespace etendue
