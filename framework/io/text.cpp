#include "framework/io/text.h"

#include "framework/core/memory.h"
#include "framework/io/gzip.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace etendue {

namespace {

// To look how much memory is free takes longer than to read a smaller file.
constexpr std::size_t look_above_bytes = std::size_t{1} << 26;

struct OpenFile {
  int descriptor;
  explicit OpenFile(int d) : descriptor(d) {}
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
};

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

}  // namespace

std::string read_file(const std::string& path) {
  const auto fail = [&](const std::string& what) { throw Error(fmt::format("cannot read '{}': {}", path, what)); };
  // Without O_NONBLOCK a FIFO would wait for a writer here, and a terminal for its line.
  const OpenFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file.descriptor < 0) throw Error(fmt::format("cannot open '{}': {}", path, std::strerror(errno)));
  struct stat status {};
  if (::fstat(file.descriptor, &status) != 0) fail(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) fail(fmt::format("it is {}; expected a regular file", kind_of(status.st_mode)));
  const auto size = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
  if (size >= look_above_bytes) require_memory(static_cast<double>(size), {}, etendue::quote(path), "a smaller file");
  std::string bytes;
  // What grows while it is read ends at its limit; files of the system state a size of 0.
  const std::size_t most = size + look_above_bytes;
  bytes.resize(size + 4096);
  for (std::size_t used = 0;;) {
    const ssize_t count = ::read(file.descriptor, bytes.data() + used, bytes.size() - used);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(std::strerror(errno));
    used += static_cast<std::size_t>(count);
    if (used > most) fail(fmt::format("it grows: {} bytes were announced, and there are more than {}", size, most));
    if (count == 0) {
      bytes.resize(used);
      break;
    }
    if (used == bytes.size()) bytes.resize(2 * used);
  }
  return is_gzip(bytes) ? gunzip(bytes, path) : bytes;
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

std::string quote(std::string_view word) {
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
