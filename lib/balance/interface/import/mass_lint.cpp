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

/// Principal moments of the nearest inertia that a body can have: Σ = tr(I)/2 − I with
/// negative eigenvalues set to zero.
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
      total_offset_ += offset;
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
    bool has_movable_body = false, has_moving_mass = false;
    for (std::size_t b = 1; b < robot_.bodies.size(); ++b) {
      const ForeignBody& one = robot_.bodies[b];
      if (!one.is_active || grounded_bodies_.count(static_cast<int>(b)) > 0) continue;
      has_movable_body = true;
      has_moving_mass = has_moving_mass || one.body.mass > 0;
    }
    if (has_movable_body && !has_moving_mass)
      robot_.findings.push_back({Severity::warning,
                                 {.file = robot_.file},
                                 "no-mass",
                                 "",
                                 "no moving body has mass: motions can be computed, but not forces or efforts"});
  }

  /// Finds the bodies fixed to the ground: their mass has no effect.
  void find_fixed_bodies() {
    grounded_bodies_.insert(0);
    for (bool has_grown = true; has_grown;) {
      has_grown = false;
      for (const ForeignJoint& one : robot_.joints) {
        if (!one.is_active || one.joint.type != JointType::fixed) continue;
        const bool is_first_grounded = grounded_bodies_.count(one.joint.first) > 0,
                   is_second_grounded = grounded_bodies_.count(one.joint.second) > 0;
        if (is_first_grounded == is_second_grounded) continue;
        grounded_bodies_.insert({one.joint.first, one.joint.second});
        has_grown = true;
      }
    }
  }

  void add_finding(int body, Severity level, const char* code, const std::string& message) {
    const ForeignBody& one = robot_.bodies[static_cast<std::size_t>(body)];
    const bool is_grounded = grounded_bodies_.count(body) > 0;
    robot_.findings.push_back(
        {is_grounded ? Severity::note : level, one.place, code,
         fmt::format("{} {}", robot_.format == "URDF" ? "link" : "body", quote_for_message(one.body.name)),
         message + (is_grounded ? "; it does not move, so its mass does not matter" : "")});
  }

  /// Returns the joint that carries the body if it is movable, else nullptr.
  const ForeignJoint* moving_joint(int body) const {
    for (const ForeignJoint& one : robot_.joints)
      if (one.is_active && !one.is_loop_closure && one.joint.second == body &&
          joint_degrees_of_freedom(one.joint.type) > 0)
        return &one;
    return nullptr;
  }

  void check(int b) {
    const Body& body = robot_.bodies[static_cast<std::size_t>(b)].body;
    const bool is_point_mass = body.inertia.isZero(0);
    if (robot_.bodies[static_cast<std::size_t>(b)].has_unknown_mass)
      add_finding(b, Severity::warning, "geom-mass", "has geoms but no <inertial>: taken as massless");
    if (body.mass == 0) {
      if (robot_.bodies[static_cast<std::size_t>(b)].is_marker) return;
      if (!is_point_mass) add_finding(b, Severity::warning, "massless-inertia", "has an inertia but no mass");
      const ForeignJoint* joint = moving_joint(b);
      if (is_point_mass && joint != nullptr && grounded_bodies_.count(b) == 0)
        add_finding(b, Severity::note, "massless",
                    fmt::format("has no mass: it moves with joint {} and what it carries",
                                quote_for_message(joint->joint.name)));
      return;
    }
    if (is_point_mass) {
      if (grounded_bodies_.count(b) == 0)
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
    const std::string nearest = "nearest possible: " + moments_text(nearest_physical_moments(moments));
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
    const double typical_length = std::max(0.1, total_offset_);
    const bool are_offsets_large = !offsets_.empty() && offsets_[offsets_.size() / 2] > 20;
    if ((body.com.norm() > 10 * typical_length && body.com.norm() > 1) || gyration > 10 * typical_length ||
        are_offsets_large)
      return add_finding(
          b, Severity::warning, "millimetres",
          fmt::format("its centre of mass is {:.3g} m from its origin and its radius of gyration {:.3g} m: millimetres "
                      "taken for metres?",
                      body.com.norm(), gyration));
    if (robot_.space == SpaceKind::spatial) check_density(b, body, moments);
    check_reference_point(b, body);
  }

  /// A round multiple of the identity with a large radius of gyration is a default value, not a measurement.
  static bool is_placeholder(const Body& body, double gyration) {
    const double moment = body.inertia(0, 0);
    const bool is_isotropic = (body.inertia - moment * Matrix3::Identity()).isZero(0);
    return is_isotropic && (moment == 1 || moment == 100 || moment == 10) && gyration > 1;
  }

  std::string size_text(int b) const {
    double size = 0;
    for (const ForeignJoint& one : robot_.joints) {
      if (one.joint.first == b) size = std::max(size, one.joint.point_first.norm());
      if (one.joint.second == b) size = std::max(size, one.joint.point_second.norm());
    }
    return size > 0 ? fmt::format(", the distance between its joints {:.3g} m", size) : "";
  }

  /// At a given density no body has a smaller radius of gyration than a ball.
  void check_density(int b, const Body& body, const Vector3& moments) {
    const double gyration = std::sqrt(moments.sum() / 3 / body.mass);  // of a ball about an axis
    const double radius = std::sqrt(2.5) * gyration;
    const double implied_density = body.mass / (4.0 / 3 * std::numbers::pi * elementary::pow(radius, 3));
    if (implied_density <= max_density) return;
    const double water_radius = std::cbrt(3 * body.mass / (4 * std::numbers::pi * water_density));
    add_finding(
        b, Severity::warning, "density",
        fmt::format("{:.6g} kg with the radius of gyration {:.3g} m: a solid ball of that inertia would have {:.3g} "
                    "kg/m³; one of "
                    "1000 kg/m³ would have the radius {:.3g} m",
                    body.mass, gyration, implied_density, water_radius));
  }

  /// About its joint a body's inertia exceeds m c². About its centre of mass it does not, if
  /// the body begins at its joint.
  void check_reference_point(int b, const Body& body) {
    if (robot_.space == SpaceKind::planar || moving_joint(b) == nullptr) return;
    const double offset = body.com.norm();
    const Matrix3 steiner = -body.mass * skew(body.com) * skew(body.com);
    const Matrix3 central_inertia = body.inertia - steiner;
    if (offset == 0 || violates_triangle_inequality(central_inertia, SpaceKind::spatial)) return;
    const double offset_moment = body.mass * offset * offset, central_moment = principal_moments(central_inertia)[2];
    if (central_moment > offset_moment / 2) return;  // the body may extend to both sides of its joint
    const Vector3 diagonal = body.inertia.diagonal();
    const Eigen::Index largest = numerics::max_index(diagonal);
    static const char* const names[] = {"I_xx", "I_yy", "I_zz"};
    add_finding(
        b, Severity::warning, "about-joint",
        fmt::format(
            "its inertia seems to be about its joint: {} = {:.6g} exceeds m c² = {:.6g}; about its centre of mass it "
            "would be {:.6g}",
            names[largest], diagonal[largest], offset_moment, central_inertia(largest, largest)));
  }

  ForeignModel& robot_;
  double total_offset_ = 0;      ///< sum of all joints' offsets [m]
  std::vector<double> offsets_;  ///< increasing
  std::set<int> grounded_bodies_;
};

}  // namespace

void lint_masses(ForeignModel& robot) { MassLinter(robot).run(); }

}  // namespace balance::foreign
