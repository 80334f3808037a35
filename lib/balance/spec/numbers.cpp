#include "balance/base/nearest.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/spec/added_amounts.hpp"
#include "balance/spec/directions.hpp"
#include "balance/spec/load_cases.hpp"
#include "balance/spec/tolerances.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace balance::read {

namespace {

/// A number and, where an expression made it, what that was.
std::string found_number(const Cursor& at, double value) {
  const bool plain = !at.is_scalar() || names_in(at.node().text).values.empty();
  return plain ? fmt::format("{}", value) : fmt::format("{}, the value of {}", value, in_quotes(at.node().text));
}

void check_sign(const Cursor& at, double value, Sign sign) {
  if ((sign == Sign::positive && !(value > 0)) || (sign == Sign::positive_or_zero && !(value >= 0)))
    at.fail({.kind = "must be positive", .expected = "a number > 0", .found = found_number(at, value)});
  if (sign == Sign::not_negative && value < 0)
    at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = found_number(at, value)});
}

double checked(const Cursor& at, double value) {
  if (!std::isfinite(value)) at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  return value;
}

std::string several_numbers(std::size_t count) { return count == 2 ? "[x, y]" : "[x, y, z]"; }

Expression add_free_number(const Cursor& at, const std::string& path, const FreeValue& free, double unit,
                           Draft& draft) {
  FreeNumber number{.path = path,
                    .lower = checked(at, free.lower * unit),
                    .upper = checked(at, free.upper * unit),
                    .start = checked(at, free.start * unit),
                    .start_from = free.start_from,
                    .unit = unit};
  for (const double size : free.sizes) number.sizes.push_back(size * unit);
  const Expression input = draft.add_input(number.start);
  draft.free_numbers.push_back({&at.node(), number, input});
  draft.inputs.emplace(path, input);
  note_free(path, draft);
  return input;
}

}  // namespace

bool is_stuck_at_zero(const Cursor& at, const Expression& value, const Draft& draft) {
  if (value.value() != 0 || !at.is_scalar()) return false;
  return value.is_constant() || draft.parameters.free_numbers().empty();
}

namespace {

Expression read_exact(const Cursor& at, Draft& draft, Dimension dimension, Sign sign) {
  const double unit = draft.units.factor(dimension);
  if (!at.is_map()) {
    const Expression value = draft.parameters.evaluate(at);
    check_sign(at, value.value(), sign);
    const Expression number = value * unit;
    checked(at, number.value());
    return draft.load_names.empty() ? number : as_load_number(at, draft, number, unit, sign);
  }
  if (const auto known = draft.inputs.find(at.path()); known != draft.inputs.end()) return known->second;
  FreeValue free = draft.parameters.evaluate_free(at);
  if (is_added_amount(at.path())) free.start_at_none();
  // A bound of zero is allowed: the designer may wish to know whether the mass can vanish.
  check_sign(at, free.lower, sign == Sign::any ? Sign::any : Sign::not_negative);
  check_sign(at, free.start, sign);
  return add_free_number(at, at.path(), free, unit, draft);
}

}  // namespace

Expression read_number(const Cursor& at, Draft& draft, Dimension dimension, Sign sign) {
  const Expression number = read_exact(at, draft, dimension, sign);
  return draft.tolerance_names.empty() ? number : as_toleranced(at, draft, number, draft.units.factor(dimension), sign);
}

namespace {

constexpr long most_listed = 100;  ///< free numbers in one list

}  // namespace

std::vector<Expression> read_free_list(const Cursor& at, Draft& draft, Dimension dimension, const char* count_key,
                                       const std::function<long(const Cursor&, long)>& numbers_of) {
  long count = 0;
  const FreeValue free = draft.parameters.evaluate_free(
      at, {{count_key, Need::required,
            [&](const Cursor& c) { count = numbers_of(c, read_whole(c, draft, 1, most_listed)); }}});
  std::vector<Expression> values;
  for (long k = 0; k < count; ++k) {
    const std::string path = fmt::format("{}[{}]", at.path(), k);
    values.push_back(add_free_number(at, path, free, draft.units.factor(dimension), draft));
    draft.free_numbers.back().listed = true;
  }
  return values;
}

Expression Draft::add_input(double value) {
  recording->inputs.push_back(value);
  return Expression::input(recording->graph, value);
}

Expression read_duration(const Cursor& at, Draft& draft) {
  const Expression duration = read_number(at, draft, dimension::time, Sign::positive);
  check_duration(at, duration.value());
  return duration;
}

void check_duration(const Cursor& at, double duration) {
  if (!is_duration(duration)) at.fail({.expected = duration_range(), .found = fmt::format("{:.6g} s", duration)});
}

std::vector<Expression> read_numbers(const Cursor& at, Draft& draft, Dimension dimension, const std::string& what) {
  std::vector<Expression> values;
  read_each(at.items(what), [&](const Cursor& item) { values.push_back(read_number(item, draft, dimension)); });
  return values;
}

Vector3E read_vector(const Cursor& at, Draft& draft, Dimension dimension) {
  const std::size_t count = draft.planar() ? 2 : 3;
  Vector3E vector = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items(several_numbers(count), count),
            [&](const Cursor& item) { vector[i++] = read_number(item, draft, dimension); });
  return vector;
}

namespace {

Expression largest_size(std::span<const Expression> values) {
  Expression largest = 0;
  for (const Expression& value : values) largest = maximum(largest, abs(value));
  return largest;
}

}  // namespace

Vector3E read_direction(const Cursor& at, Draft& draft) {
  const Vector3E direction = read_vector(at, draft, dimension::none);
  const Expression scale = largest_size({direction.data(), 3});
  if (!(scale.value() > 0)) at.fail({.expected = "a direction", .found = "zero"});
  return choose(less(0, scale), normalized(direction / scale), Vector3E(Vector3E::UnitX()));
}

long read_whole(const Cursor& at, Draft& draft, long least, long most) {
  const std::string what = fmt::format("a whole number from {} to {}", least, most);
  if (!at.is_scalar()) at.expected(what);
  const double value = draft.parameters.evaluate(at).value();
  if (value != std::round(value) || value < static_cast<double>(least) || value > static_cast<double>(most))
    at.expected(what);
  return static_cast<long>(value);
}

Matrix3E read_rpy(const Cursor& at, Draft& draft) {
  Vector3E rpy = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items("[roll, pitch, yaw]", 3),
            [&](const Cursor& item) { rpy[i++] = read_number(item, draft, dimension::angle); });
  return rotation_from_rpy(rpy);
}

Matrix3E read_quaternion(const Cursor& at, Draft& draft) {
  at.items("a quaternion [w, x, y, z]", 4);
  std::vector<Expression> q = read_numbers(at, draft, dimension::none, "a quaternion [w, x, y, z]");
  const Expression scale = largest_size(q);
  if (!(scale.value() > 0)) at.fail({.expected = "a quaternion [w, x, y, z] that is not zero", .found = "zero"});
  for (Expression& one : q) one /= scale;
  return choose(less(0, scale), rotation_from_quaternion(q), Matrix3E(Matrix3E::Identity()));
}

}  // namespace balance::read
