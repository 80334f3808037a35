#include "balance/model/fault_list.hpp"

#include "balance/base/extrema.hpp"

#include <array>
#include <cstdio>

namespace balance {

namespace {

constexpr double unit_error = 1e-9;      // directions typed with ten digits pass
constexpr double symmetry_error = 1e-6;  // and inertias typed with six

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

std::string text_of(ElementKind element, std::size_t index, std::string_view name) {
  const std::string kind = name_of(element);
  if (!name.empty()) return kind + " '" + std::string(name) + "'";
  return element == ElementKind::mechanism || element == ElementKind::tool ? kind : kind + " " + std::to_string(index);
}

std::string text_of(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", number);
  return text.data();
}

void ElementFaults::unit(const Vector3& axis, const char* what) {
  if (!finite(axis, what)) return;
  const double length = axis.norm();
  if (!(std::abs(length - 1) <= unit_error))
    add(FaultKind::axis_not_unit, std::string(what) + " must be a unit vector, its length is " + text_of(length));
}

void ElementFaults::place(const Vector3& position, bool planar, const char* what) {
  if (finite(position, what) && planar && position.z() != 0)
    add(FaultKind::out_of_plane,
        std::string(what) + " of a planar mechanism must have z = 0, has " + text_of(position.z()));
}

void check_inertia(const Matrix3& inertia, bool planar, InertiaOf bearer, ElementFaults& faults) {
  if (!faults.finite(inertia, "the inertia")) return;
  const double size = max_abs(inertia);
  Matrix3 rest = inertia;
  rest(2, 2) = 0;
  if (planar && !rest.isZero(0))
    faults.add(FaultKind::out_of_plane, "the inertia of a planar mechanism must have its zz entry alone");
  else if (!(max_abs((inertia - inertia.transpose()) / 2) <= symmetry_error * size))
    return faults.add(FaultKind::inertia_not_symmetric, "the inertia must be a symmetric matrix");
  const InertiaVerdict verdict = judge_inertia(inertia, planar, bearer);
  const Vector3& principal = verdict.principal;
  const std::string found = planar ? ", is " + text_of(principal[2])
                                   : "; its principal moments are " + text_of(principal[0]) + ", " +
                                         text_of(principal[1]) + ", " + text_of(principal[2]);
  const char* positive = !planar                     ? "the inertia must be positive definite"
                         : bearer == InertiaOf::body ? "the inertia must be positive"
                                                     : "the inertia must not be negative";
  if (verdict.flaw == InertiaFlaw::not_positive) faults.add(FaultKind::inertia_not_positive, positive + found);
  if (verdict.flaw == InertiaFlaw::impossible)
    faults.add(FaultKind::inertia_impossible,
               "no principal moment of inertia can be above the sum of the other two" + found);
}

}  // namespace balance
