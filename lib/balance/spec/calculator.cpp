// The only place that knows muParser.

#include "balance/spec/calculator.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <numbers>

namespace balance::read {

struct Calculator::Implementation {
  mu::Parser parser;
};

Calculator::Calculator() : implementation_(std::make_unique<Implementation>()) {
  mu::Parser& parser = implementation_->parser;
  parser.ClearConst();
  parser.DefineConst("pi", std::numbers::pi);
}

Calculator::~Calculator() = default;
Calculator::Calculator(Calculator&&) noexcept = default;
Calculator& Calculator::operator=(Calculator&&) noexcept = default;

void Calculator::define(const std::string& name, double value) {
  try {
    implementation_->parser.DefineConst(name, value);
  } catch (const mu::Parser::exception_type& wrong) {
    throw ExpressionError(wrong.GetMsg());
  }
}

double Calculator::evaluate(const std::string& expression) {
  mu::Parser& parser = implementation_->parser;
  if (expression.size() > longest_expression)
    throw ExpressionError(fmt::format("it is longer than {} characters", longest_expression));
  try {
    parser.SetExpr(expression);
    const double value = parser.Eval();
    if (parser.GetNumResults() != 1) throw ExpressionError("it has more than one value");
    return value;
  } catch (const mu::Parser::exception_type& wrong) {
    std::string message = wrong.GetMsg();
    while (!message.empty() && (message.back() == '.' || message.back() == ' ')) message.pop_back();
    if (!message.empty()) message[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(message[0])));
    throw ExpressionError(message);
  }
}

namespace {

bool starts_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool in_number(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.'; }
bool in_symbol(char c) { return starts_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// The index after the number that starts at `i`, an exponent included.
std::size_t after_number(const std::string& text, std::size_t i) {
  while (i < text.size() && in_number(text[i])) ++i;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    std::size_t digits = i + 1;
    if (digits < text.size() && (text[digits] == '+' || text[digits] == '-')) ++digits;
    if (digits < text.size() && in_number(text[digits])) return after_number(text, digits);
  }
  return i;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

ExpressionNames names_in(const std::string& expression) {
  ExpressionNames names;
  if (expression.size() > longest_expression) return names;
  for (std::size_t i = 0; i < expression.size();) {
    if (in_number(expression[i])) {
      i = after_number(expression, i);
    } else if (starts_name(expression[i])) {
      std::size_t end = i;
      while (end < expression.size() && in_symbol(expression[end])) ++end;
      const std::string name = expression.substr(i, end - i);
      const std::size_t next = expression.find_first_not_of(' ', end);
      const bool call = next != std::string::npos && expression[next] == '(';
      if (call) add_once(names.functions, name);
      if (!call && name != "pi") add_once(names.values, name);
      i = end;
    } else {
      ++i;
    }
  }
  return names;
}

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names{
      "sin",  "cos", "tan", "asin",  "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh",
      "sqrt", "exp", "ln",  "log10", "log2", "abs",  "sign",  "rint", "min",  "max",  "sum",   "avg"};
  return names;
}

}  // namespace balance::read
