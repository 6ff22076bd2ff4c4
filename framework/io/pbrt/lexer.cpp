#include "framework/io/pbrt/lexer.h"

#include "framework/io/text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }
bool ends_word(char c) { return is_blank(c) || c == '[' || c == ']' || c == '"' || c == '#'; }

}  // namespace

PbrtLexer::PbrtLexer(std::string text, std::string file, SceneFiles& files)
    : text_(std::move(text)),
      file_(std::make_shared<const std::string>(std::move(file))),
      files_(files),
      position_(text_.starts_with(byte_order_mark) ? byte_order_mark.size() : 0) {}

char PbrtLexer::advance() {
  const char c = text_[position_++];
  if (c == '\n' || (c == '\r' && (position_ == text_.size() || text_[position_] != '\n'))) {
    ++line_;
    column_ = 1;
  } else {
    ++column_;
  }
  return c;
}

void PbrtLexer::skip_blanks() {
  while (position_ < text_.size()) {
    if (text_[position_] == '#') {
      while (position_ < text_.size() && text_[position_] != '\n' && text_[position_] != '\r') advance();
    } else if (is_blank(text_[position_])) {
      advance();
    } else {
      return;
    }
  }
}

void PbrtLexer::scan_string(Token& token) {
  advance();
  const std::size_t begin = position_;
  bool escaped = false;
  for (;; advance()) {
    if (position_ == text_.size() || text_[position_] == '\n' || text_[position_] == '\r')
      throw Error(where(token), "this string has no closing quote on its line");
    if (text_[position_] == '"') break;
    if (text_[position_] == '\\' && position_ + 1 < text_.size() && text_[position_ + 1] != '\n' &&
        text_[position_ + 1] != '\r') {
      escaped = true;
      advance();
    }
  }
  token.text = std::string_view(text_).substr(begin, position_ - begin);
  advance();
  if (!escaped) return;
  std::string plain;
  for (std::size_t i = 0; i < token.text.size(); ++i) {
    char c = token.text[i];
    if (c == '\\' && i + 1 < token.text.size()) {
      c = token.text[++i];
      c = c == 'n' ? '\n' : c == 't' ? '\t' : c == 'r' ? '\r' : c;
    }
    plain += c;
  }
  token.text = unescaped_.emplace_back(std::move(plain));
}

Token PbrtLexer::scan() {
  skip_blanks();
  Token token;
  token.line = line_;
  token.column = column_;
  if (position_ == text_.size()) return token;
  const char c = text_[position_];
  if (c == '"') {
    token.kind = TokenKind::string;
    scan_string(token);
    return token;
  }
  if (c == '[' || c == ']') {
    token.kind = c == '[' ? TokenKind::open : TokenKind::close;
    token.text = std::string_view(text_).substr(position_, 1);
    advance();
    return token;
  }
  const std::size_t begin = position_;
  while (position_ < text_.size() && !ends_word(text_[position_])) ++position_;
  column_ += static_cast<int>(position_ - begin);
  token.text = std::string_view(text_).substr(begin, position_ - begin);
  if ((c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.') {
    const auto number = parse_number(token.text);
    if (!number) throw Error(where(token), fmt::format("{} is not a number that single precision holds", shown(token.text)));
    token.kind = TokenKind::number;
    token.number = *number;
    return token;
  }
  const auto is_letter = [](char l) { return (l >= 'a' && l <= 'z') || (l >= 'A' && l <= 'Z'); };
  if (!is_letter(c))
    throw Error(where(token), fmt::format("expected a directive, a string or a number, found {}", shown(token.text)));
  token.kind = TokenKind::word;
  return token;
}

Token PbrtLexer::next() {
  if (!has_peeked_) return scan();
  has_peeked_ = false;
  return peeked_;
}

const Token& PbrtLexer::peek() {
  if (!has_peeked_) {
    peeked_ = scan();
    has_peeked_ = true;
  }
  return peeked_;
}

std::string PbrtLexer::shown(std::string_view word) const { return is_scene_ ? quote(word) : "this word"; }

std::string PbrtLexer::describe(const Token& token) const {
  switch (token.kind) {
    case TokenKind::end:
      return "the end of the file";
    case TokenKind::string:
      return is_scene_ ? "the string " + quote(token.text) : "a string";
    case TokenKind::word:
      return is_scene_ ? quote(token.text) : "a word";
    case TokenKind::number:
      return is_scene_ ? quote(token.text) : "a number";
    default:
      return quote(token.text);
  }
}

}  // namespace etendue
