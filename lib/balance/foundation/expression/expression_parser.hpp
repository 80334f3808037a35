#pragma once
/// Parses arithmetic: numbers, names (`l`, `leg1.l`), + − * / ^, parentheses, comparisons, && and ||, a ? b : c, sqrt,
/// sin, cos and the like, pi. Trigonometric functions take radians. The decimal mark is a point in every locale.

#include "balance/foundation/expression/expression.hpp"

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::expression {

/// The text is not a valid expression. The message says what is wrong and, where applicable, in which column.
struct ExpressionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// @param parameter returns the value of a name; not called for `pi` and function calls
/// @throws ExpressionError, also if the text is longer than max_expression_length; anything that `parameter` throws
Expression parse_expression(const std::string& text,
                            const std::function<Expression(const std::string& name)>& parameter);

/// Names in an expression in the order of their first use; empty if the expression is too long.
struct ExpressionNames {
  std::vector<std::string> values;     ///< other than `pi` and function calls
  std::vector<std::string> functions;  ///< followed by a parenthesis
};
ExpressionNames find_expression_names(const std::string& expression);

/// Renames the values in an expression. Returns it unchanged if it is too long.
std::string rename_expression_values(const std::string& expression,
                                     const std::function<std::string(const std::string& name)>& new_name);

/// Longer expressions are rejected without parsing, which also bounds the recursion depth.
inline constexpr std::size_t max_expression_length = 1000;

/// Names of all functions: sqrt, sin, …
const std::vector<std::string>& function_names();

}  // namespace balance::expression
