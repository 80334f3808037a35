#include "balance/mechanics/dynamics/external_forces.hpp"

#include "balance/foundation/numerics/engine_scalar.hpp"

#include <algorithm>
#include <cmath>

namespace balance::dynamics {

namespace {

template <class S>
kinematics::FixedFrame<S> place_on_body(const kinematics::Tree<S>& tree, BodyId body,
                                        const Vector3Of<typename S::Scalar>& point) {
  const kinematics::FixedFrame<S>& frame = tree.bodies[body];
  return {frame.node, frame.R_N, frame.p_N + frame.R_N * kinematics::to_vector<S>(point)};
}

}  // namespace

template <class S>
ExternalForces<S>::ExternalForces(const MechanismOf<Scalar>& mechanism, const kinematics::Tree<S>& tree) {
  for (const model::LoadOf<Scalar>& load : mechanism.loads)
    if (load.body != model::ground)
      loads_.push_back({model::LoadTable<Scalar>(load),
                        load.is_over_coordinate() ? &tree.coordinate_expressions[load.coordinate] : nullptr,
                        place_on_body(tree, load.body, load.point)});
  for (const model::SpringOf<Scalar>& spring : mechanism.springs)
    if (spring.is_joint_spring())
      joint_springs_.push_back({&tree.coordinate_expressions[spring.coordinate], spring.stiffness, spring.preload});
    else
      springs_.push_back({spring, place_on_body(tree, spring.first, spring.point_first),
                          place_on_body(tree, spring.second, spring.point_second)});
  for (const model::ForceElementOf<Scalar>& element : mechanism.force_elements) {
    const auto law = element.is_damper() ? model::ForceLawOf<Scalar>() : model::ForceLawOf<Scalar>(element.table);
    has_dampers_ = has_dampers_ || element.is_damper();
    if (element.is_in_joint())
      joint_tables_.push_back({&tree.coordinate_expressions[element.coordinate], law});
    else
      point_elements_.push_back({place_on_body(tree, element.first, element.point_first),
                                 place_on_body(tree, element.second, element.point_second), law, element.damping,
                                 element.is_damper()});
  }
}

template <class S>
void ExternalForces<S>::apply(const kinematics::TreeState<S>& state, const kinematics::FixedFrame<S>& frame,
                              const typename S::Vector& force, typename S::Angular moment,
                              std::vector<Wrench<S>>& wrenches, Wrench<S>& total) const {
  if (frame.node == 0) return;  // acts on the ground
  const kinematics::NodeState<S>& s = state[frame.node];
  const typename S::Vector f_N = rotate_inverse(s.R_WN, force);
  wrenches[frame.node].force -= f_N;
  wrenches[frame.node].moment -= rotate_inverse(s.R_WN, moment) + kinematics::cross(frame.p_N, f_N);
  total.force += force;
  total.moment += moment + kinematics::cross(position(state, frame), force);
}

template <class S>
void ExternalForces<S>::subtract(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                                 std::vector<Wrench<S>>& wrenches, Wrench<S>& total, Wrench<S>& loads) const {
  for (const PlacedLoad& placed : loads_) {
    Vector3Of<Scalar> force, moment;
    placed.evaluate(y, time, force, moment);
    typename S::Vector f = kinematics::to_vector<S>(force);
    typename S::Angular m = kinematics::to_angular<S>(moment);
    if (placed.table.load().frame == model::Frame::body) {
      const typename S::Rotation R = orientation(state, placed.frame);
      f = R * f;
      m = R * m;
    }
    apply(state, placed.frame, f, m, wrenches, loads);
  }
  total = loads;
  for (const PlacedSpring& placed : springs_) {
    const typename S::Vector d = position(state, placed.second) - position(state, placed.first);
    const Scalar tension = placed.law.tension_per_length(Scalar(d.norm()));
    apply(state, placed.first, tension * d, S::zero_angular(), wrenches, total);
    apply(state, placed.second, -tension * d, S::zero_angular(), wrenches, total);
  }
  for (const PointElement& element : point_elements_) {
    const typename S::Vector d = position(state, element.second) - position(state, element.first);
    const Scalar length = d.norm();
    if (!(length > 0)) continue;  // without a direction
    const Scalar tension = element.is_damper ? Scalar(element.damping * length_rate_product(element, state, d) / length)
                                             : element.law.force(length);
    const typename S::Vector force = (tension / length) * d;
    apply(state, element.first, force, S::zero_angular(), wrenches, total);
    apply(state, element.second, -force, S::zero_angular(), wrenches, total);
  }
}

template <class S>
void ExternalForces<S>::add_joint_springs(const Scalar* y, Scalar* tau) const {
  for (const JointSpring& spring : joint_springs_)
    spring.coordinate->add_generalised_force(spring.stiffness * spring.coordinate->value(y) - spring.preload, tau);
  for (const JointTable& spring : joint_tables_)
    spring.coordinate->add_generalised_force(-spring.law.force(spring.coordinate->value(y)), tau);
}

template <class S>
typename S::Scalar ExternalForces<S>::energy(const kinematics::TreeState<S>& state, const Scalar* y) const {
  Scalar sum = 0;
  for (const JointSpring& spring : joint_springs_) {
    const Scalar q = spring.coordinate->value(y);
    sum += (0.5 * spring.stiffness * q - spring.preload) * q;
  }
  for (const PlacedSpring& placed : springs_)
    sum += placed.law.energy(Scalar((position(state, placed.second) - position(state, placed.first)).norm()));
  for (const PointElement& element : point_elements_)
    if (!element.is_damper)
      sum += element.law.energy((position(state, element.second) - position(state, element.first)).norm());
  for (const JointTable& spring : joint_tables_) sum -= spring.law.energy(spring.coordinate->value(y));
  return sum;
}

template <class S>
typename S::Scalar ExternalForces<S>::damper_power(const kinematics::TreeState<S>& state) const {
  Scalar sum = 0;
  for (const PointElement& element : point_elements_) {
    if (!element.is_damper) continue;
    const typename S::Vector d = position(state, element.second) - position(state, element.first);
    const Scalar square = d.squaredNorm(), product = length_rate_product(element, state, d);
    if (square > 0) sum += element.damping * product * product / square;
  }
  return sum;
}

template <class S>
template <class Ends>
double ExternalForces<S>::length_magnitude(const kinematics::TreeState<S>& state, const Ends& ends) {
  return value_of(position(state, ends.first).norm() + position(state, ends.second).norm());
}

template <class S>
template <class Tension, class Add>
void ExternalForces<S>::visit_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                                         const Tension& tension, const Add& add) const {
  const auto visit = [&](const kinematics::FixedFrame<S>& frame, double force, double moment) {
    if (frame.node != 0) add(frame, force, moment);
  };
  for (const PlacedLoad& placed : loads_) {
    Vector3Of<Scalar> force, moment;
    placed.evaluate(y, time, force, moment);
    visit(placed.frame, value_of(force.norm()), value_of(moment.norm()));
  }
  for (const PlacedSpring& placed : springs_) {
    const double force = value_of(placed.law.stiffness) * tension(placed);
    visit(placed.first, force, 0);
    visit(placed.second, force, 0);
  }
  for (const PointElement& element : point_elements_) {
    const double force = element.is_damper
                             ? value_of(element.damping) * (value_of(end_velocity(state, element.first).norm()) +
                                                            value_of(end_velocity(state, element.second).norm()))
                             : value_of(element.law.max_force());
    visit(element.first, force, 0);
    visit(element.second, force, 0);
  }
}

template <class S>
void ExternalForces<S>::add_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y, const Scalar& time,
                                       std::vector<ForceMagnitude>& magnitudes) const {
  visit_magnitudes(
      state, y, time,
      [&](const PlacedSpring& spring) {
        return length_magnitude(state, spring) + std::abs(value_of(spring.law.free_length));
      },
      [&](const kinematics::FixedFrame<S>& frame, double force, double moment) {
        ForceMagnitude& magnitude = magnitudes[static_cast<std::size_t>(frame.node)];
        magnitude.force += force;
        magnitude.moment += moment + value_of(frame.p_N.norm()) * force;
      });
}

template <class S>
ForceMagnitude ExternalForces<S>::sum_magnitudes(const kinematics::TreeState<S>& state, const Scalar* y,
                                                 const Scalar& time) const {
  ForceMagnitude sum;
  visit_magnitudes(
      state, y, time,
      [&](const PlacedSpring& placed) {
        const Scalar length = (position(state, placed.second) - position(state, placed.first)).norm();
        return std::abs(value_of(length) - value_of(placed.law.free_length));
      },
      [&](const kinematics::FixedFrame<S>& frame, double force, double moment) {
        sum.force += force;
        sum.moment += moment + value_of(position(state, frame).norm()) * force;
      });
  return sum;
}

template <class S>
double ExternalForces<S>::JointSpring::coordinate_magnitude(const Scalar* y) const {
  const double magnitude = std::abs(value_of(coordinate->value(y)));
  return coordinate->is_length ? magnitude : std::max(1.0, magnitude);
}

template <class S>
void ExternalForces<S>::add_joint_magnitudes(const Scalar* y, std::vector<double>& tau) const {
  for (const JointSpring& spring : joint_springs_)
    for (const auto& [column, ratio] : spring.coordinate->terms)
      tau[static_cast<std::size_t>(column)] +=
          std::abs(value_of(ratio)) *
          (value_of(spring.stiffness) * spring.coordinate_magnitude(y) + std::abs(value_of(spring.preload)));
  for (const JointTable& spring : joint_tables_)
    for (const auto& [column, ratio] : spring.coordinate->terms)
      tau[static_cast<std::size_t>(column)] += std::abs(value_of(ratio)) * value_of(spring.law.max_force());
}

template <class S>
double ExternalForces<S>::energy_magnitude(const kinematics::TreeState<S>& state, const Scalar* y) const {
  double sum = 0;
  for (const JointSpring& spring : joint_springs_) {
    const double q = spring.coordinate_magnitude(y);
    sum += (0.5 * value_of(spring.stiffness) * q + std::abs(value_of(spring.preload))) * q;
  }
  for (const PlacedSpring& placed : springs_) {
    const double length = length_magnitude(state, placed) + std::abs(value_of(placed.law.free_length));
    sum += 0.5 * value_of(placed.law.stiffness) * length * length;
  }
  for (const PointElement& element : point_elements_)
    if (!element.is_damper)
      sum += std::abs(
          value_of(element.law.energy((position(state, element.second) - position(state, element.first)).norm())));
  for (const JointTable& spring : joint_tables_)
    sum += std::abs(value_of(spring.law.energy(spring.coordinate->value(y))));
  return sum;
}

template class ExternalForces<kinematics::PlanarOf<EngineScalar>>;
template class ExternalForces<kinematics::SpatialOf<EngineScalar>>;

}  // namespace balance::dynamics
