#include "balance/foundation/expression/expression_parser.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <numbers>
#include <string>
#include <string_view>

namespace balance::expression {

// Tokens of an expression.

/// A number, a name or an operator. The end of the text is an empty token.
struct ExpressionToken {
  enum class Kind { end, number, name, symbol };
  Kind kind = Kind::end;
  std::string_view text;
  std::size_t offset = 0;  ///< byte offset in the text
};

inline bool starts_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Splits a text into tokens.
class ExpressionLexer {
 public:
  explicit ExpressionLexer(std::string_view text) : text_(text) {}

  /// Returns the next token and advances past it.
  ExpressionToken next() {
    while (position_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[position_])) != 0) ++position_;
    ExpressionToken token{ExpressionToken::Kind::end, text_.substr(position_, length()), position_};
    if (!token.text.empty()) token.kind = kind(token.text);
    position_ += token.text.size();
    return token;
  }

 private:
  static bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
  char peek(std::size_t ahead) const { return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0'; }
  bool is_number() const { return is_digit(peek(0)) || (peek(0) == '.' && is_digit(peek(1))); }

  ExpressionToken::Kind kind(std::string_view token) const {
    if (is_digit(token[0]) || (token[0] == '.' && token.size() > 1)) return ExpressionToken::Kind::number;
    return starts_name(token[0]) ? ExpressionToken::Kind::name : ExpressionToken::Kind::symbol;
  }

  std::size_t length() const {
    if (position_ == text_.size()) return 0;
    if (is_number()) {
      double ignored = 0;
      return static_cast<std::size_t>(std::from_chars(&text_[position_], text_.data() + text_.size(), ignored).ptr -
                                      &text_[position_]);
    }
    std::size_t n = 1;
    if (starts_name(peek(0))) {
      // names of parts are joined by points
      while (starts_name(peek(n)) || is_digit(peek(n)) || (peek(n) == '.' && starts_name(peek(n + 1)))) ++n;
      return n;
    }
    // a multi-byte character is one token
    while ((static_cast<unsigned char>(peek(n)) & 0xC0) == 0x80) ++n;
    if (n > 1) return n;
    for (const std::string_view symbol : {"<=", ">=", "==", "!=", "&&", "||"})
      if (text_.substr(position_, 2) == symbol) return 2;
    return 1;
  }

  std::string_view text_;
  std::size_t position_ = 0;
};

namespace {

using Parameter = std::function<Expression(const std::string&)>;
using Arguments = std::vector<Expression>;

/// Functions of several arguments.
struct NamedFunction {
  const char* name;
  std::size_t min_arguments, max_arguments;
  Expression (*value)(const Arguments&);
};

Expression sum(const Arguments& arguments) {
  Expression total = 0;
  for (const Expression& argument : arguments) total += argument;
  return total;
}

template <Expression (*operation)(const Expression&, const Expression&)>
Expression fold(const Arguments& arguments) {
  Expression result = arguments[0];
  for (const Expression& argument : arguments) result = operation(result, argument);
  return result;
}

constexpr std::size_t unlimited_arguments = max_expression_length;
constexpr NamedFunction variadic_functions[]{
    {"atan2", 2, 2, [](const Arguments& a) { return atan2(a[0], a[1]); }},
    {"min", 1, unlimited_arguments, fold<minimum>},
    {"max", 1, unlimited_arguments, fold<maximum>},
    {"sum", 1, unlimited_arguments, sum},
    {"avg", 1, unlimited_arguments, [](const Arguments& a) { return sum(a) / static_cast<double>(a.size()); }}};

/// Recursive descent from the lowest precedence: `?:`, `||`, `&&`, comparisons, sums, products, signs, powers.
class ExpressionParser {
 public:
  ExpressionParser(const std::string& text, const Parameter& parameter)
      : text_(text), lexer_(text), parameter_(parameter) {
    advance();
  }

  Expression run() {
    const Expression result = conditional();
    if (is_at(",")) throw ExpressionError("it has more than one value");
    if (token_.kind != ExpressionToken::Kind::end) throw_expected("an operator");
    return result;
  }

 private:
  void advance() { token_ = lexer_.next(); }
  bool is_at(std::string_view sign) const {
    return token_.kind == ExpressionToken::Kind::symbol && token_.text == sign;
  }
  bool accept(std::string_view sign) {
    const bool found = is_at(sign);
    if (found) advance();
    return found;
  }

  [[noreturn]] void throw_expected(std::string_view what) const {
    const std::string expectation(what);
    if (token_.kind == ExpressionToken::Kind::end) throw ExpressionError(expectation + " is missing at its end");
    const auto token_begin = text_.begin() + static_cast<std::ptrdiff_t>(token_.offset);
    const auto column = std::count_if(text_.begin(), token_begin, [](char c) { return (c & 0xC0) != 0x80; }) + 1;
    throw ExpressionError("expected " + expectation + ", found '" + std::string(token_.text) + "' in column " +
                          std::to_string(column) + (token_.text == "=" ? "; use '==' to compare" : ""));
  }
  void expect(std::string_view sign) {
    if (!accept(sign)) throw_expected("'" + std::string(sign) + "'");
  }

  Expression conditional() {
    const Expression condition = disjunction();
    if (!accept("?")) return condition;
    const Expression if_true = conditional();
    expect(":");
    return select(condition, if_true, conditional());
  }

  Expression disjunction() {
    Expression left = conjunction();
    while (accept("||")) left = logical_or(left, conjunction());
    return left;
  }

  Expression conjunction() {
    Expression left = comparison();
    while (accept("&&")) left = logical_and(left, comparison());
    return left;
  }

  Expression comparison() {
    Expression left = addition();
    while (true) {
      if (accept("<"))
        left = less(left, addition());
      else if (accept(">"))
        left = less(addition(), left);
      else if (accept("<="))
        left = less_equal(left, addition());
      else if (accept(">="))
        left = less_equal(addition(), left);
      else if (accept("=="))
        left = equal(left, addition());
      else if (accept("!="))
        left = 1.0 - equal(left, addition());
      else
        return left;
    }
  }

  Expression addition() {
    Expression left = multiplication();
    while (true) {
      if (accept("+"))
        left += multiplication();
      else if (accept("-"))
        left -= multiplication();
      else
        return left;
    }
  }

  Expression multiplication() {
    Expression left = signed_power();
    while (true) {
      if (accept("*"))
        left *= signed_power();
      else if (accept("/"))
        left /= signed_power();
      else
        return left;
    }
  }

  /// −a^b is −(a^b), a^−b^c is a^(−(b^c)).
  Expression signed_power() {
    if (accept("-")) return -signed_power();
    if (accept("+")) return signed_power();
    const Expression base = operand();
    return accept("^") ? power(base, signed_power()) : base;
  }

  Expression operand() {
    const ExpressionToken token = token_;
    if (token.kind == ExpressionToken::Kind::number) {
      advance();
      // underflow gives zero, overflow infinity
      return std::strtod(std::string(token.text).c_str(), nullptr);
    }
    if (token.kind == ExpressionToken::Kind::name) {
      advance();
      const std::string name(token.text);
      if (accept("(")) return function(name);
      return name == "pi" ? Expression(std::numbers::pi) : parameter_(name);
    }
    if (!accept("(")) throw_expected("a value");
    const Expression value = conditional();
    expect(")");
    return value;
  }

  Expression function(const std::string& name) {
    Arguments arguments;
    while (!is_at(")")) {
      arguments.push_back(conditional());
      if (!accept(",")) break;
      if (is_at(")")) throw_expected("a value");
    }
    expect(")");
    const auto demand_count = [&](std::size_t min_arguments, std::size_t max_arguments) {
      if (arguments.size() >= min_arguments && arguments.size() <= max_arguments) return;
      throw ExpressionError("the function '" + name + "' takes " + (max_arguments > min_arguments ? "at least " : "") +
                            std::to_string(min_arguments) + (min_arguments == 1 ? " argument" : " arguments") +
                            ", not " + std::to_string(arguments.size()));
    };
    for (const NamedFunction& variadic : variadic_functions)
      if (name == variadic.name) {
        demand_count(variadic.min_arguments, variadic.max_arguments);
        return variadic.value(arguments);
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
  ExpressionToken token_;
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
  ExpressionToken token = lexer.next();
  while (token.kind != ExpressionToken::Kind::end) {
    const ExpressionToken next = lexer.next();
    const bool call = next.kind == ExpressionToken::Kind::symbol && next.text == "(";
    if (token.kind == ExpressionToken::Kind::name && call) add_once(names.functions, token.text);
    if (token.kind == ExpressionToken::Kind::name && !call && token.text != "pi") add_once(names.values, token.text);
    token = next;
  }
  return names;
}

std::string rename_expression_values(const std::string& expression,
                                     const std::function<std::string(const std::string&)>& new_name) {
  if (expression.size() > max_expression_length) return expression;
  std::string text;
  std::size_t copied = 0;
  ExpressionLexer lexer(expression);
  ExpressionToken token = lexer.next();
  while (token.kind != ExpressionToken::Kind::end) {
    const ExpressionToken next = lexer.next();
    const bool call = next.kind == ExpressionToken::Kind::symbol && next.text == "(";
    if (token.kind == ExpressionToken::Kind::name && !call && token.text != "pi") {
      text += expression.substr(copied, token.offset - copied) + new_name(std::string(token.text));
      copied = token.offset + token.text.size();
    }
    token = next;
  }
  return text + expression.substr(copied);
}

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all_names;
    for (const UnaryFunction& f : list_unary_functions()) all_names.emplace_back(f.name);
    for (const NamedFunction& f : variadic_functions) all_names.emplace_back(f.name);
    return all_names;
  }();
  return names;
}

}  // namespace balance::expression
