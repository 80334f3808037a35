#include "balance/interface/import/model_simplification.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/import/spec_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

namespace balance::foreign {

namespace {

constexpr double water_density = 1000;  // [kg/m³]
constexpr double max_density = 22'600;  // osmium [kg/m³]

Vector3 principal_moments(const Matrix3& inertia) {
  return Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
}

/// The nearest inertia that a body can have: Σ = tr(I)/2 − I with its negative eigenvalues set to zero.
Vector3 nearest_physical_moments(const Vector3& principal) {
  const Vector3 sigma = (Vector3::Constant(principal.sum() / 2) - principal).cwiseMax(0);
  return Vector3::Constant(sigma.sum()) - sigma;
}

std::string moments_text(const Vector3& v) { return fmt::format("{:.6g}, {:.6g}, {:.6g} kg m²", v[0], v[1], v[2]); }

class MassLinter {
 public:
  explicit MassLinter(ForeignModel& robot) : robot_(robot) {
    for (const ForeignJoint& one : robot.joints) {
      const double offset = std::max(one.joint.point_first.norm(), one.joint.point_second.norm());
      offsets_.push_back(offset);
      reach_ += offset;
    }
    std::sort(offsets_.begin(), offsets_.end());
    find_fixed_bodies();
  }

  void run() {
    for (std::size_t b = 0; b < robot_.bodies.size(); ++b)
      if (robot_.bodies[b].is_active) check(static_cast<int>(b));
    check_total_mass();
  }

 private:
  void check_total_mass() {
    bool moves = false, heavy = false;
    for (std::size_t b = 1; b < robot_.bodies.size(); ++b) {
      const ForeignBody& one = robot_.bodies[b];
      if (!one.is_active || standing_.count(static_cast<int>(b)) > 0) continue;
      moves = true;
      heavy = heavy || one.body.mass > 0;
    }
    if (moves && !heavy)
      robot_.findings.push_back({Severity::warning,
                                 {.file = robot_.file},
                                 "no-mass",
                                 "",
                                 "no body that moves has mass: there are motions, but no forces or efforts to find"});
  }

  /// Bodies fixed to what does not move: what is wrong with them changes nothing.
  void find_fixed_bodies() {
    standing_.insert(0);
    for (bool growing = true; growing;) {
      growing = false;
      for (const ForeignJoint& one : robot_.joints) {
        if (!one.is_active || one.joint.type != JointType::fixed) continue;
        const bool first = standing_.count(one.joint.first) > 0, second = standing_.count(one.joint.second) > 0;
        if (first == second) continue;
        standing_.insert({one.joint.first, one.joint.second});
        growing = true;
      }
    }
  }

  void add_finding(int body, Severity level, const char* code, const std::string& message) {
    const ForeignBody& one = robot_.bodies[static_cast<std::size_t>(body)];
    const bool standing = standing_.count(body) > 0;
    robot_.findings.push_back(
        {standing ? Severity::note : level, one.place, code,
         fmt::format("{} {}", robot_.format == "URDF" ? "link" : "body", quote_for_message(one.body.name)),
         message + (standing ? "; it stands still, so its mass does not matter" : "")});
  }

  /// It hangs on a joint that is not fixed.
  const ForeignJoint* moving_joint(int body) const {
    for (const ForeignJoint& one : robot_.joints)
      if (one.is_active && !one.is_loop_closure && one.joint.second == body &&
          joint_degrees_of_freedom(one.joint.type) > 0)
        return &one;
    return nullptr;
  }

  void check(int b) {
    const Body& body = robot_.bodies[static_cast<std::size_t>(b)].body;
    const bool point = body.inertia.isZero(0);
    if (robot_.bodies[static_cast<std::size_t>(b)].has_unknown_mass)
      add_finding(b, Severity::warning, "geom-mass", "has geoms but no <inertial>: taken as massless");
    if (body.mass == 0) {
      if (robot_.bodies[static_cast<std::size_t>(b)].is_marker) return;
      if (!point) add_finding(b, Severity::warning, "massless-inertia", "has an inertia but no mass");
      const ForeignJoint* joint = moving_joint(b);
      if (point && joint != nullptr && standing_.count(b) == 0)
        add_finding(b, Severity::note, "massless",
                    fmt::format("has no mass: it moves with joint {} and what it carries",
                                quote_for_message(joint->joint.name)));
      return;
    }
    if (point) {
      if (standing_.count(b) == 0)
        add_finding(b, Severity::note, "point",
                    fmt::format("is a point mass of {:.6g} kg, without inertia", body.mass));
      return;
    }
    if (check_triangle_inequality(b, body)) check_size(b, body);
  }

  bool check_triangle_inequality(int b, const Body& body) {
    if (!violates_triangle_inequality(body.inertia, robot_.space)) return true;
    if (robot_.space == SpaceKind::planar) {
      add_finding(b, Severity::warning, "indefinite",
                  fmt::format("no body has the inertia {:.6g} kg m²", body.inertia(2, 2)));
      return false;
    }
    const Vector3 moments = principal_moments(body.inertia);
    const std::string nearest = "nearest that one can have: " + moments_text(nearest_physical_moments(moments));
    if (moments[0] < 0)
      add_finding(
          b, Severity::warning, "indefinite",
          fmt::format(
              "no body has this inertia: it is indefinite, with the principal moments {} (the least is {:.6g}); {}",
              moments_text(moments), moments[0], nearest));
    else if (moments[0] == 0)
      add_finding(b, Severity::warning, "flat", "its inertia has a principal moment of 0: a body without any width");
    else
      add_finding(
          b, Severity::warning, "triangle",
          fmt::format(
              "no body has this inertia: the principal moment {:.6g} exceeds the sum of the others {:.6g} + {:.6g} by "
              "{:.3g} (triangle inequality); {}",
              moments[2], moments[0], moments[1], moments[2] - moments[0] - moments[1], nearest));
    return moments[0] >= 0;
  }

  void check_size(int b, const Body& body) {
    const Vector3 moments =
        robot_.space == SpaceKind::planar ? Vector3::Constant(body.inertia(2, 2)) : principal_moments(body.inertia);
    const double gyration = std::sqrt(moments[2] / body.mass);
    if (is_placeholder(body, gyration))
      return add_finding(
          b, Severity::warning, "placeholder",
          fmt::format("its inertia looks like a placeholder: with {:.6g} kg the radius of gyration is {:.3g} m{}",
                      body.mass, gyration, size_text(b)));
    const double typical = std::max(0.1, reach_);
    const bool all_large = !offsets_.empty() && offsets_[offsets_.size() / 2] > 20;
    if ((body.com.norm() > 10 * typical && body.com.norm() > 1) || gyration > 10 * typical || all_large)
      return add_finding(
          b, Severity::warning, "millimetres",
          fmt::format("its centre of mass is {:.3g} m from its origin and its radius of gyration {:.3g} m: millimetres "
                      "taken for metres?",
                      body.com.norm(), gyration));
    if (robot_.space == SpaceKind::spatial) check_density(b, body, moments);
    check_reference_point(b, body);
  }

  /// The identity, and other round numbers that many bodies share, are what nobody measured.
  static bool is_placeholder(const Body& body, double gyration) {
    const double first = body.inertia(0, 0);
    const bool even = (body.inertia - first * Matrix3::Identity()).isZero(0);
    return even && (first == 1 || first == 100 || first == 10) && gyration > 1;
  }

  std::string size_text(int b) const {
    double size = 0;
    for (const ForeignJoint& one : robot_.joints) {
      if (one.joint.first == b) size = std::max(size, one.joint.point_first.norm());
      if (one.joint.second == b) size = std::max(size, one.joint.point_second.norm());
    }
    return size > 0 ? fmt::format(", the distance between its joints {:.3g} m", size) : "";
  }

  /// Nothing has a smaller radius of gyration than a ball.
  void check_density(int b, const Body& body, const Vector3& moments) {
    const double gyration = std::sqrt(moments.sum() / 3 / body.mass);  // of a ball about an axis
    const double radius = std::sqrt(2.5) * gyration;
    const double implied = body.mass / (4.0 / 3 * std::numbers::pi * elementary::pow(radius, 3));
    if (implied <= max_density) return;
    const double of_water = std::cbrt(3 * body.mass / (4 * std::numbers::pi * water_density));
    add_finding(
        b, Severity::warning, "density",
        fmt::format("{:.6g} kg with the radius of gyration {:.3g} m: a solid ball of that inertia would have {:.3g} "
                    "kg/m³; one of "
                    "1000 kg/m³ would have the radius {:.3g} m",
                    body.mass, gyration, implied, of_water));
  }

  /// About its joint a body's inertia exceeds m c²; about its centre of mass that of a body that begins at its joint does not.
  void check_reference_point(int b, const Body& body) {
    if (robot_.space == SpaceKind::planar || moving_joint(b) == nullptr) return;
    const double offset = body.com.norm();
    const Matrix3 steiner = -body.mass * skew(body.com) * skew(body.com);
    const Matrix3 rest = body.inertia - steiner;
    if (offset == 0 || violates_triangle_inequality(rest, SpaceKind::spatial)) return;
    const double carried = body.mass * offset * offset, left = principal_moments(rest)[2];
    if (left > carried / 2) return;  // it may well reach to both sides of its joint
    const Vector3 seen = body.inertia.diagonal();
    const Eigen::Index largest = max_index(seen);
    static const char* const names[] = {"I_xx", "I_yy", "I_zz"};
    add_finding(
        b, Severity::warning, "about-joint",
        fmt::format(
            "its inertia looks as if about its joint: {} = {:.6g} exceeds m c² = {:.6g}; about its centre of mass it "
            "would be {:.6g}",
            names[largest], seen[largest], carried, rest(largest, largest)));
  }

  ForeignModel& robot_;
  double reach_ = 0;             ///< all joints' offsets in a row [m]
  std::vector<double> offsets_;  ///< increasing
  std::set<int> standing_;
};

}  // namespace

void lint_masses(ForeignModel& robot) { MassLinter(robot).run(); }

}  // namespace balance::foreign
