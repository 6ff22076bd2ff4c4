#include "framework/io/gzip.h"

#include "framework/core/error.h"
#include "framework/core/lists.h"
#include "framework/core/memory.h"
#include "framework/io/text.h"

#include <zlib.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace etendue {

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string extension_of(const std::string& path) {
  const std::filesystem::path file(path);
  std::string extension = file.extension().string();
  if (extension == ".gz") extension = file.stem().extension().string();
  return in_lower_case(std::move(extension));
}

std::string gunzip(std::string_view bytes, const std::string& name) {
  constexpr std::size_t step = std::size_t{1} << 20, least_limit = std::size_t{64} << 20, most_times = 32;
  const auto fail = [&](const std::string& what) { throw Error(fmt::format("{} is gzip-compressed: {}", quote(name), what)); };
  if (bytes.size() > 0xffffffffu) fail("it is larger than 4 GiB; expected it decompressed");
  const std::size_t limit = std::max(least_limit, most_times * bytes.size());
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  constexpr int gzip_window = 15 + 16;
  if (inflateInit2(&stream, gzip_window) != Z_OK) fail("zlib does not start");
  const struct End {
    z_stream& stream;
    ~End() { inflateEnd(&stream); }
  } end{stream};
  std::string out;
  for (std::size_t used = 0;;) {
    if (used == out.size()) {
      const std::size_t more = std::max(step, out.size());
      if (more > least_limit) require_memory(static_cast<double>(more), {}, quote(name), "a smaller file");
      out.resize(out.size() + more);
    }
    const auto room = static_cast<uInt>(std::min(out.size() - used, std::size_t{1} << 30));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + used);
    stream.avail_out = room;
    const int status = inflate(&stream, Z_NO_FLUSH);
    used += room - stream.avail_out;
    if (used > limit) fail(fmt::format("it grows to more than {} MiB and {} times its size", least_limit >> 20, most_times));
    if (status == Z_STREAM_END) {
      const std::string_view rest = bytes.substr(bytes.size() - stream.avail_in);
      if (is_gzip(rest) && inflateReset(&stream) == Z_OK) continue;
      out.resize(used);
      return out;
    }
    if (status == Z_BUF_ERROR || (status == Z_OK && stream.avail_in == 0 && stream.avail_out > 0)) fail("it is cut short");
    if (status != Z_OK) fail("its data are damaged");
  }
}

}  // namespace etendue
