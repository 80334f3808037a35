#include "balance/interface/import/robot_tree.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/model/topology.hpp"
#include "balance/motion/simulation/end_configurations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace balance::foreign {

namespace {

/// A step from the first body's point to the second body's: fixed, or a motion about or along x, y, z axes that earlier
/// steps carry along.
struct Step {
  Pose fixed;
  Vector3 axis = Vector3::Zero();  ///< zero: the step is fixed
  bool is_rotation = false;
  int coordinate = 0;  ///< of the joint

  bool is_motion() const { return !axis.isZero(0); }
  Pose at(double value) const {
    if (!is_motion()) return fixed;
    if (!is_rotation) return {Matrix3::Identity(), value * axis};
    return {rotation_about(axis, value), Vector3::Zero()};
  }
};

Step make_fixed(const Matrix3& R, const Vector3& p) { return {{R, p}, Vector3::Zero(), false, 0}; }

/// The motions of a joint as in the tables at JointOf (mechanics/model/mechanism.hpp).
std::vector<Step> list_motions(const Joint& joint) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ(), u = joint.axis, v = joint.axis2;
  const auto turn = [](const Vector3& axis, int coordinate) { return Step{{}, axis, true, coordinate}; };
  const auto slide = [](const Vector3& axis, int coordinate) { return Step{{}, axis, false, coordinate}; };
  const Step lift = make_fixed(Matrix3::Identity(), joint.radius * u);
  switch (joint.type) {
    case JointType::fixed: return {};
    case JointType::revolute: return {turn(u, 0)};
    case JointType::prismatic: return {slide(u, 0)};
    case JointType::pin_slot: return {slide(u, 0), turn(z, 1)};
    case JointType::cylindrical: return {slide(u, 1), turn(u, 0)};
    case JointType::universal: return {turn(u, 0), turn(v, 1)};
    case JointType::spherical: return {turn(x, 0), turn(y, 1), turn(z, 2)};
    case JointType::planar: return {slide(v, 0), slide(u.cross(v), 1), turn(u, 2)};
    case JointType::free: return {slide(x, 0), slide(y, 1), slide(z, 2), turn(x, 3), turn(y, 4), turn(z, 5)};
    case JointType::rolling_disc:
      return {slide(v, 0), slide(u.cross(v), 1), turn(u, 2), turn(v, 3), lift, turn(u.cross(v), 4)};
    case JointType::rolling_sphere:
      return {slide(v, 0), slide(u.cross(v), 1), lift, turn(x, 2), turn(y, 3), turn(z, 4)};
  }
  return {};
}

/// The one that the file stands at the start of; nullptr if there is none.
const Trajectory* find_trajectory(const Study& study, const std::string& name) {
  return study.trajectories.empty() && name.empty() ? nullptr : &study::choose_trajectory(study, name);
}

/// All coordinates at the start; empty if there is nothing that determines them.
std::vector<double> find_start(const Study& study, const std::string& name) {
  const Trajectory* trajectory = find_trajectory(study, name);
  const kinematics::ConfigurationResult result =
      trajectory != nullptr
          ? simulation::find_start_configuration(study.mechanism, *trajectory)
          : kinematics::solve_configuration(study.mechanism, kinematics::actuators_as_assembled(study.mechanism));
  std::vector<double> values(study.mechanism.coordinates.size(), 0.0);
  if (result.outcome.status != MotionStatus::done) return {};
  for (const CoordinateValue& one : result.coordinates) values[static_cast<std::size_t>(one.coordinate)] = one.value;
  return values;
}

/// Mass, centre of mass and inertia about it, of everything fixed to one body, in that body's axes.
struct MassSum {
  double mass = 0;
  Vector3 com = Vector3::Zero();
  Matrix3 inertia = Matrix3::Zero();

  void add(double m, const Vector3& position, const Matrix3& about_com) {
    inertia += about_com;
    if (m == 0) return;
    const Vector3 arm = position - com;
    if (mass != 0) inertia += mass * m / (mass + m) * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
    com += m / (mass + m) * arm;
    mass += m;
  }
};

class RobotTreeBuilder {
 public:
  RobotTreeBuilder(const Study& study, const std::string& trajectory, ReferencePose reference)
      : mechanism_(study.mechanism),
        spanning_(model::build_spanning_tree(study.mechanism, {})),
        joint_coordinates_(coordinates_of_joints(study.mechanism)),
        start_(find_start(study, trajectory)),
        links_(study.mechanism.bodies.size(), ground_link),
        masses_(study.mechanism.bodies.size()),
        attachments_(study.mechanism.bodies.size()),
        shares_(study.mechanism.bodies.size(), 1) {
    const bool has_loops = !spanning_.cut.empty() || std::any_of(spanning_.edges.begin(), spanning_.edges.end(),
                                                                 [](const auto& edge) { return edge.split; });
    tree_.has_start = !start_.empty();
    if (has_loops && reference == ReferencePose::closed && !tree_.has_start)
      throw SpecError({.place = {.file = study.spec_file},
                       .message = "the loops cannot be closed: the start pose cannot be reached",
                       .expected = {},
                       .found = {},
                       .hint = "'balance check' says more"});
    const bool is_at_start = has_loops && reference == ReferencePose::closed;
    reference_.assign(mechanism_.coordinates.size(), 0.0);
    if (is_at_start) reference_ = start_;
    if (!tree_.has_start) start_ = reference_;
    tree_.name = mechanism_.name.empty() ? "mechanism" : mechanism_.name;
    tree_.gravity = mechanism_.gravity;
    tree_.length = characteristic_length(mechanism_);
  }

  RobotTree build() {
    sum_masses();
    count_copies();
    poses_.resize(mechanism_.bodies.size());
    add_discs(model::ground);
    for (const model::TreeEdge& edge : spanning_.edges) add_edge(edge);
    for (const JointId j : spanning_.cut) add_closure(j);
    add_couplings();
    add_joint_forces();
    add_springs();
    add_motors();
    list_missing();
    return std::move(tree_);
  }

 private:
  void sum_masses() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) {
      const Body& body = mechanism_.bodies[b];
      masses_[b].add(body.mass, body.com, body.inertia);
    }
    for (const Attachment& attachment : mechanism_.attachments) {
      if (model::is_temporary_payload(attachment)) continue;
      const auto b = static_cast<std::size_t>(attachment.body);
      masses_[b].add(attachment.mass, attachment.position, attachment.inertia);
      attachments_[b].push_back(attachment.name);
    }
  }

  /// A joint that closes a loop and is none of a point carries a copy of its child, which shares the child's mass: most
  /// simulators take neither other closures than points and welds nor links without mass.
  bool needs_copy(const Joint& joint) const {
    return joint.type != JointType::fixed && joint.type != JointType::spherical && joint.type != JointType::revolute;
  }

  void count_copies() {
    for (const model::TreeEdge& edge : spanning_.edges)
      if (edge.split) shares_[static_cast<std::size_t>(edge.child)] += 1;
    for (const JointId j : spanning_.cut)
      if (const Joint& joint = mechanism_.joints[static_cast<std::size_t>(j)]; needs_copy(joint))
        shares_[static_cast<std::size_t>(copied_body(joint))] += 1;
  }

  static BodyId copied_body(const Joint& joint) { return joint.second == model::ground ? joint.first : joint.second; }

  const Pose& pose_of(BodyId body) const { return poses_[static_cast<std::size_t>(body)]; }
  int link_of(BodyId body) const { return links_[static_cast<std::size_t>(body)]; }

  int add_link(BodyId body, int parent, const Pose& pose, std::vector<RobotJoint> joints, bool is_copy) {
    const auto b = static_cast<std::size_t>(body);
    RobotLink link;
    link.name = mechanism_.bodies[b].name;
    link.parent = parent;
    link.pose = pose;
    link.joints = std::move(joints);
    link.mass = masses_[b].mass / shares_[b];
    link.com = masses_[b].com;
    link.inertia = masses_[b].inertia / shares_[b];
    // only zz of a planar body matters: that of a ball is one that every simulator takes
    if (mechanism_.space == SpaceKind::planar) link.inertia = link.inertia(2, 2) * Matrix3::Identity();
    if (is_copy)
      link.name += " copy";
    else
      link.attachments = attachments_[b];
    tree_.links.push_back(std::move(link));
    return static_cast<int>(tree_.links.size()) - 1;
  }

  /// The motions of a joint from one of its bodies to the other. @param pose of that body; becomes that of the other
  std::vector<RobotJoint> traverse(JointId j, bool forward, Pose& pose) const {
    const Joint& joint = mechanism_.joints[static_cast<std::size_t>(j)];
    std::vector<Step> steps = list_motions(joint);
    steps.insert(steps.begin(), make_fixed(Matrix3::Identity(), joint.point_first));
    steps.push_back(make_fixed(joint.rotation, joint.rotation * -joint.point_second));
    if (!forward) std::reverse(steps.begin(), steps.end());
    std::vector<RobotJoint> joints;
    for (const Step& step : steps) {
      double value = 0;
      if (step.is_motion()) {
        const CoordinateId c =
            joint_coordinates_[static_cast<std::size_t>(j)][static_cast<std::size_t>(step.coordinate)];
        const auto index = static_cast<std::size_t>(c);
        value = reference_[index];
        RobotJoint motion;
        motion.name = mechanism_.coordinates[index].name;
        motion.is_rotation = step.is_rotation;
        motion.axis = pose.R * (forward ? step.axis : Vector3(-step.axis));
        motion.anchor = pose.p;
        motion.reference = value;
        motion.start = start_[index];
        joints.push_back(motion);
      }
      pose = pose * (forward ? step.at(value) : step.at(value).inverse());
    }
    return joints;
  }

  void add_edge(const model::TreeEdge& edge) {
    Pose pose = pose_of(edge.parent);
    std::vector<RobotJoint> joints = traverse(edge.joint, edge.forward, pose);
    const int link = add_link(edge.child, link_of(edge.parent), pose, std::move(joints), edge.split);
    if (edge.split) {
      copies_.push_back({edge.joint, edge.child, link});
      return;
    }
    poses_[static_cast<std::size_t>(edge.child)] = pose;
    links_[static_cast<std::size_t>(edge.child)] = link;
    add_discs(edge.child);
  }

  void add_discs(BodyId carrier) {
    for (const Disc& disc : mechanism_.discs) {
      if (!(disc.body == carrier)) continue;
      RobotJoint joint;
      joint.name = disc.name;
      const auto is_taken = [&](const Coordinate& one) { return one.name == joint.name; };
      while (std::any_of(mechanism_.coordinates.begin(), mechanism_.coordinates.end(), is_taken)) joint.name += " disc";
      RobotCoupling coupling{joint.name, {}, 0};
      for (const model::CoordinateTerm& term : disc.follows.terms) {
        coupling.leaders.emplace_back(coordinate_name(term.coordinate), disc.ratio * term.ratio);
        joint.reference += disc.ratio * term.ratio * reference_[static_cast<std::size_t>(term.coordinate)];
        joint.start += disc.ratio * term.ratio * start_[static_cast<std::size_t>(term.coordinate)];
      }
      Pose pose = pose_of(carrier) * Pose{Matrix3::Identity(), disc.position};
      joint.axis = pose.R * disc.axis;
      joint.anchor = pose.p;
      pose.R = pose.R * rotation_about(disc.axis, joint.reference);
      RobotLink link;
      link.name = disc.name;
      link.parent = link_of(carrier);
      link.pose = pose;
      link.joints = {joint};
      link.mass = disc.mass;
      link.inertia = disc.inertia;
      if (mechanism_.space == SpaceKind::planar) link.inertia = link.inertia(2, 2) * Matrix3::Identity();
      tree_.links.push_back(std::move(link));
      tree_.couplings.push_back(std::move(coupling));
    }
  }

  /// All copies are welded at the end, when every body has its link.
  void add_closure(JointId j) {
    const Joint& joint = mechanism_.joints[static_cast<std::size_t>(j)];
    if (needs_copy(joint)) {
      const BodyId child = copied_body(joint);
      const bool forward = child == joint.second;
      const BodyId parent = forward ? joint.first : joint.second;
      Pose pose = pose_of(parent);
      std::vector<RobotJoint> joints = traverse(j, forward, pose);
      copies_.push_back({j, child, add_link(child, link_of(parent), pose, std::move(joints), true)});
      return;
    }
    RobotClosure closure;
    closure.name = joint.name;
    closure.first = link_of(joint.first);
    closure.second = link_of(joint.second);
    const Pose& first = pose_of(joint.first);
    closure.anchor = first.p + first.R * joint.point_first;
    closure.is_weld = joint.type == JointType::fixed;
    if (joint.type == JointType::revolute && mechanism_.space == SpaceKind::spatial)
      closure.second_anchor = closure.anchor + first.R * (tree_.length * joint.axis);
    tree_.closures.push_back(std::move(closure));
  }

  void add_couplings() {
    for (const Copy& copy : copies_) {
      RobotClosure closure;
      closure.name = mechanism_.joints[static_cast<std::size_t>(copy.joint)].name;
      closure.first = copy.link;
      closure.second = link_of(copy.body);
      closure.is_weld = true;
      closure.anchor = pose_of(copy.body).p;
      tree_.closures.push_back(std::move(closure));
    }
    for (const Coupling& coupling : mechanism_.couplings) {
      RobotCoupling out{coordinate_name(coupling.follower), {}, coupling.offset};
      for (const model::CoordinateTerm& term : coupling.leader.terms)
        out.leaders.emplace_back(coordinate_name(term.coordinate), coupling.ratio * term.ratio);
      tree_.couplings.push_back(std::move(out));
    }
  }

  const std::string& coordinate_name(CoordinateId c) const {
    return mechanism_.coordinates[static_cast<std::size_t>(c)].name;
  }

  RobotJoint* find_joint(CoordinateId c) {
    for (RobotLink& link : tree_.links)
      for (RobotJoint& joint : link.joints)
        if (joint.name == coordinate_name(c)) return &joint;
    return nullptr;
  }

  void add_joint_forces() {
    for (const Spring& spring : mechanism_.springs) {
      if (!spring.is_joint_spring()) continue;
      RobotJoint& joint = *find_joint(spring.coordinate);
      joint.stiffness += spring.stiffness;
      joint.preload += spring.preload;
    }
    for (const Friction& friction : mechanism_.friction) {
      RobotJoint& joint = *find_joint(friction.coordinate);
      joint.viscous = friction.viscous;
      joint.coulomb = 0.5 * (friction.dry_friction(1) + friction.dry_friction(-1));
      const std::string name = quote_for_message(joint.name);
      if (friction.dry_friction(1) != friction.dry_friction(-1))
        tree_.missing.push_back(
            fmt::format("dry friction of {} that depends on the direction: its mean is written", name));
      if (friction.static_limit(1) != friction.dry_friction(1) ||
          friction.static_limit(-1) != friction.dry_friction(-1))
        tree_.missing.push_back(fmt::format("static friction of {} above its sliding friction", name));
    }
  }

  template <class Element>
  RobotSpring place_spring(const Element& element) const {
    return {element.name,
            link_of(element.first),
            link_of(element.second),
            element.point_first,
            element.point_second,
            0,
            0,
            0};
  }

  void add_springs() {
    for (const Spring& spring : mechanism_.springs) {
      if (spring.is_joint_spring()) continue;
      tree_.springs.push_back(place_spring(spring));
      tree_.springs.back().stiffness = spring.stiffness;
      tree_.springs.back().free_length = spring.free_length;  // less what initial tension would stretch
      if (spring.slack_length)
        tree_.missing.push_back(
            fmt::format("slack of spring {}: it pushes in the file when it is shorter than {:.6g} m",
                        quote_for_message(spring.name), *spring.slack_length));
      if (spring.shortest_length || spring.longest_length)
        tree_.missing.push_back(fmt::format("travel of spring {}", quote_for_message(spring.name)));
    }
    for (const ForceElement& element : mechanism_.force_elements) {
      if (!element.is_damper()) {
        tree_.missing.push_back(fmt::format("spring {} with a table", quote_for_message(element.name)));
        continue;
      }
      const auto beside = std::find_if(tree_.springs.begin(), tree_.springs.end(), [&](const RobotSpring& spring) {
        return spring.name == element.name && spring.damping == 0 && spring.point_first == element.point_first &&
               spring.point_second == element.point_second && spring.first == link_of(element.first) &&
               spring.second == link_of(element.second);
      });
      RobotSpring& spring = beside != tree_.springs.end() ? *beside : tree_.springs.emplace_back(place_spring(element));
      spring.damping = element.damping;
    }
  }

  void add_motors() {
    for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
      RobotMotor motor{coordinate_name(mechanism_.actuators[a]), {}, {}};
      if (mechanism_.torque_distribution && a < mechanism_.torque_distribution->shares.size()) {
        motor.lower = mechanism_.torque_distribution->shares[a].lower;
        motor.upper = mechanism_.torque_distribution->shares[a].upper;
      }
      tree_.motors.push_back(std::move(motor));
    }
  }

  void list_missing() {
    const auto add = [&](const char* what, const std::string& name, const char* consequence) {
      tree_.missing.push_back(fmt::format("{} {}{}", what, quote_for_message(name), consequence));
    };
    for (const Joint& joint : mechanism_.joints)
      if (is_rolling(joint.type) && !joint.slips) add("joint", joint.name, ", which rolls: it slips in the file");
    for (const model::GeneralisedSpeed& constraint : mechanism_.constraints)
      add("constraint", constraint.name, " on speeds");
    for (const Load& load : mechanism_.loads) add("load", load.name, "");
    for (const Attachment& attachment : mechanism_.attachments)
      if (model::is_temporary_payload(attachment)) add("payload", attachment.name, ", which comes and goes");
    if (!model::locked_freedoms(mechanism_, {}, spanning_).empty())
      tree_.missing.push_back("bodies between two spherical joints are free to spin in the file");
  }

  /// A further link for a body, which closes a loop by being welded to it.
  struct Copy {
    JointId joint = 0;
    BodyId body = 0;
    int link = ground_link;
  };

  const Mechanism& mechanism_;
  const model::SpanningTree spanning_;
  const std::vector<std::vector<CoordinateId>> joint_coordinates_;
  std::vector<double> start_, reference_;  ///< per coordinate
  std::vector<Pose> poses_;                ///< of all bodies at the reference pose
  std::vector<int> links_;                 ///< per body
  std::vector<MassSum> masses_;
  std::vector<std::vector<std::string>> attachments_;
  std::vector<double> shares_;  ///< number of links among which a body's mass is divided
  std::vector<Copy> copies_;
  RobotTree tree_;
};

}  // namespace

RobotTree make_robot_tree(const Study& study, const std::string& trajectory, ReferencePose reference) {
  RobotTree tree = RobotTreeBuilder(study, trajectory, reference).build();
  if (const Trajectory* motion = find_trajectory(study, trajectory))
    for (const auto& adaptation : motion->adaptations)
      tree.missing.push_back(fmt::format(
          "moves of the counterweight {}",
          quote_for_message(study.mechanism.attachments[static_cast<std::size_t>(adaptation.attachment)].name)));
  return tree;
}

}  // namespace balance::foreign
