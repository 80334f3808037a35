#include "balance/foundation/expression/expression_parser.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <numbers>
#include <string>
#include <string_view>

namespace balance {

// The words of an expression.

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

namespace {

using Parameter = std::function<Expression(const std::string&)>;
using Arguments = std::vector<Expression>;

/// Functions of several numbers.
struct NamedFunction {
  const char* name;
  std::size_t fewest, most;
  Expression (*value)(const Arguments&);
};

Expression sum(const Arguments& all) {
  Expression total = 0;
  for (const Expression& one : all) total += one;
  return total;
}

template <Expression (*pick)(const Expression&, const Expression&)>
Expression picked(const Arguments& all) {
  Expression result = all[0];
  for (const Expression& one : all) result = pick(result, one);
  return result;
}

constexpr std::size_t unlimited_arguments = max_expression_length;
constexpr NamedFunction variadic_functions[]{
    {"atan2", 2, 2, [](const Arguments& a) { return atan2(a[0], a[1]); }},
    {"min", 1, unlimited_arguments, picked<minimum>},
    {"max", 1, unlimited_arguments, picked<maximum>},
    {"sum", 1, unlimited_arguments, sum},
    {"avg", 1, unlimited_arguments, [](const Arguments& a) { return sum(a) / static_cast<double>(a.size()); }}};

/// Climbs up the operators from those that bind least: `?:`, `||`, `&&`, comparisons, sums, products, signs, powers.
class ExpressionParser {
 public:
  ExpressionParser(const std::string& text, const Parameter& parameter)
      : text_(text), lexer_(text), parameter_(parameter) {
    advance();
  }

  Expression run() {
    const Expression result = conditional();
    if (is(",")) throw ExpressionError("it has more than one value");
    if (word_.kind != ExpressionToken::Kind::end) expected("an operator");
    return result;
  }

 private:
  void advance() { word_ = lexer_.next(); }
  bool is(std::string_view sign) const { return word_.kind == ExpressionToken::Kind::symbol && word_.text == sign; }
  bool take(std::string_view sign) {
    const bool found = is(sign);
    if (found) advance();
    return found;
  }

  [[noreturn]] void expected(std::string_view what) const {
    const std::string wanted(what);
    if (word_.kind == ExpressionToken::Kind::end) throw ExpressionError(wanted + " is missing at its end");
    const auto before = text_.begin() + static_cast<std::ptrdiff_t>(word_.at);
    const auto column = std::count_if(text_.begin(), before, [](char c) { return (c & 0xC0) != 0x80; }) + 1;
    throw ExpressionError("expected " + wanted + ", found '" + std::string(word_.text) + "' in column " +
                          std::to_string(column) + (word_.text == "=" ? "; equal is '=='" : ""));
  }
  void expect(std::string_view sign) {
    if (!take(sign)) expected("'" + std::string(sign) + "'");
  }

  Expression conditional() {
    const Expression condition = disjunction();
    if (!take("?")) return condition;
    const Expression yes = conditional();
    expect(":");
    return select(condition, yes, conditional());
  }

  Expression disjunction() {
    Expression left = conjunction();
    while (take("||")) left = logical_or(left, conjunction());
    return left;
  }

  Expression conjunction() {
    Expression left = comparison();
    while (take("&&")) left = logical_and(left, comparison());
    return left;
  }

  Expression comparison() {
    Expression left = addition();
    while (true) {
      if (take("<"))
        left = less(left, addition());
      else if (take(">"))
        left = less(addition(), left);
      else if (take("<="))
        left = less_equal(left, addition());
      else if (take(">="))
        left = less_equal(addition(), left);
      else if (take("=="))
        left = equal(left, addition());
      else if (take("!="))
        left = 1.0 - equal(left, addition());
      else
        return left;
    }
  }

  Expression addition() {
    Expression left = multiplication();
    while (true) {
      if (take("+"))
        left += multiplication();
      else if (take("-"))
        left -= multiplication();
      else
        return left;
    }
  }

  Expression multiplication() {
    Expression left = signed_power();
    while (true) {
      if (take("*"))
        left *= signed_power();
      else if (take("/"))
        left /= signed_power();
      else
        return left;
    }
  }

  /// −a^b is −(a^b), a^−b^c is a^(−(b^c)).
  Expression signed_power() {
    if (take("-")) return -signed_power();
    if (take("+")) return signed_power();
    const Expression base = operand();
    return take("^") ? power(base, signed_power()) : base;
  }

  Expression operand() {
    const ExpressionToken word = word_;
    if (word.kind == ExpressionToken::Kind::number) {
      advance();
      // too small is zero, too large is infinite
      return std::strtod(std::string(word.text).c_str(), nullptr);
    }
    if (word.kind == ExpressionToken::Kind::name) {
      advance();
      const std::string name(word.text);
      if (take("(")) return function(name);
      return name == "pi" ? Expression(std::numbers::pi) : parameter_(name);
    }
    if (!take("(")) expected("a value");
    const Expression inside = conditional();
    expect(")");
    return inside;
  }

  Expression function(const std::string& name) {
    Arguments arguments;
    while (!is(")")) {
      arguments.push_back(conditional());
      if (!take(",")) break;
      if (is(")")) expected("a value");
    }
    expect(")");
    const auto demand_count = [&](std::size_t fewest, std::size_t most) {
      if (arguments.size() >= fewest && arguments.size() <= most) return;
      throw ExpressionError("the function '" + name + "' takes " + (most > fewest ? "at least " : "") +
                            std::to_string(fewest) + (fewest == 1 ? " argument" : " arguments") + ", not " +
                            std::to_string(arguments.size()));
    };
    for (const NamedFunction& one : variadic_functions)
      if (name == one.name) {
        demand_count(one.fewest, one.most);
        return one.value(arguments);
      }
    const int unary = find_unary_function(name);
    if (unary == static_cast<int>(list_unary_functions().size()))
      throw ExpressionError("there is no function '" + name + "'");
    demand_count(1, 1);
    return apply(unary, arguments[0]);
  }

  const std::string& text_;
  ExpressionLexer lexer_;
  const Parameter& parameter_;
  ExpressionToken word_;
};

void add_once(std::vector<std::string>& names, std::string_view name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
}

}  // namespace

Expression parse_expression(const std::string& text, const Parameter& parameter) {
  if (text.size() > max_expression_length)
    throw ExpressionError("it is longer than " + std::to_string(max_expression_length) + " characters");
  return ExpressionParser(text, parameter).run();
}

ExpressionNames find_expression_names(const std::string& expression) {
  ExpressionNames names;
  if (expression.size() > max_expression_length) return names;
  ExpressionLexer lexer(expression);
  ExpressionToken word = lexer.next();
  while (word.kind != ExpressionToken::Kind::end) {
    const ExpressionToken next = lexer.next();
    const bool call = next.kind == ExpressionToken::Kind::symbol && next.text == "(";
    if (word.kind == ExpressionToken::Kind::name && call) add_once(names.functions, word.text);
    if (word.kind == ExpressionToken::Kind::name && !call && word.text != "pi") add_once(names.values, word.text);
    word = next;
  }
  return names;
}

std::string rename_expression_values(const std::string& expression,
                                     const std::function<std::string(const std::string&)>& other) {
  if (expression.size() > max_expression_length) return expression;
  std::string text;
  std::size_t copied = 0;
  ExpressionLexer lexer(expression);
  ExpressionToken word = lexer.next();
  while (word.kind != ExpressionToken::Kind::end) {
    const ExpressionToken next = lexer.next();
    const bool call = next.kind == ExpressionToken::Kind::symbol && next.text == "(";
    if (word.kind == ExpressionToken::Kind::name && !call && word.text != "pi") {
      text += expression.substr(copied, word.at - copied) + other(std::string(word.text));
      copied = word.at + word.text.size();
    }
    word = next;
  }
  return text + expression.substr(copied);
}

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const UnaryFunction& f : list_unary_functions()) all.emplace_back(f.name);
    for (const NamedFunction& f : variadic_functions) all.emplace_back(f.name);
    return all;
  }();
  return names;
}

}  // namespace balance
