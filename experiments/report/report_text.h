// How a report writes what a log holds: figures for people, and text made safe for each format.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// Writes three significant digits, or as many as asked for: "0.0123", "1.23e-5", "0".
std::string format_figure(double value, int digits);
inline std::string format_figure(double value) { return format_figure(value, 3); }
// Writes the same without trailing zeros, for figures that people chose: "0.005", "-1".
std::string format_short(double value);
std::string format_factor(double factor);              // "1.23", from a hundred on "123"
std::string format_interval(double low, double high);  // "1.1–1.4"; "-0.1 to 0.2" where a sign would look like the dash

std::string counted(std::size_t count, std::string_view what);  // "1 seed", "3 seeds"

// The smallest of 1, 2 and 5 times a power of ten that is not below `value`, which is positive.
double round_up_nicely(double value);

// Counts the columns a terminal needs for UTF-8 text (one per code point, which holds for all text that a report writes
// itself).
std::size_t display_width(std::string_view text);
std::string padded(std::string_view text, std::size_t width, bool right);
// Keeps at most `width` code points, the last one an ellipsis where text was cut.
std::string shortened(std::string_view text, std::size_t width);
// Keeps at most `width` code points, an ellipsis in the middle where text was cut.
std::string shortened_in_middle(std::string_view text, std::size_t width);
// Fits a line into `width` code points: its longest words are shortened in their middle, names and paths that is, and numbers
// stay whole; what is too long even so ends with the last word that fits.
std::string fitted(std::string text, std::size_t width);
// Joins parts by two spaces, the first ones that fit with what is left of `name`, shortened in its middle, behind them.
std::string status_line(std::span<const std::string> parts, std::string_view name, std::size_t width);

// Breaks lines of at most `width` code points where there are spaces to break at, each but the first `indent` deep; a word that
// is longer keeps a line of its own.
std::vector<std::string> broken_lines(std::string_view text, std::size_t width, std::size_t indent = 0);
// Breaks each line of a text so; what is broken goes on two deeper than it began.
std::string wrapped(std::string_view text, std::size_t width);

std::string escape_html(std::string_view text);      // for text and attribute values, also of SVG; control characters dropped
std::string escape_tex(std::string_view text);       // with figures such as 1.2e-5 set as powers of ten
std::string escape_markdown(std::string_view text);  // for one cell of a table
std::string escape_csv(std::string_view text);
std::string shell_word(std::string_view text);                // as a shell takes it
std::vector<std::string> shell_words(std::string_view text);  // those of a line that shell_word wrote

// "builtin:cornell-box" -> "cornell-box", "scenes/Mine.pbrt" -> "scenes-mine-pbrt": a part of a file's name.
std::string slug(std::string_view text);

std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace etendue
