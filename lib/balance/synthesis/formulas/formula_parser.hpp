#pragma once
/// Reads arithmetic in text: numbers, names, + − * / ^, parentheses, functions of one argument. Factors side by side are
/// multiplied; products and quotients are taken from left to right. An element or a member is a name: `k[3]`, `p->l1`, `p["l1"]`.

#include "balance/synthesis/formulas/program_code.hpp"
#include "balance/synthesis/formulas/rational.hpp"

#include <cctype>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

/// Runs a printed program by reading its statements, so that what is printed is what is tested.
class ProgramInterpreter {
 public:
  /// @throws FormulaError where it has no statements that can be read
  ProgramInterpreter(const std::string& text, Language language, std::size_t columns);

  /// One of the mechanism's numbers, under the name that its symbol has. One that the program does not use is ignored.
  void set_parameter(const std::string& name, double value);
  /// To be called after numbers have been set.
  void prepare() { execute(prepare_statements_); }
  std::vector<double> compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                      const std::vector<double>& ddq);

 private:
  using Statements = std::vector<std::pair<std::string, std::string>>;  ///< target, expression
  void execute(const Statements& statements);
  void set_array(const char* list, const std::vector<double>& values);

  bool is_c_;
  std::size_t columns_;
  Statements prepare_statements_, torque_statements_;
  std::map<std::string, double> values_;  ///< by name as the program writes it: `p->l1`, `k[3]`
};

/// What numbers and names become is for `Maker`: number(text), name(text), call(function, argument), power(base, whole number).
template <class Value, class Maker>
class FormulaParser {
 public:
  FormulaParser(const std::string& text, Maker& make) : text_(text), make_(make) {}

  /// @throws FormulaError with what is wrong
  Value read() {
    Value value = sum();
    if (peek() != '\0') fail();
    return value;
  }

 private:
  static constexpr int max_depth = 100;

  char peek() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  [[noreturn]] void fail() const {
    throw FormulaError("'" + text_.substr(0, 40) + "' cannot be read from character " + std::to_string(at_ + 1) +
                       " on");
  }
  static bool in_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
  /// The point in `leg1.l`.
  bool is_name_separator() const {
    return text_[at_] == '.' && at_ + 1 < text_.size() && in_name(text_[at_ + 1]) && !is_digit(text_[at_ + 1]);
  }
  /// Takes an index or a member behind a name.
  bool take_element() {
    if (text_.compare(at_, 2, "->") == 0 && at_ + 2 < text_.size() && in_name(text_[at_ + 2])) {
      at_ += 2;
      return true;
    }
    const std::size_t end = at_ < text_.size() && text_[at_] == '[' ? text_.find(']', at_) : std::string::npos;
    if (end == std::string::npos) return false;
    at_ = end + 1;
    return true;
  }
  static bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.'; }
  /// Something that a factor begins with.
  bool factor_follows() {
    const char c = peek();
    return in_name(c) || c == '.' || c == '(';
  }

  Value sum() {
    if (++depth_ > max_depth) fail();
    Value value = signed_product();
    for (;;) {
      if (take('+'))
        value = value + product();
      else if (take('-'))
        value = value - product();
      else
        break;
    }
    --depth_;
    return value;
  }
  /// Whether the signs that stand here come to a minus.
  bool is_negative() {
    bool negative = false;
    for (;;) {
      if (take('-'))
        negative = !negative;
      else if (!take('+'))
        return negative;
    }
  }
  Value signed_product() {
    const bool negative = is_negative();
    return negative ? -product() : product();
  }
  Value product() {
    Value value = power();
    for (;;) {
      if (take('*'))
        value = value * signed_power();
      else if (take('/'))
        value = make_.quotient(value, signed_power());
      else if (factor_follows())
        value = value * power();
      else
        return value;
    }
  }
  Value signed_power() {
    const bool negative = is_negative();
    return negative ? -power() : power();
  }
  Value power() {
    Value base = factor();
    if (!take('^')) return base;
    const bool negative = take('-');
    int exponent = 0, digits = 0;
    for (peek(); at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_])) != 0; ++at_, ++digits)
      exponent = exponent * 10 + (text_[at_] - '0');
    if (digits == 0 || digits > 2 || (at_ < text_.size() && text_[at_] == '.')) fail();
    return make_.power(base, negative ? -exponent : exponent);
  }
  Value factor() {
    const char c = peek();
    const std::size_t begin = at_;
    if (take('(')) {
      Value value = sum();
      if (!take(')')) fail();
      return value;
    }
    if (is_digit(c)) return make_.number(number_text());
    if (!in_name(c)) fail();
    for (bool in = true; in;) {
      in = take_element();
      for (; at_ < text_.size() && (in_name(text_[at_]) || is_name_separator()); ++at_) in = true;
    }
    const std::string name = text_.substr(begin, at_ - begin);
    if (!make_.is_function(name) || peek() != '(') return make_.name(name);
    ++at_;
    Value argument = sum();
    if (!take(')')) fail();
    return make_.call(name, argument);
  }
  std::string number_text() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    const auto digit_at = [&](std::size_t i) {
      return i < text_.size() && std::isdigit(static_cast<unsigned char>(text_[i])) != 0;
    };
    if (at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
      const bool sign = at_ + 1 < text_.size() && (text_[at_ + 1] == '-' || text_[at_ + 1] == '+');
      if (digit_at(at_ + (sign ? 2 : 1)))
        for (at_ += sign ? 2 : 1; digit_at(at_);) ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  const std::string& text_;
  Maker& make_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

// Reads back what has been printed.

/// The value of a formula as the printer writes it.
/// @param values of all names in it
/// @throws FormulaError if it cannot be read or has a name without a value
double evaluate_text(const std::string& text, const std::map<std::string, double>& values);

}  // namespace balance::formulas
