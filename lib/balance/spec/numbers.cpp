#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"
#include "balance/spec/draft.hpp"
#include "balance/spec/limits.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

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

/// What a designer adds to a mechanism to balance it: not there to begin with.
bool is_extra(const std::string& path) {
  const bool carried = path.starts_with("counterweights.") || path.starts_with("discs.");
  return (carried && (path.ends_with(".mass") || path.ends_with(".inertia"))) ||
         (path.starts_with("springs.") && path.ends_with(".stiffness"));
}

}  // namespace

double read_number(const Cursor& at, Draft& draft, Dimension dimension, Sign sign) {
  const double unit = draft.units.factor(dimension);
  if (!at.is_map()) {
    const double value = draft.parameters.evaluate(at);
    if (!draft.judging()) return value * unit;
    check_sign(at, value, sign);
    return checked(at, value * unit);
  }
  if (draft.given != nullptr) return (*draft.given)[at.path()];
  FreeValue free = draft.parameters.evaluate_free(at);
  if (!free.start_given && is_extra(at.path()) && free.lower <= 0 && free.upper >= 0) free.start = 0;
  // A bound of zero is allowed: the designer may wish to know whether the mass can vanish.
  check_sign(at, free.lower, sign == Sign::any ? Sign::any : Sign::not_negative);
  check_sign(at, free.start, sign);
  const FreeNumber number{.path = at.path(),
                          .lower = checked(at, free.lower * unit),
                          .upper = checked(at, free.upper * unit),
                          .start = checked(at, free.start * unit),
                          .unit = unit};
  if (draft.free_paths.insert(number.path).second) draft.free_numbers.push_back({&at.node(), number});
  return number.start;
}

double read_duration(const Cursor& at, Draft& draft) {
  const double duration = read_number(at, draft, dimension::time, Sign::positive);
  check_duration(at, duration, draft);
  return duration;
}

void check_duration(const Cursor& at, double duration, const Draft& draft) {
  if (!draft.judging() || (duration >= shortest_duration && duration <= longest_duration)) return;
  at.fail({.expected = fmt::format("a duration from {} s to {} s", shortest_duration, longest_duration),
           .found = fmt::format("{:.6g} s", duration)});
}

std::vector<double> read_numbers(const Cursor& at, Draft& draft, Dimension dimension, const std::string& what) {
  std::vector<double> values;
  read_each(at.items(what), [&](const Cursor& item) { values.push_back(read_number(item, draft, dimension)); });
  return values;
}

Vector3 read_vector(const Cursor& at, Draft& draft, Dimension dimension) {
  const std::size_t count = draft.planar() ? 2 : 3;
  Vector3 vector = Vector3::Zero();
  Eigen::Index i = 0;
  read_each(at.items(several_numbers(count), count),
            [&](const Cursor& item) { vector[i++] = read_number(item, draft, dimension); });
  return vector;
}

Vector3 read_direction(const Cursor& at, Draft& draft) {
  const Vector3 direction = read_vector(at, draft, dimension::none);
  const double scale = direction.cwiseAbs().maxCoeff();
  if (!(scale > 0)) {
    if (draft.judging()) at.fail({.expected = "a direction", .found = "zero"});
    return Vector3::UnitX();
  }
  return (direction / scale).normalized();
}

long read_whole(const Cursor& at, Draft& draft, long least, long most) {
  const std::string what = fmt::format("a whole number from {} to {}", least, most);
  if (!at.is_scalar()) at.expected(what);
  const double value = draft.parameters.evaluate(at);
  if (!draft.judging()) return std::clamp(std::lround(value), least, most);
  if (value != std::round(value) || value < static_cast<double>(least) || value > static_cast<double>(most))
    at.expected(what);
  return static_cast<long>(value);
}

Matrix3 read_rpy(const Cursor& at, Draft& draft) {
  Vector3 rpy = Vector3::Zero();
  Eigen::Index i = 0;
  read_each(at.items("[roll, pitch, yaw]", 3),
            [&](const Cursor& item) { rpy[i++] = read_number(item, draft, dimension::angle); });
  return rotation_from_rpy(rpy);
}

Matrix3 read_quaternion(const Cursor& at, Draft& draft) {
  at.items("a quaternion [w, x, y, z]", 4);
  const auto values = read_numbers(at, draft, dimension::none, "a quaternion [w, x, y, z]");
  Eigen::Vector4d q = Eigen::Map<const Eigen::Vector4d>(values.data());
  const double scale = q.cwiseAbs().maxCoeff();
  if (!(scale > 0)) {
    if (draft.judging()) at.fail({.expected = "a quaternion [w, x, y, z] that is not zero", .found = "zero"});
    return Matrix3::Identity();
  }
  q = (q / scale).normalized();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

}  // namespace balance::read
