#include "balance/spec/inertia.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/base/rotation.hpp"

#include <fmt/format.h>

namespace balance::read {

namespace {

/// Principal moments printed with six digits still pass.
constexpr double rounding = 1e-6;

}  // namespace

Matrix3 read_inertia_value(const Cursor& at, Draft& draft) {
  Matrix3 inertia = Matrix3::Zero();
  if (draft.planar()) {
    inertia(2, 2) = read_number(at, draft, dimension::inertia);
    return inertia;
  }
  const std::string what = "[Ixx, Iyy, Izz] or [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]";
  if (at.is_list() && at.node().items.size() != 3 && at.node().items.size() != 6) at.expected(what);
  const auto v = read_numbers(at, draft, dimension::inertia, what);
  inertia.diagonal() << v[0], v[1], v[2];
  if (v.size() == 6) {
    inertia(0, 1) = inertia(1, 0) = v[3];
    inertia(0, 2) = inertia(2, 0) = v[4];
    inertia(1, 2) = inertia(2, 1) = v[5];
  }
  return inertia;
}

Matrix3 read_inertia(const Cursor& at, Draft& draft, Bearer bearer, std::optional<double> mass, const Vector3& com) {
  // A mapping with `free` is a free number, not a choice of the reference point.
  const bool is_free =
      at.is_map() && !at.node().keys.empty() && (at.node().keys[0].text == "free" || at.node().keys[0].text == "start");
  Matrix3 inertia = Matrix3::Zero();
  if (!at.is_map() || is_free) {
    inertia = read_inertia_value(at, draft);
  } else {
    std::size_t about = 0;
    const bool read =
        read_fields(at, "an inertia",
                    {{"about", Need::required,
                      [&](const Cursor& c) {
                        about = c.choice("the point that the inertia is about", {"com", "origin"});
                      }},
                     {"value", Need::required, [&](const Cursor& c) { inertia = read_inertia_value(c, draft); }}});
    if (!read) return inertia;
    if (about == 1 && !mass) return inertia;
    if (about == 1) {
      inertia += *mass * skew(com) * skew(com);
      if (draft.planar()) inertia = Vector3(0, 0, inertia(2, 2)).asDiagonal();
    }
  }
  check_inertia(at, inertia, draft, bearer);
  return inertia;
}

void check_inertia(const Cursor& at, const Matrix3& inertia, const Draft& draft, Bearer bearer) {
  if (!draft.judging()) return;
  const bool body = bearer == Bearer::body;
  if (draft.study.mechanism.space == SpaceKind::planar) {
    const double j = inertia(2, 2);
    if (body ? !(j > 0) : j < 0)
      at.fail({.kind = "no body can have this inertia",
               .expected = fmt::format("{} about its CoM", body ? "a positive one" : "one that is not negative"),
               .found = fmt::format("{:.6g} kg m^2", j)});
    return;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia, Eigen::EigenvaluesOnly);
  const Vector3& principal = solver.eigenvalues();  // increasing
  const std::string found = fmt::format("the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2 about its CoM",
                                        principal[0], principal[1], principal[2]);
  const double slack = rounding * principal.cwiseAbs().maxCoeff();
  if (body ? !(principal[0] > 0) : principal[0] < -slack)
    at.fail({.kind = "no body can have this inertia", .expected = "a positive definite matrix", .found = found});
  if (principal[0] + principal[1] < principal[2] - slack)
    at.fail({.kind = "no body can have this inertia",
             .expected = "no principal moment above the sum of the other two",
             .found = found});
}

}  // namespace balance::read
