#pragma once
/// A mechanism as simulators of robots take it: links of a tree that move about single axes, the closures of its loops,
/// and the elements that act on them. SI units; world axes at a reference pose unless said otherwise.

#include "balance/interface/import/foreign_model.hpp"
#include "balance/motion/study/study.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::foreign {

/// The ground, as a link's index.
inline constexpr int ground_link = -1;

/// A coordinate of the spec, or the turn of a disc.
struct RobotJoint {
  std::string name;  ///< of the coordinate or the disc
  bool is_rotation = true;
  Vector3 axis = Vector3::UnitZ();    ///< unit vector
  Vector3 anchor = Vector3::Zero();   ///< on the axis [m]
  double reference = 0;               ///< value at the reference pose [rad] or [m]
  double start = 0;                   ///< value at the start pose
  double stiffness = 0, preload = 0;  ///< effort preload − stiffness · q
  double viscous = 0, coulomb = 0;
};

/// Moves relative to its parent about its joints, the first of which is nearest to the parent; without joints it is
/// fixed to the parent.
struct RobotLink {
  std::string name;
  int parent = ground_link;  ///< index of an earlier link
  Pose pose;                 ///< of the body's frame at the reference pose
  std::vector<RobotJoint> joints;
  double mass = 0;                       ///< with counterweights and payloads [kg]
  Vector3 com = Vector3::Zero();         ///< link axes [m]
  Matrix3 inertia = Matrix3::Zero();     ///< about the centre of mass, link axes [kg m^2]
  std::vector<std::string> attachments;  ///< names of the counterweights and payloads that it carries
};

/// q[joint] = Σ ratio · q[leader] + offset.
struct RobotCoupling {
  std::string joint;
  std::vector<std::pair<std::string, double>> leaders;
  double offset = 0;
};

/// Closes a loop: points of two links coincide, and with `second_anchor` another pair of points, or the links are
/// welded as at the start pose.
struct RobotClosure {
  std::string name;  ///< of the joint
  int first = ground_link, second = ground_link;
  bool is_weld = false;
  Vector3 anchor = Vector3::Zero();  ///< at the reference pose, if loops are closed there
  std::optional<Vector3> second_anchor;
};

/// A spring, a damper, or both, between points of two links.
struct RobotSpring {
  std::string name;
  int first = ground_link, second = ground_link;
  Vector3 point_first = Vector3::Zero(), point_second = Vector3::Zero();  ///< link axes [m]
  double stiffness = 0, free_length = 0, damping = 0;
};

struct RobotMotor {
  std::string joint;
  std::optional<double> lower, upper;  ///< of the effort [N m] or [N]
};

struct RobotTree {
  std::string name;
  Vector3 gravity = Vector3::Zero();
  double length = 1;             ///< characteristic length [m]
  std::vector<RobotLink> links;  ///< parents before children
  std::vector<RobotCoupling> couplings;
  std::vector<RobotClosure> closures;
  std::vector<RobotSpring> springs;
  std::vector<RobotMotor> motors;
  bool has_start = false;            ///< whether `start` of the joints is known
  std::vector<std::string> missing;  ///< what no simulator's model expresses: "load 'cut'"
};

/// Where the links of a RobotTree stand.
enum class ReferencePose {
  zero,    ///< all coordinates of the tree are zero; loops are open
  closed,  ///< zero without loops, otherwise the start pose
};

/// @param trajectory whose start is the start pose; empty: the first one, or `assembly` if there is none
/// @throws SpecError if there is no such trajectory, or the loops cannot be closed
RobotTree make_robot_tree(const Study& study, const std::string& trajectory, ReferencePose reference);

}  // namespace balance::foreign
