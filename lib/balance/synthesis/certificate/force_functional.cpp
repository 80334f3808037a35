#include "balance/synthesis/certificate/force_functional.hpp"

#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/synthesis/certificate/mechanism_enclosure.hpp"

namespace balance::certificate {

using kinematics::NodeMotion;
using Vector = IntervalPlane::Vector;

namespace {

Vector zero_vector() { return {IntervalJet(0.0), IntervalJet(0.0)}; }

IntervalJet dot(const Vector& a, const Vector& b) { return a.x() * b.x() + a.y() * b.y(); }

}  // namespace

LoadedLinkage enclose_linkage(const DesignSpace& space, const FigureProblem& problem, const LengthBox& box, int order) {
  std::vector<IntervalJet> numbers;
  for (Eigen::Index i = 0; i < box.lower.size(); ++i) numbers.emplace_back(Interval(box.lower[i], box.upper[i]));
  for (const FreeElement& element : problem.elements)
    for (const int number :
         {element.mass_number, element.place_numbers[0], element.place_numbers[1], element.inertia_number})
      if (number >= 0) numbers[static_cast<std::size_t>(number)] = 0.0;
  const auto variables = static_cast<int>(problem.lengths.size());
  for (int k = 0; k < variables; ++k) {
    IntervalJet& length = numbers[static_cast<std::size_t>(problem.lengths[static_cast<std::size_t>(k)])];
    length = IntervalJet::variable(length.value, k, variables, order);
  }
  LoadedLinkage result;
  MechanismOf<IntervalJet>& mechanism = result.linkage.mechanism;
  mechanism = enclose_mechanism(space, numbers);
  for (const FreeElement& element : problem.elements) {
    ElementEnclosure& enclosure = result.elements.emplace_back();
    if (element.disc >= 0) {
      enclosure.mass = mechanism.discs[static_cast<std::size_t>(element.disc)].mass;
      mechanism.discs[static_cast<std::size_t>(element.disc)].mass = 0;
      continue;
    }
    auto& attachment = mechanism.attachments[static_cast<std::size_t>(element.attachment)];
    enclosure = {attachment.mass, {attachment.position[0], attachment.position[1]}};
    attachment.mass = 0;
  }
  const Trajectory& trajectory = space.start.trajectories[static_cast<std::size_t>(problem.trajectory)];
  result.linkage.tree =
      kinematics::compile_tree<IntervalPlane>(mechanism, trajectory::prescribed_coordinates(trajectory));
  if (mechanism.tool) {
    const auto& body = result.linkage.tree.bodies[static_cast<std::size_t>(mechanism.tool->body)];
    result.linkage.tool = {body.node, body.R_N,
                           body.p_N + body.R_N * kinematics::to_vector<IntervalPlane>(mechanism.tool->position)};
  }
  return result;
}

ForceFunctional::ForceFunctional(const FigureProblem& problem, const LoadedLinkage& linkage) : linkage_(&linkage) {
  const auto& tree = linkage.linkage.tree;
  const auto& mechanism = linkage.linkage.mechanism;
  std::vector<int> carrier_of_body(mechanism.bodies.size(), -1);
  for (const FreeElement& element : problem.elements) {
    if (element.disc >= 0) {
      const std::size_t index =
          mechanism.bodies.size() - 1 + mechanism.attachments.size() + static_cast<std::size_t>(element.disc);
      carrier_of_.push_back(static_cast<int>(carriers_.size()));
      carriers_.push_back({tree.mass_elements[index].frame});
      continue;
    }
    const auto body =
        static_cast<std::size_t>(mechanism.attachments[static_cast<std::size_t>(element.attachment)].body);
    if (carrier_of_body[body] < 0) {
      carrier_of_body[body] = static_cast<int>(carriers_.size());
      carriers_.push_back({tree.bodies[body]});
    }
    carrier_of_.push_back(carrier_of_body[body]);
  }
}

void ForceFunctional::add(MotionEnclosure& motion, const ForceWeights& weights) {
  const auto& tree = linkage_->linkage.tree;
  const auto& state = motion.state();
  const auto is_zero = [](const IntervalJet& x) { return x.value.is_point() && x.value.lower == 0; };
  velocities_.assign(tree.nodes.size(), zero_vector());
  rotations_.assign(tree.nodes.size(), IntervalJet());
  if (!is_zero(weights.force[0]) || !is_zero(weights.force[1]) || !is_zero(weights.moment)) {
    const Vector translation(weights.force[0], weights.force[1]);
    for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
      rotations_[n] = weights.moment;
      velocities_[n] = translation + kinematics::cross(weights.moment, state[n].p_WN);
    }
    add_powers(state, false);
  }
  if (weights.torques.empty()) return;
  std::vector<CoordinateId> actuators = linkage_->linkage.mechanism.actuators;
  const std::vector<IntervalJet> rates = motion.solve_rates(actuators, weights.torques);
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& node = tree.nodes[n];
    const auto parent = static_cast<std::size_t>(node.parent);
    rotations_[n] = rotations_[parent];
    velocities_[n] =
        velocities_[parent] + kinematics::cross(rotations_[parent], Vector(state[n].p_WN - state[parent].p_WN));
    if (node.motion == NodeMotion::weld) continue;
    const IntervalJet rate = node.ratio * rates[static_cast<std::size_t>(node.column)];
    if (node.motion == NodeMotion::revolute)
      rotations_[n] += rate;
    else
      velocities_[n] += rate * kinematics::prismatic_axis(state[n].R_WN);
  }
  add_powers(state, true);
}

/// @param has_weight as for torques: gravity acts on the masses
void ForceFunctional::add_powers(const kinematics::TreeState<IntervalPlane>& state, bool has_weight) {
  const auto& tree = linkage_->linkage.tree;
  const Vector gravity = kinematics::to_vector<IntervalPlane>(linkage_->linkage.mechanism.gravity);
  const auto motion_of = [&](std::size_t n, const Vector& place, const Vector& arm) {
    FrameMotion frame;
    frame.rotation = rotations_[n];
    frame.velocity = velocities_[n] + kinematics::cross(rotations_[n], arm);
    frame.acceleration = kinematics::point_acceleration<IntervalPlane>(state[n], place);
    if (has_weight) frame.acceleration -= gravity;
    frame.angular_acceleration = state[n].angular_acceleration;
    frame.square = state[n].acceleration_operator.square;
    return frame;
  };
  std::array<IntervalJet, 4> sums;
  for (std::size_t n = 1; n < tree.nodes.size(); ++n) {
    const auto& node = tree.nodes[n];
    if (node.massless) continue;
    sums = {};
    add_frame(motion_of(n, zero_vector(), zero_vector()), kinematics::axis(state[n].R_WN, 0), sums);
    fixed_ += node.inertia.mass * sums[0] + node.inertia.first_moment.x() * sums[1] +
              node.inertia.first_moment.y() * sums[2] + node.inertia.second_moment * sums[3];
  }
  for (Carrier& carrier : carriers_) {
    const auto n = static_cast<std::size_t>(carrier.frame.node);
    if (n == 0) continue;
    const Vector arm = state[n].R_WN * carrier.frame.p_N;
    const auto R = state[n].R_WN * carrier.frame.R_N;
    add_frame(motion_of(n, carrier.frame.p_N, arm), kinematics::axis(R, 0), carrier.coefficients);
  }
}

void ForceFunctional::add_frame(const FrameMotion& frame, const Vector& x_axis,
                                std::array<IntervalJet, 4>& sums) const {
  sums[0] += dot(frame.velocity, frame.acceleration);
  const Vector y_axis(-x_axis.y(), x_axis.x());
  const auto moment_power = [&](const Vector& axis, const Vector& normal) {
    // the first moment along the axis: its acceleration, and its moment about the frame's origin
    const Vector force = frame.angular_acceleration * normal - frame.square * axis;
    return dot(frame.velocity, force) + frame.rotation * kinematics::cross(axis, frame.acceleration);
  };
  sums[1] += moment_power(x_axis, y_axis);
  sums[2] += moment_power(y_axis, Vector(-x_axis));
  sums[3] += frame.rotation * frame.angular_acceleration;
}

}  // namespace balance::certificate
