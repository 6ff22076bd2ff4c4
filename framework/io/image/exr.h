// OpenEXR images with string attributes (the manifest travels in them).
#pragma once

#include "framework/image/film.h"
#include "framework/io/whole_file.h"

#include <map>
#include <string>

namespace etendue {

// 32-bit RGB. Throws WriteError, with an older file as it was.
FileStamp write_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& attributes = {});
// The bytes of such a file.
std::string encode_exr(const Image& image, const std::map<std::string, std::string>& attributes = {});

// R, G, B (or Y) of any pixel type; the rest is ignored. `alpha`: A instead, in all components, and 1 where there is none.
// `had_own_primaries`: whether R, G and B are of other primaries than sRGB's, so that they were converted.
// Throws Error on missing, truncated or non-image files.
Image parse_exr(std::string_view bytes, const std::string& name, std::map<std::string, std::string>* attributes = nullptr,
                bool alpha = false, bool* had_own_primaries = nullptr);
Image read_exr(const std::string& path, std::map<std::string, std::string>* attributes = nullptr);

}  // namespace etendue
