#pragma once
/// Arithmetic as text: numbers, names (`l`, `leg1.l`), + − * / ^, parentheses, comparisons, && and ||, a ? b : c, sqrt, sin, cos and the
/// like, pi. Angles of trigonometric functions are in radians. A point is the decimal mark whatever the locale.

#include "balance/foundation/expression/expression.hpp"

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// The text is no expression; the message says what is wrong with it and in which column.
struct ExpressionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// @param parameter what a name stands for that is neither `pi` nor a function's
/// @throws ExpressionError, also for a text longer than max_expression_length; whatever `parameter` throws
Expression parse_expression(const std::string& text,
                            const std::function<Expression(const std::string& name)>& parameter);

/// Names in an expression in the order of their first use; none in one that is too long.
struct ExpressionNames {
  std::vector<std::string> values;     ///< what is no function and not `pi`
  std::vector<std::string> functions;  ///< followed by a parenthesis
};
ExpressionNames find_expression_names(const std::string& expression);

/// The expression with another name for each of its values; as it was if it is too long.
std::string rename_expression_values(const std::string& expression,
                                     const std::function<std::string(const std::string& name)>& other);

/// Longer ones are refused, unread: that bounds their depth, too.
inline constexpr std::size_t max_expression_length = 1000;

/// sqrt, sin, …
const std::vector<std::string>& function_names();

}  // namespace balance
