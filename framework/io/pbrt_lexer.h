// The words of a pbrt file.
#pragma once

#include "framework/core/error.h"

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>

namespace etendue {

enum class TokenKind : std::uint8_t { end, word, string, number, open, close };

struct Token {
  TokenKind kind = TokenKind::end;
  std::string_view text;  // of a word or number as written; of a string without its quotes, escapes resolved
  double number = 0;
  int line = 1, column = 1;
};

// Words, "strings", numbers, [ and ], with # comments between them. Throws Error on anything else. Tokens refer to the lexer's
// text and live as long as it does.
class PbrtLexer {
 public:
  PbrtLexer(std::string text, std::string file)
      : text_(std::move(text)), file_(std::make_shared<const std::string>(std::move(file))) {}
  PbrtLexer(const PbrtLexer&) = delete;
  PbrtLexer& operator=(const PbrtLexer&) = delete;

  Token next();
  const Token& peek();

  const std::shared_ptr<const std::string>& file() const { return file_; }
  Location where(const Token& token) const { return {*file_, token.line, token.column}; }

 private:
  Token scan();
  void skip_blanks();
  void scan_string(Token& token);
  char advance();

  std::string text_;
  std::shared_ptr<const std::string> file_;
  std::size_t position_ = 0;
  int line_ = 1, column_ = 1;
  Token peeked_;
  bool has_peeked_ = false;
  std::deque<std::string> unescaped_;  // strings that differ from their text
};

// "the end of the file", "the string 'x'": what was found, for a message.
std::string describe(const Token& token);

}  // namespace etendue
