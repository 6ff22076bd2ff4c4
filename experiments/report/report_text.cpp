#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

namespace etendue {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool continues(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

// The length of a figure in scientific notation at the start of `text` ("1.23e-5"), 0 if there is none. `mantissa` gets the
// digits before the e.
std::size_t scientific_length(std::string_view text, std::size_t& mantissa) {
  std::size_t i = 0;
  while (i < text.size() && is_digit(text[i])) ++i;
  if (i == 0) return 0;
  if (i + 1 < text.size() && text[i] == '.' && is_digit(text[i + 1])) {
    ++i;
    while (i < text.size() && is_digit(text[i])) ++i;
  }
  mantissa = i;
  if (i >= text.size() || text[i] != 'e') return 0;
  ++i;
  if (i < text.size() && (text[i] == '-' || text[i] == '+')) ++i;
  const std::size_t exponent = i;
  while (i < text.size() && is_digit(text[i])) ++i;
  if (i == exponent || (i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])))) return 0;
  return i;
}

struct Replacement {
  std::string_view from, to;
};

// What the report's own text uses beyond ASCII, and TeX's special characters.
constexpr std::array<Replacement, 27> tex_replacements{{{"\\", "\\textbackslash{}"},
                                                        {"{", "\\{"},
                                                        {"}", "\\}"},
                                                        {"$", "\\$"},
                                                        {"&", "\\&"},
                                                        {"#", "\\#"},
                                                        {"%", "\\%"},
                                                        {"_", "\\_"},
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
                                                        {"…", "\\dots{}"}}};

}  // namespace

std::string format_figure(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "∞" : "-∞";
  if (value == 0) return "0";
  const double magnitude = std::abs(value);
  if (magnitude >= 99.95 && magnitude < 99999.5) return fmt::format("{:.0f}", value);
  // One notation from 0.01 on, so that an interval around a small error does not mix two.
  if (magnitude >= 0.00995 && magnitude < 99.95) return fmt::format("{:#.3g}", value);
  const std::string text = fmt::format("{:.2e}", value);
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

std::string format_interval(double low, double high) {
  return format_figure(low) + (low < 0 ? " to " : "–") + format_figure(high);
}

std::string format_exact(double value) { return fmt::format("{}", value); }

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return !continues(c); }));
}

std::string padded(std::string_view text, std::size_t width, bool right) {
  const std::size_t used = display_width(text);
  const std::string space(width > used ? width - used : 0, ' ');
  return right ? space + std::string(text) : std::string(text) + space;
}

std::string shortened(std::string_view text, std::size_t width) {
  if (display_width(text) <= width || width == 0) return std::string(text);
  std::size_t end = 0, count = 0;
  for (; end < text.size(); ++end) {
    if (continues(text[end])) continue;
    if (count == width - 1) break;
    ++count;
  }
  return std::string(text.substr(0, end)) + "…";
}

std::string wrapped(std::string_view text, std::size_t width) {
  std::string out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    if (display_width(line) <= width) {
      out += std::string(line) + "\n";
      continue;
    }
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    std::string row(line.substr(0, indent));
    for (std::size_t at = indent; at < line.size();) {
      const std::size_t stop = std::min(line.find(' ', at), line.size());
      const std::string_view word = line.substr(at, stop - at);
      const bool first = row.find_first_not_of(' ') == std::string::npos;
      if (!first && display_width(row) + 1 + display_width(word) > width) {
        out += row + "\n";
        row = std::string(indent + 2, ' ') + std::string(word);
      } else {
        row += (first ? "" : " ") + std::string(word);
      }
      at = stop + 1;
    }
    out += row + "\n";
  }
  return out;
}

std::string escape_html(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        // XML forbids the other control characters even as references.
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string escape_tex(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::string_view rest = text.substr(i);
    std::size_t mantissa = 0;
    const bool word_before = i > 0 && (std::isalnum(static_cast<unsigned char>(text[i - 1])) || text[i - 1] == '.');
    if (const std::size_t length = word_before ? 0 : scientific_length(rest, mantissa)) {
      std::string exponent(rest.substr(mantissa + 1, length - mantissa - 1));
      if (exponent.front() == '+') exponent.erase(0, 1);
      out += fmt::format("${}\\times10^{{{}}}$", rest.substr(0, mantissa), exponent);
      i += length;
      continue;
    }
    const bool opens = i == 0 || text[i - 1] == ' ' || text[i - 1] == '(';
    if (opens && rest.size() > 1 && rest[0] == '-' && is_digit(rest[1])) {
      out += "$-$";
      ++i;
      continue;
    }
    const auto found = std::find_if(tex_replacements.begin(), tex_replacements.end(),
                                    [&](const Replacement& r) { return rest.starts_with(r.from); });
    if (found != tex_replacements.end()) {
      out += found->to;
      i += found->from.size();
    } else {
      const auto c = static_cast<unsigned char>(text[i]);
      out += c < 0x20 ? ' ' : text[i];
      ++i;
    }
  }
  return out;
}

std::string escape_markdown(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '\\' || c == '`' || c == '*' || c == '[') out += '\\';
    if (c == '<')
      out += "&lt;";
    else
      out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

std::string escape_csv(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-=.,:/%+@";
  if (!text.empty() && text.find_first_not_of(plain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
  return word + "'";
}

std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || c == '<' || c == '>' || c == '&') {
      out += fmt::format("\\u{:04x}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string slug(std::string_view text) {
  constexpr std::string_view prefix = "builtin:";
  if (text.starts_with(prefix)) text.remove_prefix(prefix.size());
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80 && std::isalnum(byte))
      out += static_cast<char>(std::tolower(byte));
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
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
