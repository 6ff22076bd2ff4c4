// Tools that the readers of text files share: whole-file input, numbers without a locale, and places for messages.
#pragma once

#include "framework/core/error.h"

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace etendue {

// The bytes of a regular file, decompressed where gzip compressed it. Throws Error when it is missing, unreadable, no regular
// file (a FIFO, a device or a socket is never waited for) or larger than the memory that is free.
std::string read_file(const std::string& path);

// The place of a byte of `text`, counted in lines that end with \n, \r\n or \r.
Location location_at(const std::string& file, std::string_view text, std::size_t offset);

// A decimal number that a float can hold, all of `word`; no hexadecimal, infinity or NaN. Magnitudes below the smallest double
// are 0.
std::optional<double> parse_number(std::string_view word);

// A whole number that the type holds, all of `word`.
template <class Whole>
std::optional<Whole> parse_whole(std::string_view word, int base = 10) {
  Whole value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, base);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

// `word` in quotes, shortened, with control characters shown as '?': fit for a message.
std::string quote(std::string_view word);

// Some editors begin a file in UTF-8 with this mark. Readers of text pass over it.
inline constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

// Words and line ends of a text, with offsets; never past the end.
class WordReader {
 public:
  explicit WordReader(std::string_view text)
      : text_(text), position_(text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0) {}

  bool at_end() const { return position_ >= text_.size(); }
  std::size_t offset() const { return position_; }
  // The next word of this line, empty at the line's end.
  std::string_view word();
  // The next word of the text, empty at its end.
  std::string_view word_on_any_line();
  // Moves past the end of this line.
  void next_line();

 private:
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  static bool is_space(char c) { return c == ' ' || c == '\t'; }

  std::string_view text_;
  std::size_t position_;
};

}  // namespace etendue
