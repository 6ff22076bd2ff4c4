// The words of a pbrt file.
#pragma once

#include "framework/io/scene_files.h"

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
//
// A scene may include any file of the disk, and its messages may be read by someone else: what a file says is shown in a
// message only once the file is known as a scene, by a directive it begins.
class PbrtLexer {
 public:
  // `files` reads what the text names.
  PbrtLexer(std::string text, std::string file, SceneFiles& files);
  PbrtLexer(const PbrtLexer&) = delete;
  PbrtLexer& operator=(const PbrtLexer&) = delete;

  Token next();
  const Token& peek();

  const std::shared_ptr<const std::string>& file() const { return file_; }
  SceneFiles& files() { return files_; }
  void know_as_scene() { is_scene_ = true; }
  bool is_scene() const { return is_scene_; }
  // Says what was found, for a message: "the end of the file", "the string 'x'", or "a string" where the file may be no scene.
  std::string describe(const Token& token) const;
  Location where(const Token& token) const { return {*file_, token.line, token.column}; }

 private:
  Token scan();
  void skip_blanks();
  void scan_string(Token& token);
  char advance();
  std::string shown(std::string_view word) const;

  std::string text_;
  std::shared_ptr<const std::string> file_;
  SceneFiles& files_;
  bool is_scene_ = false;
  std::size_t position_;
  int line_ = 1, column_ = 1;
  Token peeked_;
  bool has_peeked_ = false;
  std::deque<std::string> unescaped_;  // strings that differ from their text
};

}  // namespace etendue
