#include "balance/mechanics/derivatives/state_gradient.hpp"

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics_impl.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

/// The state and the mechanism with the derivatives of a few numbers set.
struct SeededState {
  MechanismOf<DualNumber> mechanism;
  DriveSampleOf<DualNumber> target;

  void seed(const DifferentiationVariable& wanted, std::size_t k) {
    if (const auto* number = std::get_if<MechanismVariable>(&wanted)) {
      variable_in(mechanism, *number).d[k] = 1;
      if (has_symmetric_entry(*number))
        variable_in(mechanism, {number->kind, number->index, number->column, number->row}).d[k] = 1;
      return;
    }
    const StateVariable& own = std::get<StateVariable>(wanted);
    auto& values = own.kind == StateVariable::Kind::q    ? target.value
                   : own.kind == StateVariable::Kind::dq ? target.rate
                                                         : target.acceleration;
    values[own.index].d[k] = 1;
  }
};

void check(const InverseDynamics& door, const std::vector<DifferentiationVariable>& wanted) {
  for (const DifferentiationVariable& one : wanted) {
    if (const auto* number = std::get_if<MechanismVariable>(&one)) {
      require_variable(door.mechanism(), *number);
    } else if (const int index = std::get<StateVariable>(one).index; index < 0 || index >= door.degrees_of_freedom()) {
      throw std::invalid_argument("a number of the state: there is no coordinate " + std::to_string(index) + " of " +
                                  std::to_string(door.degrees_of_freedom()));
    }
  }
}

/// So many of the numbers as are taken at a time.
template <class S>
bool add_derivatives(const InverseDynamicsOf<S>& engine, const SeededState& seeded, double time, std::size_t count,
                     StateGradient& found) {
  const AssemblyBranch<S>& branch = engine.branch();
  DriveQuantities quantities;
  quantities.coordinates = branch.independent();
  DualEvaluator<S> moment(seeded.mechanism, branch.tree(), branch.required_coordinates(), quantities,
                          branch.has_redundant_closures(), branch.freedoms(),
                          to_vector<S>(engine.options.about).template cast<DualNumber>());
  moment.differentiate_motion(branch.y(), seeded.target);
  if (!moment.evaluate(time, engine.options.time_scale, Detail::all)) return false;
  SampleOf<DualNumber> seen = moment.sample();
  seen.mobility = moment.mobility();
  for (std::size_t k = 0; k < count; ++k) {
    found.derivatives.push_back(derivative_of(seen, k));
    found.closure_gaps.push_back(moment.closure_gaps(k));
  }
  return true;
}

Expected<StateGradient> evaluate_state(InverseDynamics& door, const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                       double time) {
  Expected<Sample> here = door.at(q, dq, ddq, time);
  return {here.outcome, {std::move(here.value), {}, {}}};
}

DriveSampleOf<DualNumber> target_of(const VectorX& q, const VectorX& dq, const VectorX& ddq) {
  return {q.cast<DualNumber>(),          dq.cast<DualNumber>(),
          ddq.cast<DualNumber>(),        Matrix3Of<DualNumber>::Identity(),
          Vector3Of<DualNumber>::Zero(), Vector3Of<DualNumber>::Zero()};
}

/// @return whether the actuators hold the mechanism
bool add_state_derivatives(const InverseDynamics& door, const SeededState& seeded, double time, std::size_t count,
                           Expected<StateGradient>& found) {
  const auto& engine = door.implementation();
  const bool held = dispatch_space(door.mechanism().space, [&]<class S>(S) {
    return add_derivatives(static_cast<const InverseDynamicsOf<S>&>(engine), seeded, time, count, found.value);
  });
  if (held) return true;
  found.outcome.status = MotionStatus::actuation_singularity;
  found.outcome.reason = "actuation singularity: the efforts have no derivatives there";
  return false;
}

}  // namespace

Expected<StateGradient> differentiate_state(InverseDynamics& door, const VectorX& q, const VectorX& dq,
                                            const VectorX& ddq, const std::vector<DifferentiationVariable>& wanted,
                                            double time) {
  check(door, wanted);
  Expected<StateGradient> found = evaluate_state(door, q, dq, ddq, time);
  if (!found) return found;
  const SeededState plain{to_dual(door.mechanism()), target_of(q, dq, ddq)};
  for (std::size_t first = 0; first < wanted.size(); first += dual_width) {
    const std::size_t count = std::min<std::size_t>(dual_width, wanted.size() - first);
    SeededState seeded = plain;
    for (std::size_t k = 0; k < count; ++k) seeded.seed(wanted[first + k], k);
    if (!add_state_derivatives(door, seeded, time, count, found)) break;
  }
  return found;
}

Expected<StateGradient> derivatives(InverseDynamics& door, const MechanismOf<DualNumber>& mechanism, const VectorX& q,
                                    const VectorX& dq, const VectorX& ddq, double time) {
  Expected<StateGradient> found = evaluate_state(door, q, dq, ddq, time);
  if (found) add_state_derivatives(door, {mechanism, target_of(q, dq, ddq)}, time, dual_width, found);
  return found;
}

}  // namespace balance
