#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/kinematics/closure.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::kinematics {

namespace {

constexpr double parallel_tolerance =
    1e-3;  // sine of the angle between two collinear links: positions are known to about its square
constexpr std::size_t max_listed_pairs = 3;  // keeps the sentence readable

/// A point on a body at which another joint or the tool is attached.
struct LinkEnd {
  JointId joint = -1;
  Vector3 position;
};

bool is_pivot(JointType type) {
  return type == JointType::revolute || type == JointType::universal || type == JointType::spherical;
}

template <class S>
Vector3 world_position(const Tree<S>& tree, const TreeState<S>& state, BodyId body, const Vector3& point) {
  FixedFrame<S> frame = tree.bodies[static_cast<std::size_t>(body)];
  frame.p_N += frame.R_N * to_vector<S>(point);
  return to_3d(position(state, frame));
}

/// Link ends per body.
template <class S>
std::vector<std::vector<LinkEnd>> list_link_ends(const Mechanism& mechanism, const Tree<S>& tree,
                                                 const TreeState<S>& state) {
  std::vector<std::vector<LinkEnd>> ends(mechanism.bodies.size());
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    if (!is_pivot(joint.type)) continue;
    for (const auto& [body, point] : {std::pair(joint.first, joint.point_first), {joint.second, joint.point_second}})
      ends[static_cast<std::size_t>(body)].push_back({static_cast<int>(j), world_position(tree, state, body, point)});
  }
  if (mechanism.tool)
    ends[static_cast<std::size_t>(mechanism.tool->body)].push_back(
        {-1, world_position(tree, state, mechanism.tool->body, mechanism.tool->position)});
  return ends;
}

/// Whether some end of one link, the joint and some end of the other link lie on a straight line.
bool has_collinear_ends(const std::vector<LinkEnd>& first, const std::vector<LinkEnd>& second, JointId joint,
                        double min_length) {
  const auto is_at_joint = [joint](const LinkEnd& end) { return end.joint == joint; };
  const auto a = std::find_if(first.begin(), first.end(), is_at_joint),
             b = std::find_if(second.begin(), second.end(), is_at_joint);
  for (const LinkEnd& from : first)
    for (const LinkEnd& to : second) {
      if (is_at_joint(from) || is_at_joint(to)) continue;
      const Vector3 u = from.position - a->position, v = to.position - b->position;
      const double length_product = u.norm() * v.norm();
      if (std::min(u.norm(), v.norm()) > min_length && u.cross(v).norm() <= parallel_tolerance * length_product)
        return true;
    }
  return false;
}

}  // namespace

template <class S>
std::string describe_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state) {
  const auto ends = list_link_ends(mechanism, tree, state);
  std::string text;
  std::size_t pairs = 0;
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const Joint& joint = mechanism.joints[j];
    if (!is_pivot(joint.type) || joint.first == model::ground || joint.second == model::ground) continue;
    if (!has_collinear_ends(ends[static_cast<std::size_t>(joint.first)], ends[static_cast<std::size_t>(joint.second)],
                            static_cast<int>(j), 1e-6 * tree.characteristic_length))
      continue;
    if (++pairs > max_listed_pairs) return "";
    text += (text.empty() ? "" : ", ") + mechanism.bodies[joint.first].name + " and " +
            mechanism.bodies[joint.second].name + " are in line at " + joint.name;
  }
  return text;
}

template std::string describe_collinear_links<Planar>(const Mechanism&, const Tree<Planar>&, const TreeState<Planar>&);
template std::string describe_collinear_links<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                       const TreeState<Spatial>&);

namespace {

// radians or characteristic lengths
constexpr double min_listed_miss = 1e-6;             // smaller misses are not listed
constexpr double singular_closure_tolerance = 1e-9;  // loops that close in a singular configuration stay open by less

/// "; there a and b are in line at B"
template <class S>
std::string format_collinear_links(const Mechanism& mechanism, const Tree<S>& tree, const TreeState<S>& state) {
  const std::string links = describe_collinear_links(mechanism, tree, state);
  return links.empty() ? "" : "; there " + links;
}

/// How far a closure is open in the directions that it constrains; those that the joint leaves free do not count.
struct ClosureError {
  JointId joint = -1;
  double gap = 0;    ///< [m]
  double angle = 0;  ///< [rad]

  double scaled_norm(double length) const { return std::max(gap / length, angle); }
};

template <class S>
ClosureError compute_closure_error(const TreeState<S>& state, const Closure<S>& closure) {
  const ClosurePose<S> pose = closure_pose(state, closure);
  if (is_point_closure(closure)) return {closure.joint, (pose.p_B - pose.p_A).norm(), 0};
  double squared_gap = 0, squared_angle = 0;
  for (const ClosureRow& row : closure.rows) {
    const double residual = closure_residual(pose, row);
    (row.kind == ClosureRow::Kind::dot ? squared_angle : squared_gap) += residual * residual;
  }
  return {closure.joint, std::sqrt(squared_gap), elementary::asin(std::min(1.0, std::sqrt(squared_angle)))};
}

template <class S>
ClosureError find_max_closure_error(const Tree<S>& tree, const TreeState<S>& state) {
  ClosureError max_error;
  for (const Closure<S>& closure : tree.closures) {
    if (closure.is_velocity_level()) continue;
    const ClosureError error = compute_closure_error(state, closure);
    if (max_error.joint < 0 ||
        error.scaled_norm(tree.characteristic_length) > max_error.scaled_norm(tree.characteristic_length))
      max_error = error;
  }
  return max_error;
}

/// @param attempt configuration of the failed search; other starts may come nearer
template <class S>
MotionOutcome explain_open_loops(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& attempt) {
  constexpr int max_columns = 60;
  constexpr std::uint64_t max_random_starts = 40;
  ConstraintSystem<S> closures(tree, Drive<S>{});
  ClosureError min_error;
  TreeState<S> state(tree.nodes.size()), best_state = state;
  for (std::uint64_t seed = 0; seed <= (tree.columns > max_columns ? 0 : max_random_starts); ++seed) {
    const VectorX y = seed == 0 ? attempt : solve_assembly(closures, random_coordinates(tree, seed), {}).y;
    compute_poses(tree, y.data(), state);
    const ClosureError error = find_max_closure_error(tree, state);
    if (min_error.joint >= 0 &&
        error.scaled_norm(tree.characteristic_length) >= min_error.scaled_norm(tree.characteristic_length))
      continue;
    min_error = error;
    best_state = state;
  }
  const double scaled_error = min_error.scaled_norm(tree.characteristic_length);
  std::string gap_text = min_error.gap >= 0.01 * scaled_error * tree.characteristic_length
                             ? format_length(min_error.gap, mechanism.units)
                             : "";
  if (min_error.angle >= 0.01 * scaled_error && min_error.angle > 0)
    gap_text += (gap_text.empty() ? "" : " and ") + format_angle(min_error.angle, mechanism.units);
  const std::string open_text =
      "joint " + mechanism.joints[min_error.joint].name + " stays open by " + gap_text + " at best";
  const std::string links_text = format_collinear_links(mechanism, tree, best_state);
  if (scaled_error < singular_closure_tolerance)
    return {MotionStatus::not_assembled,
            0,
            "the loops close only in a singular configuration, to within round-off (" + open_text +
                "): the lengths barely suffice, and nothing can move" + links_text,
            {}};
  return {MotionStatus::not_assembled, 0, "the loops cannot be closed: " + open_text + links_text, {}};
}

/// Moves from a configuration with closed loops to the one nearest to a pose, by Levenberg–Marquardt steps along the
/// freedoms that the loops leave.
template <class S>
VectorX approach_pose(const Tree<S>& tree, ConstraintSystem<S>& system, const trajectory::DriveSample& target,
                      VectorX y) {
  constexpr int max_steps = 200;
  constexpr double max_step = 0.3, max_damping = 1e8, min_relative_gain = 1e-12;
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const VectorX scale = column_scale(tree);
  VectorX residual, trial_residual;
  MatrixX jacobian, trial_jacobian;
  system.evaluate(y, target, residual, jacobian);
  double damping = 1e-3;
  for (int k = 0; k < max_steps && damping < max_damping; ++k) {
    const Eigen::Index stated_rows = residual.size() - tree.position_rows;
    const double cost = residual.tail(stated_rows).squaredNorm();
    const MatrixX null_space = decompose_rank(jacobian.topRows(tree.position_rows)).null_space;
    const MatrixX reduced_jacobian = jacobian.bottomRows(stated_rows) * null_space;
    MatrixX normal = reduced_jacobian.transpose() * reduced_jacobian;
    normal.diagonal().array() += damping;
    VectorX step = -null_space * normal.ldlt().solve(reduced_jacobian.transpose() * residual.tail(stated_rows));
    if (step.norm() > max_step) step *= max_step / step.norm();
    const AssemblySolution closed = solve_assembly(closures, y + scale.cwiseProduct(step), {}, 30);
    damping *= 4;
    if (!closed.found) continue;
    system.evaluate(closed.y, target, trial_residual, trial_jacobian);
    const double gain = cost - trial_residual.tail(stated_rows).squaredNorm();
    if (!(gain > 0)) continue;
    y = closed.y;
    residual.swap(trial_residual), jacobian.swap(trial_jacobian);
    damping = std::max(1e-12, damping / 20);
    if (gain < min_relative_gain * cost) break;
  }
  return y;
}

/// Values of a pose that the nearest configuration misses: "A 1.2 rad (nearest is 1.07 rad)".
template <class S>
std::string format_missed_values(const Mechanism& mechanism, const Drive<S>& drive, const trajectory::PoseTarget& pose,
                                 double length, const trajectory::DriveSample& target,
                                 const trajectory::DriveSample& nearest) {
  std::string text;
  const auto add = [&text](const std::string& what, const std::string& requested, const std::string& reached) {
    text += (text.empty() ? "" : ", ") + what + " " + requested + " (nearest is " + reached + ")";
  };
  const auto add_distance = [&](double distance) {
    text += ", " + format_length(distance, mechanism.units) + " out of reach";
  };
  Eigen::Index k = 0;
  for (const auto& [what, components] :
       {std::pair("the tool at", &drive.point), {"the centre of mass at", &drive.com}}) {
    const auto count = static_cast<Eigen::Index>(components->size());
    const double distance = (target.value - nearest.value).segment(k, count).norm();
    if (count >= 2 && distance > min_listed_miss * length) {
      add(what, format_position(&target.value[k], static_cast<int>(count), mechanism.units),
          format_position(&nearest.value[k], static_cast<int>(count), mechanism.units, min_listed_miss * length));
      add_distance(distance);
    }
    k += count;
  }
  auto joint = pose.joints.begin();
  for (std::size_t q = 0; q < drive.linear.size(); ++q, ++k) {
    const bool is_tool = q == 0 && drive.linear.size() > pose.joints.size();
    const CoordinateId coordinate = is_tool ? CoordinateId(-1) : (joint++)->coordinate;
    const bool is_length = !is_tool && mechanism.coordinates[coordinate].kind == CoordinateKind::length;
    if (std::abs(target.value[k] - nearest.value[k]) <= min_listed_miss * (is_length ? length : 1)) continue;
    const auto format_value = [&](double value, double round_off) {
      return is_length ? format_length(value, mechanism.units, round_off * length)
                       : format_angle(value, mechanism.units, round_off);
    };
    add(is_tool ? "the tool's angle" : mechanism.coordinates[coordinate].name, format_value(target.value[k], 0),
        format_value(nearest.value[k], min_listed_miss));
  }
  if (!drive.rotation.empty()) {
    const double angle_error = Eigen::AngleAxisd(nearest.rotation * target.rotation.transpose()).angle();
    if (angle_error > min_listed_miss)
      text += (text.empty() ? "" : ", ") +
              ("an orientation that is missed by " + format_angle(angle_error, mechanism.units));
  }
  return text;
}

/// "it asks for the tool at (3, 4) m (nearest is (1.2, 1.6) m), …; there a and b are in line at B". Empty if nothing is
/// missed, or the search for the nearest configuration fails.
template <class S>
std::string describe_missed_pose(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& attempt,
                                 const VectorX& assembled, const trajectory::PoseTarget& pose) {
  constexpr int max_columns = 120;  // up to here the freedoms of the loops are cheap to compute
  const PoseEquations<S> pose_equations = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, pose_equations.drive);
  if (pose_equations.drive.row_count() == 0 || tree.columns > max_columns) return "";
  ConstraintSystem<S> closures(tree, Drive<S>{});
  VectorX nearest_y, residual;
  MatrixX jacobian;
  double min_residual = INFINITY;
  for (const VectorX& guess : {attempt, assembled}) {
    const AssemblySolution closed_loops = solve_assembly(closures, guess, {});
    if (!closed_loops.found) continue;
    const VectorX y = approach_pose(tree, system, pose_equations.target, closed_loops.y);
    system.evaluate(y, pose_equations.target, residual, jacobian);
    if (residual.norm() < min_residual) min_residual = residual.norm(), nearest_y = y;
  }
  if (nearest_y.size() == 0) return "";
  system.evaluate(nearest_y, pose_equations.target, residual, jacobian);
  const std::string missed_values =
      format_missed_values(mechanism, pose_equations.drive, pose, tree.characteristic_length, pose_equations.target,
                           system.measure(nearest_y));
  if (missed_values.empty()) return "";
  return "it asks for " + missed_values + format_collinear_links(mechanism, tree, system.state());
}

/// What lies between the ground and the tool's body on one way, with both, as a mechanism of its own.
struct Leg {
  std::string name;  ///< "crank1 - coupler1"
  Mechanism mechanism;
  trajectory::PoseTarget pose;
};

/// For each body the leg that it is part of: bodies that joints connect without the ground and the tool's body.
std::vector<std::size_t> find_leg_roots(const Mechanism& mechanism) {
  std::vector<std::size_t> root(mechanism.bodies.size());
  for (std::size_t b = 0; b < root.size(); ++b) root[b] = b;
  const auto is_end = [&](BodyId body) { return body == model::ground || body == mechanism.tool->body; };
  for (const Joint& joint : mechanism.joints) {
    if (is_end(joint.first) || is_end(joint.second)) continue;
    const std::size_t from = root[static_cast<std::size_t>(joint.second)],
                      to = root[static_cast<std::size_t>(joint.first)];
    std::replace(root.begin(), root.end(), from, to);
  }
  return root;
}

/// A mechanism of some of the bodies and the joints among them; nothing else moves with these.
Leg extract_leg(const Mechanism& whole, const trajectory::PoseTarget& pose, const std::vector<bool>& is_part) {
  Leg leg{"", {}, pose};
  leg.mechanism.space = whole.space;
  leg.mechanism.units = whole.units;
  leg.pose.joints.clear();
  std::vector<BodyId> new_body(whole.bodies.size(), model::ground);
  for (std::size_t b = 0; b < whole.bodies.size(); ++b) {
    if (!is_part[b]) continue;
    new_body[b] = static_cast<int>(leg.mechanism.bodies.size());
    leg.mechanism.bodies.push_back(whole.bodies[b]);
    const bool is_inner = b > 0 && static_cast<int>(b) != whole.tool->body;
    if (is_inner) leg.name += (leg.name.empty() ? "" : " - ") + whole.bodies[b].name;
  }
  for (Joint joint : whole.joints) {
    const auto first = static_cast<std::size_t>(joint.first), second = static_cast<std::size_t>(joint.second);
    const bool is_beside = (first == 0 || static_cast<int>(first) == whole.tool->body) &&
                           (second == 0 || static_cast<int>(second) == whole.tool->body);
    if (!is_part[first] || !is_part[second] || is_beside) continue;
    joint.first = new_body[first], joint.second = new_body[second];
    leg.mechanism.joints.push_back(std::move(joint));
  }
  leg.mechanism.coordinates = list_coordinates(whole.space, leg.mechanism.joints);
  leg.mechanism.tool = whole.tool;
  leg.mechanism.tool->body = new_body[static_cast<std::size_t>(whole.tool->body)];
  const auto keep_values = [&](const std::vector<CoordinateValue>& values, std::vector<CoordinateValue>& kept) {
    for (const CoordinateValue& value : values)
      for (std::size_t c = 0; c < leg.mechanism.coordinates.size(); ++c)
        if (leg.mechanism.coordinates[c].name == whole.coordinates[value.coordinate].name)
          kept.push_back({static_cast<int>(c), value.value});
  };
  keep_values(whole.assembly, leg.mechanism.assembly);
  keep_values(pose.joints, leg.pose.joints);
  return leg;
}

/// The legs that carry the tool's body; none if a pose does not say where it is, or if there is only one.
std::vector<Leg> list_legs(const Mechanism& mechanism, const trajectory::PoseTarget& pose) {
  const bool states_tool = pose.tool || pose.angle || pose.orientation;
  if (!states_tool || !mechanism.tool || mechanism.tool->body == model::ground || has_velocity_constraints(mechanism))
    return {};
  const auto tool = static_cast<std::size_t>(mechanism.tool->body);
  const std::vector<std::size_t> root = find_leg_roots(mechanism);
  std::vector<Leg> legs;
  for (std::size_t r = 1; r < root.size(); ++r) {
    if (root[r] != r || r == tool) continue;
    bool is_grounded = false, carries_tool = false;
    for (const Joint& joint : mechanism.joints) {
      const auto first = static_cast<std::size_t>(joint.first), second = static_cast<std::size_t>(joint.second);
      if (root[first] != r && root[second] != r) continue;
      is_grounded = is_grounded || first == 0 || second == 0;
      carries_tool = carries_tool || first == tool || second == tool;
    }
    if (!is_grounded || !carries_tool) continue;
    std::vector<bool> is_part(root.size());
    for (std::size_t b = 0; b < root.size(); ++b) is_part[b] = b == 0 || b == tool || root[b] == r;
    legs.push_back(extract_leg(mechanism, pose, is_part));
  }
  return legs.size() > 1 ? legs : std::vector<Leg>();
}

/// What is missed by the mechanism, and by each leg that misses the pose even by itself.
template <class S>
std::string describe_missed_pose_and_legs(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& attempt,
                                          const VectorX& assembled, const trajectory::PoseTarget& pose) {
  std::string text = describe_missed_pose(mechanism, tree, attempt, assembled, pose);
  if (text.empty()) return text;
  constexpr std::string_view begin = "it asks for ";
  for (const Leg& leg : list_legs(mechanism, pose)) {
    std::vector<CoordinateId> stated;
    for (const CoordinateValue& joint : leg.pose.joints) stated.push_back(joint.coordinate);
    const Tree<S> leg_tree = compile_tree<S>(leg.mechanism, stated);
    const PoseEquations<S> equations = make_pose_equations(leg.mechanism, leg_tree, leg.pose);
    ConstraintSystem<S> system(leg_tree, equations.drive), closures(leg_tree, Drive<S>{});
    const AssemblySolution solution = solve_pose(leg.mechanism, leg_tree, system, equations.target);
    if (solution.found) continue;
    const AssemblySolution loops = solve_pose(leg.mechanism, leg_tree, closures, {});
    if (!loops.found) continue;
    const std::string missed = describe_missed_pose(leg.mechanism, leg_tree, solution.y, loops.y, leg.pose);
    if (missed.starts_with(begin)) text += "; leg " + leg.name + " by itself: " + missed.substr(begin.size());
  }
  return text;
}

template <class S>
std::string describe_unreachable_pose_in(const Mechanism& mechanism, const trajectory::PoseTarget& pose) {
  std::vector<CoordinateId> stated;
  for (const auto& joint : pose.joints) stated.push_back(joint.coordinate);
  const Tree<S> tree = compile_tree<S>(mechanism, stated);
  const PoseEquations<S> pose_equations = make_pose_equations(mechanism, tree, pose);
  ConstraintSystem<S> system(tree, pose_equations.drive), closures(tree, Drive<S>{});
  const AssemblySolution solution = solve_pose(mechanism, tree, system, pose_equations.target);
  if (solution.found) return "";
  const AssemblySolution loops = solve_pose(mechanism, tree, closures, {});
  return loops.found ? describe_missed_pose_and_legs(mechanism, tree, solution.y, loops.y, pose) : "";
}

}  // namespace

template <class S>
MotionOutcome explain_assembly_failure(const Mechanism& mechanism, const Tree<S>& tree, const AssemblySolution& attempt,
                                       const trajectory::PoseTarget& pose) {
  ConstraintSystem<S> closures(tree, Drive<S>{});
  const AssemblySolution loops = solve_pose(mechanism, tree, closures, {});
  if (!loops.found) return explain_open_loops(mechanism, tree, loops.y);
  const std::string missed = describe_missed_pose_and_legs(mechanism, tree, attempt.y, loops.y, pose);
  return {MotionStatus::unreachable,
          0,
          "the start pose cannot be reached: " + (missed.empty() ? "no configuration was found that has it" : missed),
          {}};
}

std::string describe_unreachable_pose(const Mechanism& mechanism, const trajectory::PoseTarget& pose) {
  return dispatch_space(mechanism.space, [&]<class S>(S) { return describe_unreachable_pose_in<S>(mechanism, pose); });
}

template MotionOutcome explain_assembly_failure<Planar>(const Mechanism&, const Tree<Planar>&, const AssemblySolution&,
                                                        const trajectory::PoseTarget&);
template MotionOutcome explain_assembly_failure<Spatial>(const Mechanism&, const Tree<Spatial>&,
                                                         const AssemblySolution&, const trajectory::PoseTarget&);

}  // namespace balance::kinematics
