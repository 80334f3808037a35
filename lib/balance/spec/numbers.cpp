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

namespace balance::specification {

namespace {

/// A number and, where an expression made it, what that was.
std::string found_number(const SpecCursor& at, double value) {
  const bool plain = !at.is_scalar() || find_expression_names(at.node().text).values.empty();
  return plain ? fmt::format("{}", value)
               : fmt::format("{}, the value of {}", value, quote_for_message(at.node().text));
}

void check_sign(const SpecCursor& at, double value, SignConstraint sign) {
  if ((sign == SignConstraint::positive && !(value > 0)) || (sign == SignConstraint::positive_or_zero && !(value >= 0)))
    at.fail({.kind = "must be positive", .expected = "a number > 0", .found = found_number(at, value)});
  if (sign == SignConstraint::not_negative && value < 0)
    at.fail({.kind = "must not be negative", .expected = "a number ≥ 0", .found = found_number(at, value)});
}

double require_finite(const SpecCursor& at, double value) {
  if (!std::isfinite(value)) at.fail({.expected = "a number that is finite in SI units", .found = "one that is not"});
  return value;
}

std::string several_numbers(std::size_t count) { return count == 2 ? "[x, y]" : "[x, y, z]"; }

Expression add_free_number(const SpecCursor& at, const std::string& path, const FreeValue& free, double unit,
                           StudyBuilder& draft) {
  FreeNumber number{.key_path = path,
                    .lower = require_finite(at, free.lower * unit),
                    .upper = require_finite(at, free.upper * unit),
                    .start = require_finite(at, free.start * unit),
                    .start_source = free.start_source,
                    .unit = unit};
  for (const double size : free.discrete_values) number.discrete_values.push_back(size * unit);
  const Expression input = draft.add_input(number.start);
  draft.free_numbers.push_back({&at.node(), number, input});
  draft.inputs.emplace(path, input);
  register_free_load_name(path, draft);
  return input;
}

}  // namespace

bool is_fixed_zero(const SpecCursor& at, const Expression& value, const StudyBuilder& draft) {
  if (value.value() != 0 || !at.is_scalar()) return false;
  return value.is_constant() || draft.parameters.free_numbers().empty();
}

namespace {

Expression read_exact(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  const double unit = draft.units.factor(dimension);
  if (!at.is_map()) {
    const Expression value = draft.parameters.evaluate(at);
    check_sign(at, value.value(), sign);
    const Expression number = value * unit;
    require_finite(at, number.value());
    return draft.load_names.empty() ? number : register_load_parameter(at, draft, number, unit, sign);
  }
  if (const auto known = draft.inputs.find(at.path()); known != draft.inputs.end()) return known->second;
  FreeValue free = draft.parameters.evaluate_free(at);
  if (is_added_element_path(at.path())) free.default_start_to_zero();
  // A bound of zero is allowed: the designer may wish to know whether the mass can vanish.
  check_sign(at, free.lower, sign == SignConstraint::none ? SignConstraint::none : SignConstraint::not_negative);
  check_sign(at, free.start, sign);
  return add_free_number(at, at.path(), free, unit, draft);
}

}  // namespace

Expression read_number(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  const Expression number = read_exact(at, draft, dimension, sign);
  return draft.tolerance_names.empty()
             ? number
             : register_toleranced_parameter(at, draft, number, draft.units.factor(dimension), sign);
}

namespace {

constexpr long max_free_list_length = 100;  ///< free numbers in one list

}  // namespace

std::vector<Expression> read_free_list(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                       const char* count_key,
                                       const std::function<long(const SpecCursor&, long)>& numbers_of) {
  long count = 0;
  const FreeValue free = draft.parameters.evaluate_free(
      at, {{count_key, Presence::required,
            [&](const SpecCursor& c) { count = numbers_of(c, read_integer(c, draft, 1, max_free_list_length)); }}});
  std::vector<Expression> values;
  for (long k = 0; k < count; ++k) {
    const std::string path = fmt::format("{}[{}]", at.path(), k);
    values.push_back(add_free_number(at, path, free, draft.units.factor(dimension), draft));
    draft.free_numbers.back().is_list_item = true;
  }
  return values;
}

Expression StudyBuilder::add_input(double value) {
  recording->inputs.push_back(value);
  return Expression::input(recording->graph, value);
}

Expression read_duration(const SpecCursor& at, StudyBuilder& draft) {
  const Expression duration = read_number(at, draft, dimension::time, SignConstraint::positive);
  check_duration(at, duration.value());
  return duration;
}

void check_duration(const SpecCursor& at, double duration) {
  if (!is_valid_duration(duration))
    at.fail({.expected = format_duration_range(), .found = fmt::format("{:.6g} s", duration)});
}

std::vector<Expression> read_numbers(const SpecCursor& at, StudyBuilder& draft, Dimension dimension,
                                     const std::string& what) {
  std::vector<Expression> values;
  read_each(at.items(what), [&](const SpecCursor& item) { values.push_back(read_number(item, draft, dimension)); });
  return values;
}

Vector3E read_vector(const SpecCursor& at, StudyBuilder& draft, Dimension dimension) {
  const std::size_t count = draft.planar() ? 2 : 3;
  Vector3E vector = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items(several_numbers(count), count),
            [&](const SpecCursor& item) { vector[i++] = read_number(item, draft, dimension); });
  return vector;
}

namespace {

Expression largest_size(std::span<const Expression> values) {
  Expression largest = 0;
  for (const Expression& value : values) largest = maximum(largest, abs(value));
  return largest;
}

}  // namespace

Vector3E read_direction(const SpecCursor& at, StudyBuilder& draft) {
  const Vector3E direction = read_vector(at, draft, dimension::dimensionless);
  const Expression scale = largest_size({direction.data(), 3});
  if (!(scale.value() > 0)) at.fail({.expected = "a direction", .found = "zero"});
  return choose(less(0, scale), normalized(direction / scale), Vector3E(Vector3E::UnitX()));
}

long read_integer(const SpecCursor& at, StudyBuilder& draft, long least, long most) {
  const std::string what = fmt::format("a whole number from {} to {}", least, most);
  if (!at.is_scalar()) at.fail_expected(what);
  const double value = draft.parameters.evaluate(at).value();
  if (value != std::round(value) || value < static_cast<double>(least) || value > static_cast<double>(most))
    at.fail_expected(what);
  return static_cast<long>(value);
}

Matrix3E read_rpy(const SpecCursor& at, StudyBuilder& draft) {
  Vector3E rpy = Vector3E::Zero();
  Eigen::Index i = 0;
  read_each(at.items("[roll, pitch, yaw]", 3),
            [&](const SpecCursor& item) { rpy[i++] = read_number(item, draft, dimension::angle); });
  return rotation_from_rpy(rpy);
}

Matrix3E read_quaternion(const SpecCursor& at, StudyBuilder& draft) {
  at.items("a quaternion [w, x, y, z]", 4);
  std::vector<Expression> q = read_numbers(at, draft, dimension::dimensionless, "a quaternion [w, x, y, z]");
  const Expression scale = largest_size(q);
  if (!(scale.value() > 0)) at.fail({.expected = "a quaternion [w, x, y, z] that is not zero", .found = "zero"});
  for (Expression& one : q) one /= scale;
  return choose(less(0, scale), rotation_from_quaternion(q), Matrix3E(Matrix3E::Identity()));
}

}  // namespace balance::specification
