#include "balance/model/fault_list.hpp"

#include "balance/base/extrema.hpp"

#include <array>
#include <cstdio>

namespace balance {

namespace {

constexpr double unit_vector_tolerance = 1e-9;       // directions typed with ten digits pass
constexpr double inertia_symmetry_tolerance = 1e-6;  // and inertias typed with six

const char* name_of(ElementKind element) {
  switch (element) {
    case ElementKind::mechanism: return "mechanism";
    case ElementKind::body: return "body";
    case ElementKind::joint: return "joint";
    case ElementKind::coordinate: return "coordinate";
    case ElementKind::coupling: return "coupling";
    case ElementKind::constraint: return "constraint";
    case ElementKind::attachment: return "attachment";
    case ElementKind::disc: return "disc";
    case ElementKind::load: return "load";
    case ElementKind::spring: return "spring";
    case ElementKind::friction: return "friction";
    case ElementKind::actuator: return "actuator";
    case ElementKind::tool: return "tool";
    case ElementKind::assembly: return "assembly";
  }
  return "";
}

}  // namespace

std::string format_element(ElementKind element, std::size_t index, std::string_view name) {
  const std::string kind = name_of(element);
  if (!name.empty()) return kind + " '" + std::string(name) + "'";
  return element == ElementKind::mechanism || element == ElementKind::tool ? kind : kind + " " + std::to_string(index);
}

std::string format_element(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", number);
  return text.data();
}

void ElementValidator::check_unit_vector(const Vector3& axis, const char* what) {
  if (!check_finite(axis, what)) return;
  const double length = axis.norm();
  if (!(std::abs(length - 1) <= unit_vector_tolerance))
    add(ValidationIssueKind::axis_not_unit,
        std::string(what) + " must be a unit vector, its length is " + format_element(length));
}

void ElementValidator::check_position(const Vector3& position, bool planar, const char* what) {
  if (check_finite(position, what) && planar && position.z() != 0)
    add(ValidationIssueKind::out_of_plane,
        std::string(what) + " of a planar mechanism must have z = 0, has " + format_element(position.z()));
}

void check_inertia(const Matrix3& inertia, bool planar, InertiaOwner bearer, ElementValidator& faults) {
  if (!faults.check_finite(inertia, "the inertia")) return;
  const double size = max_abs(inertia);
  Matrix3 rest = inertia;
  rest(2, 2) = 0;
  if (planar && !rest.isZero(0))
    faults.add(ValidationIssueKind::out_of_plane, "the inertia of a planar mechanism must have its zz entry alone");
  else if (!(max_abs((inertia - inertia.transpose()) / 2) <= inertia_symmetry_tolerance * size))
    return faults.add(ValidationIssueKind::inertia_not_symmetric, "the inertia must be a symmetric matrix");
  const InertiaCheck verdict = find_inertia_issue(inertia, planar, bearer);
  const Vector3& principal = verdict.principal_moments;
  const std::string found = planar ? ", is " + format_element(principal[2])
                                   : "; its principal moments are " + format_element(principal[0]) + ", " +
                                         format_element(principal[1]) + ", " + format_element(principal[2]);
  const char* positive = !planar                        ? "the inertia must be positive definite"
                         : bearer == InertiaOwner::body ? "the inertia must be positive"
                                                        : "the inertia must not be negative";
  if (verdict.issue == InertiaIssue::not_positive_definite)
    faults.add(ValidationIssueKind::inertia_not_positive, positive + found);
  if (verdict.issue == InertiaIssue::triangle_violated)
    faults.add(ValidationIssueKind::inertia_triangle_violated,
               "no principal moment of inertia can be above the sum of the other two" + found);
}

}  // namespace balance
