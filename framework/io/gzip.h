// Files that are compressed by gzip, as pbrt-v4 takes .pbrt.gz and .ply.gz.
#pragma once

#include <string>
#include <string_view>

namespace etendue {

bool is_gzip(std::string_view bytes);
// The ending of a name in lower case, with its dot; that of NAME.ply.gz is .ply.
std::string extension_of(const std::string& path);
// The bytes that were compressed, of all members one after another. Throws Error on damaged data, on what grows to more than
// 32 times its size (and 64 MiB), and on what does not fit into the memory that is free; `name` names the file in messages.
std::string gunzip(std::string_view bytes, const std::string& name);

}  // namespace etendue
