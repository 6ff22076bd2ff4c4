#include "experiments/report/report_text.h"

#include "framework/core/lists.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace etendue {
namespace {

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) { return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

struct Replacement {
  std::string_view from, to;
};

// How a format writes what means something to it.
struct Escaping {
  std::string_view backslashed;  // characters that a backslash makes plain
  std::vector<Replacement> table;
  std::string_view control;  // in the place of control characters

  // Appends what stands for the first character of `text`. Returns how many bytes it took.
  std::size_t append_first(std::string& out, std::string_view text) const {
    for (const auto& [from, to] : table)
      if (text.starts_with(from)) {
        out += to;
        return from.size();
      }
    if (backslashed.find(text.front()) != std::string_view::npos) out += '\\';
    out += static_cast<unsigned char>(text.front()) < 0x20 ? control : text.substr(0, 1);
    return 1;
  }

  std::string of(std::string_view text) const {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) text.remove_prefix(append_first(out, text));
    return out;
  }
};

// XML forbids control characters, and even references to them.
const Escaping html_escaping{
    "", {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}, {"\n", "\n"}, {"\t", "\t"}}, ""};

const Escaping markdown_escaping{"|\\`*[", {{"<", "&lt;"}}, " "};

// Beside TeX's special characters, what the report's own text uses beyond ASCII.
const Escaping tex_escaping{"{}$&#%_",
                            {{"\\", "\\textbackslash{}"},
                             {"^", "\\textasciicircum{}"},
                             {"~", "\\textasciitilde{}"},
                             {"<", "\\textless{}"},
                             {">", "\\textgreater{}"},
                             {"|", "\\textbar{}"},
                             {"\"", "''"},
                             {"–", "--"},
                             {"—", "---"},
                             {"×", "$\\times$"},
                             {"·", "$\\cdot$"},
                             {"≤", "$\\le$"},
                             {"≥", "$\\ge$"},
                             {"±", "$\\pm$"},
                             {"∞", "$\\infty$"},
                             {"²", "\\textsuperscript{2}"},
                             {"µ", "$\\mu$"},
                             {"†", "\\textdagger{}"},
                             {"−", "$-$"},
                             {"…", "\\dots{}"}},
                            " "};

// The length of a figure in scientific notation at the start of `text` ("1.23e-5"), 0 if there is none.
std::size_t scientific_length(std::string_view text) {
  std::size_t at = 0;
  const auto skip_one_of = [&](std::string_view characters) {
    const bool found = at < text.size() && characters.find(text[at]) != std::string_view::npos;
    at += found;
    return found;
  };
  const auto skip_digits = [&] {
    const std::size_t begin = at;
    while (skip_one_of("0123456789")) {
    }
    return at > begin;
  };
  if (!skip_digits() || (skip_one_of(".") && !skip_digits()) || !skip_one_of("e")) return 0;
  skip_one_of("+-");
  return skip_digits() && (at == text.size() || !is_word(text[at])) ? at : 0;
}

}  // namespace

std::string format_figure(double value, int digits) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  if (value == 0) return "0";
  const double magnitude = std::abs(value), whole = std::pow(10.0, digits - 1) - 0.05;  // from which on no decimal is left
  if (magnitude >= whole && magnitude < 99999.5) return fmt::format("{:.0f}", value);
  // One notation from 0.01 on (for three digits), so that an interval around a small error does not mix two.
  if (magnitude >= 0.995 * std::pow(10.0, 1 - digits) && magnitude < whole) return fmt::format("{:#.{}g}", value, digits);
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  const std::size_t e = text.find('e');
  return fmt::format("{}e{}", text.substr(0, e), std::stoi(text.substr(e + 1)));
}

std::string format_short(double value) {
  const std::string text = format_figure(value);
  const std::size_t end = std::min(text.find('e'), text.size());
  std::string digits = text.substr(0, end);
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  return digits + text.substr(end);
}

std::string format_factor(double factor) { return factor < 100 ? fmt::format("{:.2f}", factor) : format_figure(factor, 2); }

std::string format_interval(double low, double high) {
  return format_figure(low) + (low < 0 ? " to " : "–") + format_figure(high);
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

double round_up_nicely(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * decade >= value * (1 - 1e-9)) return factor * decade;
  return 10 * decade;
}

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return !continues(c); }));
}

std::string padded(std::string_view text, std::size_t width, bool right) {
  const std::size_t used = display_width(text);
  const std::string space(width > used ? width - used : 0, ' ');
  return right ? space + std::string(text) : std::string(text) + space;
}

std::string shortened(std::string_view text, std::size_t width) {
  if (display_width(text) <= width || width == 0) return std::string(text);
  std::size_t end = 0;  // behind the first byte of what is cut
  for (std::size_t count = 0; count < width; ++end) count += !continues(text[end]);
  return std::string(text.substr(0, end - 1)) + "…";
}

std::string shortened_in_middle(std::string_view text, std::size_t width) {
  const std::size_t length = display_width(text);
  if (length <= width || width == 0) return std::string(text);
  const auto behind = [&](std::size_t count) {  // so many code points
    std::size_t end = 0;
    for (; end < text.size(); ++end)
      if (!continues(text[end]) && count-- == 0) break;
    return end;
  };
  const std::size_t kept = width - 1, head = (kept + 1) / 2;
  return fmt::format("{}…{}", text.substr(0, behind(head)), text.substr(behind(length - (kept - head))));
}

std::string fitted(std::string text, std::size_t width) {
  constexpr std::size_t least = 12;  // of a word that is shortened
  while (display_width(text) > width) {
    std::size_t longest = 0, length = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find(' ', begin), text.size());
      if (const std::size_t found = display_width(std::string_view(text).substr(begin, end - begin)); found > length)
        std::tie(longest, length) = std::pair(begin, found);
      begin = end + 1;
    }
    const std::size_t excess = display_width(text) - width;
    if (length <= least) {
      std::string whole = broken_lines(text, width).front();
      return display_width(whole) <= width ? whole : shortened(whole, width);
    }
    const std::size_t end = std::min(text.find(' ', longest), text.size());
    const std::size_t left = length > least + excess ? length - excess : least;
    text.replace(longest, end - longest, shortened_in_middle(text.substr(longest, end - longest), left));
  }
  return text;
}

std::string status_line(std::span<const std::string> parts, std::string_view name, std::size_t width) {
  constexpr std::size_t wide = 110, least_name = 24;  // where there is no such room, the figures come first
  const std::size_t needed = name.empty() || width < wide ? 0 : std::min(display_width(name), least_name) + 2;
  std::string line;
  for (const std::string& part : parts) {
    if (part.empty()) continue;
    const std::size_t length = display_width(line) + (line.empty() ? 0 : 2) + display_width(part);
    if (!line.empty() && length + needed > width) break;
    line += (line.empty() ? "" : "  ") + part;
  }
  constexpr std::size_t fewest = 8;  // letters of a name that tell something
  const std::size_t taken = display_width(line) + 2;
  if (name.empty() || taken + fewest > width) return shortened(line, width);
  return line + "  " + shortened_in_middle(name, width - taken);
}

std::vector<std::string> broken_lines(std::string_view text, std::size_t width, std::size_t indent) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
    end = std::min(text.find(' ', lines.empty() ? text.find_first_not_of(' ') : begin), text.size());
    const std::string word(text.substr(begin, end - begin));  // the first with the spaces before it
    if (!lines.empty() && display_width(lines.back()) + 1 + display_width(word) <= width)
      lines.back() += " " + word;
    else
      lines.push_back(lines.empty() ? word : std::string(indent, ' ') + word);
  }
  return lines;
}

std::string wrapped(std::string_view text, std::size_t width) {
  if (text.empty()) return "";
  if (text.ends_with('\n')) text.remove_suffix(1);
  const auto broken = [&](const std::string& line) {
    return display_width(line) <= width ? line + "\n"
                                        : joined(broken_lines(line, width, line.find_first_not_of(' ') + 2), "\n") + "\n";
  };
  return joined(split(text, "\n"), "", broken);
}

std::string escape_html(std::string_view text) { return html_escaping.of(text); }

std::string escape_markdown(std::string_view text) { return markdown_escaping.of(text); }

std::string escape_tex(std::string_view text) {
  std::string out;
  char before = ' ';
  while (!text.empty()) {
    std::size_t length = is_word(before) || before == '.' ? 0 : scientific_length(text);
    if (length > 0) {
      const std::size_t e = text.find('e'), sign = text[e + 1] == '+';
      out += fmt::format("${}\\times10^{{{}}}$", text.substr(0, e), text.substr(e + 1 + sign, length - e - 1 - sign));
    } else if ((before == ' ' || before == '(') && text.size() > 1 && text[0] == '-' && is_digit(text[1])) {
      out += "$-$";
      length = 1;
    } else {
      length = tex_escaping.append_first(out, text);
    }
    before = text[length - 1];
    text.remove_prefix(length);
  }
  return out;
}

std::string escape_csv(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-=.,:/%+@";
  if (!text.empty() && text.find_first_not_of(plain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

std::vector<std::string> shell_words(std::string_view text) {
  std::vector<std::string> words;
  bool within = false, quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool ends = text[i] == ' ' && !quoted;
    if (!ends && !within) words.emplace_back();
    within = !ends;
    if (text[i] == '\'' && within)
      quoted = !quoted;
    else if (within)
      words.back() += text[i] == '\\' && !quoted && i + 1 < text.size() ? text[++i] : text[i];
  }
  return words;
}

std::string slug(std::string_view text) {
  constexpr std::string_view prefix = "builtin:";
  if (text.starts_with(prefix)) text.remove_prefix(prefix.size());
  std::string out;
  for (const char c : text)
    if (is_word(c))
      out += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    else if (!out.empty() && out.back() != '-')
      out += '-';
  while (!out.empty() && out.back() == '-') out.pop_back();
  return out.empty() ? "scene" : out.substr(0, 80);
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < left ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace etendue
