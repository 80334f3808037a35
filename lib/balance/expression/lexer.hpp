#pragma once
/// The words of an expression. Private to expression.

#include <cctype>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>

namespace balance {

/// What a text has at one place: a number, a name or an operator; its end is an empty word.
struct ExpressionToken {
  enum class Kind { end, number, name, symbol };
  Kind kind = Kind::end;
  std::string_view text;
  std::size_t at = 0;  ///< byte of the text
};

inline bool starts_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Goes through a text word by word.
class ExpressionLexer {
 public:
  explicit ExpressionLexer(std::string_view text) : text_(text) {}

  /// The next word, and on.
  ExpressionToken next() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
    ExpressionToken word{ExpressionToken::Kind::end, text_.substr(at_, length()), at_};
    if (!word.text.empty()) word.kind = kind(word.text);
    at_ += word.text.size();
    return word;
  }

 private:
  static bool digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
  char peek(std::size_t ahead) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  bool is_number() const { return digit(peek(0)) || (peek(0) == '.' && digit(peek(1))); }

  ExpressionToken::Kind kind(std::string_view word) const {
    if (digit(word[0]) || (word[0] == '.' && word.size() > 1)) return ExpressionToken::Kind::number;
    return starts_name(word[0]) ? ExpressionToken::Kind::name : ExpressionToken::Kind::symbol;
  }

  std::size_t length() const {
    if (at_ == text_.size()) return 0;
    if (is_number()) {
      double ignored = 0;
      return static_cast<std::size_t>(std::from_chars(&text_[at_], text_.data() + text_.size(), ignored).ptr -
                                      &text_[at_]);
    }
    std::size_t n = 1;
    if (starts_name(peek(0))) {
      // names of parts hang together by points
      while (starts_name(peek(n)) || digit(peek(n)) || (peek(n) == '.' && starts_name(peek(n + 1)))) ++n;
      return n;
    }
    // a character of several bytes is one word
    while ((static_cast<unsigned char>(peek(n)) & 0xC0) == 0x80) ++n;
    if (n > 1) return n;
    for (const std::string_view two : {"<=", ">=", "==", "!=", "&&", "||"})
      if (text_.substr(at_, 2) == two) return 2;
    return 1;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace balance
