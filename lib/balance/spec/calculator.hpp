#pragma once
/// Arithmetic on text: numbers, names, + − * / ^, parentheses, comparisons, sqrt, sin, cos and the like, pi. Angles of
/// trigonometric functions are in radians. A point is the decimal mark whatever the locale.

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::read {

/// The expression cannot be evaluated; the message says what is wrong with it.
struct ExpressionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Calculator {
 public:
  Calculator();
  ~Calculator();
  Calculator(Calculator&&) noexcept;
  Calculator& operator=(Calculator&&) noexcept;

  void define(const std::string& name, double value);
  /// May be infinite or not a number. Every name must have been defined. @throws ExpressionError
  double evaluate(const std::string& expression);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Names in an expression in the order of their first use; none in one that is too long.
struct ExpressionNames {
  std::vector<std::string> values;     ///< what is no function and not `pi`
  std::vector<std::string> functions;  ///< followed by a parenthesis
};
ExpressionNames names_in(const std::string& expression);

/// Longer ones are refused, unread.
inline constexpr std::size_t longest_expression = 1000;
/// Of a whole spec; that many take about a second.
inline constexpr std::size_t longest_expressions = 500'000;

/// sqrt, sin, …
const std::vector<std::string>& function_names();

}  // namespace balance::read
