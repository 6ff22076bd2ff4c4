#include "framework/io/text.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>

namespace etendue {

std::string read_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw Error(fmt::format("cannot read '{}': it is a directory", path));
  // Some of them never end.
  if (std::filesystem::is_character_file(path, ignored)) throw Error(fmt::format("cannot read '{}': it is a device", path));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw Error(fmt::format("cannot open '{}': {}", path, std::strerror(errno)));
  std::string bytes;
  const auto size = std::filesystem::file_size(path, ignored);
  if (!ignored) bytes.reserve(size + 1);
  for (std::size_t used = 0;;) {
    bytes.resize(std::max<std::size_t>(bytes.capacity(), used + 65536));
    const std::size_t count = std::fread(bytes.data() + used, 1, bytes.size() - used, file.get());
    used += count;
    if (used == bytes.size()) continue;
    bytes.resize(used);
    break;
  }
  if (std::ferror(file.get())) throw Error(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
  if (bytes.starts_with("\x1f\x8b")) throw Error(fmt::format("'{}' is gzip-compressed: decompress it first", path));
  return bytes;
}

Location location_at(const std::string& file, std::string_view text, std::size_t offset) {
  Location where{file, 1, 1};
  for (std::size_t i = 0; i < std::min(offset, text.size()); ++i) {
    if (text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'))) {
      ++where.line;
      where.column = 1;
    } else {
      ++where.column;
    }
  }
  return where;
}

std::optional<double> parse_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const char* digits = word.data() + (!word.empty() && word.front() == '-');
  const char* end = word.data() + word.size();
  if (digits == end || !((*digits >= '0' && *digits <= '9') || *digits == '.')) return std::nullopt;
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(word).c_str(), nullptr);  // 0 or infinite
  if (!(std::abs(value) <= std::numeric_limits<float>::max())) return std::nullopt;
  return value;
}

std::string quoted(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, 60)) text += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return text + (word.size() > 60 ? "...'" : "'");
}

std::string_view WordReader::word() {
  while (!at_end() && is_space(text_[position_])) ++position_;
  const std::size_t begin = position_;
  while (!at_end() && !is_space(text_[position_]) && !is_line_end(text_[position_])) ++position_;
  return text_.substr(begin, position_ - begin);
}

std::string_view WordReader::word_on_any_line() {
  while (!at_end() && (is_space(text_[position_]) || is_line_end(text_[position_]))) ++position_;
  return word();
}

void WordReader::next_line() {
  while (!at_end() && !is_line_end(text_[position_])) ++position_;
  if (at_end()) return;
  position_ += text_[position_] == '\r' && position_ + 1 < text_.size() && text_[position_ + 1] == '\n' ? 2 : 1;
}

}  // namespace etendue
