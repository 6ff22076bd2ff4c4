// Errors of input: what was wrong, where, what was expected. Libraries throw them, main reports them (exit code 2).
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// A place in an input. Lines and columns count from 1; 0 means unknown. `file` may also name an origin such as
// "command line" or "photons.ply".
struct Location {
  std::string file;
  int line = 0;
  int column = 0;

  std::string text() const;  // "file:line:col", without the parts that are unknown
};

class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& what) : std::runtime_error(what) {}
  Error(const Location& where, const std::string& what);  // "file:line:col: what"
};

// The names nearest to `word` by edit distance in any case (at most `most`, nearest first), for "did you mean".
std::vector<std::string> nearest_names(std::string_view word, std::span<const std::string> names, std::size_t most = 3);

// "unknown <kind> 'word'; did you mean 'a' or 'b'?" with all names when few (quoted if one has a space), for an Error.
std::string unknown_name(std::string_view kind, std::string_view word, std::span<const std::string> names);

}  // namespace etendue
