#pragma once
/// Parses arithmetic: numbers, names, + − * / ^, parentheses, functions of one argument. Adjacent factors are
/// multiplied; products and quotients associate to the left. An element or a member counts as a name: `k[3]`, `p->l1`,
/// `p["l1"]`.

#include "balance/synthesis/formulas/program_code.hpp"
#include "balance/synthesis/formulas/rational.hpp"

#include <cctype>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace balance::formulas {

/// Interprets the statements of a printed program, so that tests run what is printed.
class ProgramInterpreter {
 public:
  /// @throws FormulaError if it has no statements that can be parsed
  ProgramInterpreter(const std::string& text, Language language, std::size_t columns);

  /// Sets one of the mechanism's numbers by the name of its symbol. Numbers that the program does not use are ignored.
  void set_parameter(const std::string& name, double value);
  /// Call after setting numbers.
  void prepare() { execute(functions_.at("prepare")); }
  /// The first array is `tau` of the function `torques` or, with loops, of `tree_torques`.
  std::vector<double> compute_torques(const std::vector<double>& q, const std::vector<double>& dq,
                                      const std::vector<double>& ddq);
  /// Calls a function without branches. @param arguments arrays by name @param results their names and sizes
  std::vector<std::vector<double>> call(const std::string& function,
                                        const std::map<std::string, std::vector<double>>& arguments,
                                        const std::vector<std::pair<std::string, std::size_t>>& results);

 private:
  class Compiler;
  enum class Operation { copy, sum, difference, product, quotient, negative, cosine, sine, root };
  /// register[target] = operation(register[a], register[b])
  struct Instruction {
    Operation operation = Operation::copy;
    int target = 0, a = 0, b = 0;
  };
  int add_register(double value);
  /// The register of a name as the program writes it: `p->l1`, `k[3]`. NaN until it has a value.
  int register_of(const std::string& name);
  void execute(const std::vector<Instruction>& instructions);

  bool is_c_;
  std::size_t columns_;
  std::map<std::string, std::vector<Instruction>> functions_;  ///< those that return nothing, or what they compute
  std::map<std::string, int> names_;                           ///< their registers
  std::vector<double> registers_;
};

/// `Maker` makes the values: number(text), name(text), call(function, argument), power(base, integer), quotient(a, b).
template <class Value, class Maker>
class FormulaParser {
 public:
  FormulaParser(const std::string& text, Maker& factory) : text_(text), factory_(factory) {}

  /// @throws FormulaError that says where parsing failed
  Value read() {
    Value value = sum();
    if (peek() != '\0') fail();
    return value;
  }

 private:
  static constexpr int max_depth = 100;

  char peek() {
    while (position_ < text_.size() && text_[position_] == ' ') ++position_;
    return position_ < text_.size() ? text_[position_] : '\0';
  }
  bool accept(char c) {
    if (peek() != c) return false;
    ++position_;
    return true;
  }
  [[noreturn]] void fail() const {
    throw FormulaError("'" + text_.substr(0, 40) + "' cannot be read from character " + std::to_string(position_ + 1) +
                       " on");
  }
  static bool is_name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }
  /// Whether the next character is the point in `leg1.l`.
  bool is_name_separator() const {
    return text_[position_] == '.' && position_ + 1 < text_.size() && is_name_character(text_[position_ + 1]) &&
           !is_digit(text_[position_ + 1]);
  }
  /// Takes an index or a member after a name.
  bool accept_element() {
    if (text_.compare(position_, 2, "->") == 0 && position_ + 2 < text_.size() &&
        is_name_character(text_[position_ + 2])) {
      position_ += 2;
      return true;
    }
    const std::size_t end =
        position_ < text_.size() && text_[position_] == '[' ? text_.find(']', position_) : std::string::npos;
    if (end == std::string::npos) return false;
    position_ = end + 1;
    return true;
  }
  static bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.'; }
  /// Whether a factor begins here.
  bool starts_factor() {
    const char c = peek();
    return is_name_character(c) || c == '.' || c == '(';
  }

  Value sum() {
    if (++depth_ > max_depth) fail();
    Value value = signed_product();
    for (;;) {
      if (accept('+'))
        value = value + product();
      else if (accept('-'))
        value = value - product();
      else
        break;
    }
    --depth_;
    return value;
  }
  /// Takes the signs here and returns whether they amount to a minus.
  bool parse_negation() {
    bool negative = false;
    for (;;) {
      if (accept('-'))
        negative = !negative;
      else if (!accept('+'))
        return negative;
    }
  }
  Value signed_product() {
    const bool negative = parse_negation();
    return negative ? -product() : product();
  }
  Value product() {
    Value value = power();
    for (;;) {
      if (accept('*'))
        value = value * signed_power();
      else if (accept('/'))
        value = factory_.quotient(value, signed_power());
      else if (starts_factor())
        value = value * power();
      else
        return value;
    }
  }
  Value signed_power() {
    const bool negative = parse_negation();
    return negative ? -power() : power();
  }
  Value power() {
    Value base = factor();
    if (!accept('^')) return base;
    const bool negative = accept('-');
    int exponent = 0, digits = 0;
    for (peek(); position_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[position_])) != 0;
         ++position_, ++digits)
      exponent = exponent * 10 + (text_[position_] - '0');
    if (digits == 0 || digits > 2 || (position_ < text_.size() && text_[position_] == '.')) fail();
    return factory_.power(base, negative ? -exponent : exponent);
  }
  Value factor() {
    const char c = peek();
    const std::size_t begin = position_;
    if (accept('(')) {
      Value value = sum();
      if (!accept(')')) fail();
      return value;
    }
    if (is_digit(c)) return factory_.number(number_text());
    if (!is_name_character(c)) fail();
    for (bool has_more = true; has_more;) {
      has_more = accept_element();
      for (; position_ < text_.size() && (is_name_character(text_[position_]) || is_name_separator()); ++position_)
        has_more = true;
    }
    const std::string name = text_.substr(begin, position_ - begin);
    if (!factory_.is_function(name) || peek() != '(') return factory_.name(name);
    ++position_;
    Value argument = sum();
    if (!accept(')')) fail();
    return factory_.call(name, argument);
  }
  std::string number_text() {
    const std::size_t begin = position_;
    while (position_ < text_.size() && is_digit(text_[position_])) ++position_;
    const auto digit_at = [&](std::size_t i) {
      return i < text_.size() && std::isdigit(static_cast<unsigned char>(text_[i])) != 0;
    };
    if (position_ < text_.size() && (text_[position_] == 'e' || text_[position_] == 'E')) {
      const bool has_sign =
          position_ + 1 < text_.size() && (text_[position_ + 1] == '-' || text_[position_ + 1] == '+');
      if (digit_at(position_ + (has_sign ? 2 : 1)))
        for (position_ += has_sign ? 2 : 1; digit_at(position_);) ++position_;
    }
    return text_.substr(begin, position_ - begin);
  }

  const std::string& text_;
  Maker& factory_;
  std::size_t position_ = 0;
  int depth_ = 0;
};

// Evaluates printed text.

/// The value of a formula as FormulaPrinter writes it.
/// @param values of all names in it
/// @throws FormulaError if it cannot be parsed or contains a name without a value
double evaluate_text(const std::string& text, const std::map<std::string, double>& values);

}  // namespace balance::formulas
