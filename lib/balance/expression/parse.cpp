#include "balance/expression/parse.hpp"

#include "balance/expression/lexer.hpp"

#include <algorithm>
#include <numbers>

namespace balance {

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

constexpr std::size_t any_number = longest_expression;
constexpr NamedFunction several[]{
    {"atan2", 2, 2, [](const Arguments& a) { return atan2(a[0], a[1]); }},
    {"min", 1, any_number, picked<minimum>},
    {"max", 1, any_number, picked<maximum>},
    {"sum", 1, any_number, sum},
    {"avg", 1, any_number, [](const Arguments& a) { return sum(a) / static_cast<double>(a.size()); }}};

/// Climbs up the operators from those that bind least: `?:`, `||`, `&&`, comparisons, sums, products, signs, powers.
class Parser {
 public:
  Parser(const std::string& text, const Parameter& parameter) : text_(text), lexer_(text), parameter_(parameter) {
    advance();
  }

  Expression run() {
    const Expression result = choice();
    if (is(",")) throw ExpressionError("it has more than one value");
    if (word_.kind != Word::Kind::end) expected("an operator");
    return result;
  }

 private:
  void advance() { word_ = lexer_.next(); }
  bool is(std::string_view sign) const { return word_.kind == Word::Kind::sign && word_.text == sign; }
  bool take(std::string_view sign) {
    const bool found = is(sign);
    if (found) advance();
    return found;
  }

  [[noreturn]] void expected(std::string_view what) const {
    const std::string wanted(what);
    if (word_.kind == Word::Kind::end) throw ExpressionError(wanted + " is missing at its end");
    const auto before = text_.begin() + static_cast<std::ptrdiff_t>(word_.at);
    const auto column = std::count_if(text_.begin(), before, [](char c) { return (c & 0xC0) != 0x80; }) + 1;
    throw ExpressionError("expected " + wanted + ", found '" + std::string(word_.text) + "' in column " +
                          std::to_string(column) + (word_.text == "=" ? "; equal is '=='" : ""));
  }
  void demand(std::string_view sign) {
    if (!take(sign)) expected("'" + std::string(sign) + "'");
  }

  Expression choice() {
    const Expression condition = disjunction();
    if (!take("?")) return condition;
    const Expression yes = choice();
    demand(":");
    return choose(condition, yes, choice());
  }

  Expression disjunction() {
    Expression left = conjunction();
    while (take("||")) left = either(left, conjunction());
    return left;
  }

  Expression conjunction() {
    Expression left = comparison();
    while (take("&&")) left = both(left, comparison());
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
        left = at_most(left, addition());
      else if (take(">="))
        left = at_most(addition(), left);
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
    const Word word = word_;
    if (word.kind == Word::Kind::number) {
      advance();
      // too small is zero, too large is infinite
      return std::strtod(std::string(word.text).c_str(), nullptr);
    }
    if (word.kind == Word::Kind::name) {
      advance();
      const std::string name(word.text);
      if (take("(")) return function(name);
      return name == "pi" ? Expression(std::numbers::pi) : parameter_(name);
    }
    if (!take("(")) expected("a value");
    const Expression inside = choice();
    demand(")");
    return inside;
  }

  Expression function(const std::string& name) {
    Arguments arguments;
    while (!is(")")) {
      arguments.push_back(choice());
      if (!take(",")) break;
      if (is(")")) expected("a value");
    }
    demand(")");
    const auto demand_count = [&](std::size_t fewest, std::size_t most) {
      if (arguments.size() >= fewest && arguments.size() <= most) return;
      throw ExpressionError("the function '" + name + "' takes " + (most > fewest ? "at least " : "") +
                            std::to_string(fewest) + (fewest == 1 ? " argument" : " arguments") + ", not " +
                            std::to_string(arguments.size()));
    };
    for (const NamedFunction& one : several)
      if (name == one.name) {
        demand_count(one.fewest, one.most);
        return one.value(arguments);
      }
    const int unary = unary_function(name);
    if (unary == static_cast<int>(unary_functions().size()))
      throw ExpressionError("there is no function '" + name + "'");
    demand_count(1, 1);
    return apply(unary, arguments[0]);
  }

  const std::string& text_;
  Lexer lexer_;
  const Parameter& parameter_;
  Word word_;
};

void add_once(std::vector<std::string>& names, std::string_view name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
}

}  // namespace

Expression parse_expression(const std::string& text, const Parameter& parameter) {
  if (text.size() > longest_expression)
    throw ExpressionError("it is longer than " + std::to_string(longest_expression) + " characters");
  return Parser(text, parameter).run();
}

ExpressionNames names_in(const std::string& expression) {
  ExpressionNames names;
  if (expression.size() > longest_expression) return names;
  Lexer lexer(expression);
  Word word = lexer.next();
  while (word.kind != Word::Kind::end) {
    const Word next = lexer.next();
    const bool call = next.kind == Word::Kind::sign && next.text == "(";
    if (word.kind == Word::Kind::name && call) add_once(names.functions, word.text);
    if (word.kind == Word::Kind::name && !call && word.text != "pi") add_once(names.values, word.text);
    word = next;
  }
  return names;
}

std::string with_names(const std::string& expression, const std::function<std::string(const std::string&)>& other) {
  if (expression.size() > longest_expression) return expression;
  std::string text;
  std::size_t copied = 0;
  Lexer lexer(expression);
  Word word = lexer.next();
  while (word.kind != Word::Kind::end) {
    const Word next = lexer.next();
    const bool call = next.kind == Word::Kind::sign && next.text == "(";
    if (word.kind == Word::Kind::name && !call && word.text != "pi") {
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
    for (const UnaryFunction& f : unary_functions()) all.emplace_back(f.name);
    for (const NamedFunction& f : several) all.emplace_back(f.name);
    return all;
  }();
  return names;
}

}  // namespace balance
