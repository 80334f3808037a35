#pragma once
/// What speed is measured by: the inverse dynamics of three mechanisms written out by hand, each for its mechanism alone, with plain
/// scalars and no library. The mechanisms' numbers are read from their models once.

#include "balance/mechanics/model/mechanism.hpp"

#include <array>

namespace balance::bench {

/// A vector in the plane.
struct Plane {
  double x = 0, y = 0;
};

/// Three revolute joints in the plane, each link's frame at its joint, the next joint on the link's x axis.
class PlanarRrrYardstick {
 public:
  explicit PlanarRrrYardstick(const Mechanism& mechanism);
  /// @param q, dq, ddq joint angles [rad], rates, accelerations  @param torque of the joints [N m]
  void torques(const double* q, const double* dq, const double* ddq, double* torque) const;

 private:
  struct Link {
    double length, mass, inertia;  ///< to the next joint; about the CoM
    Plane com;
  };
  std::array<Link, 3> links_;
  Plane gravity_;
};

/// Everything that a moment of the 3RRR has, in closed form.
struct ThreeRrrMoment {
  struct Leg {
    Plane crank, coupler;  ///< their directions
    double crank_rate, coupler_rate, crank_acceleration, coupler_acceleration;
    Plane force_A, force_B, force_C;  ///< on the crank, on the coupler, on the platform [N]
    double torque, power;             ///< of the drive [N m], [W]
  };
  std::array<Leg, 3> legs;
  Plane tool, com, shaking_force;
  double shaking_moment;  ///< about the origin
};

/// The 3RRR with parallel planes of symmetric legs, in a plane without gravity: cranks and couplers with frames at their first
/// joints, their second joints on their x axes; the tool in the platform's joints' frame.
class ThreeRrrYardstick {
 public:
  /// @param elbow per leg +1 or −1: on which side of the line from A to C the joint B lies
  ThreeRrrYardstick(const Mechanism& mechanism, const std::array<double, 3>& elbow);
  /// The tool on its straight line by the cycloidal law, the platform's angle kept.
  /// @param s time over duration
  ThreeRrrMoment at(double s, Plane from, Plane to, double duration) const;

 private:
  struct Link {
    double length, mass, inertia;
    Plane com;
  };
  struct Leg {
    Plane A, C;  ///< C from the tool
    double elbow;
    Link crank, coupler;
  };
  struct Platform {
    Plane position, velocity, acceleration;
  };
  /// Directions, rates, accelerations.
  static void move(const Leg& leg, const Platform& platform, ThreeRrrMoment::Leg& m);
  void balance_forces(const Platform& platform, ThreeRrrMoment& m) const;
  std::array<Leg, 3> legs_;
  double platform_mass_, mass_;
  Plane platform_com_;  ///< from the tool
};

/// Seven revolute joints in space: Newton–Euler in the links' axes.
class SevenJointYardstick {
 public:
  explicit SevenJointYardstick(const Mechanism& mechanism);
  void torques(const double* q, const double* dq, const double* ddq, double* torque) const;

 private:
  struct Link {
    double R[3][3], p[3];                   ///< the joint in the link before
    double mass, moment[3], inertia[3][3];  ///< about the joint
  };
  std::array<Link, 7> links_;
  double gravity_[3];
};

}  // namespace balance::bench
