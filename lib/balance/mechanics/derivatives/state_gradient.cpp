#include "balance/mechanics/derivatives/state_gradient.hpp"

#include "balance/mechanics/derivatives/dual_evaluator.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics_impl.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::derivatives {

namespace {

/// The state and the mechanism, seeded with a few variables.
struct SeededState {
  MechanismOf<DualNumber> mechanism;
  trajectory::DriveSampleOf<DualNumber> target;

  void seed(const DifferentiationVariable& variable, std::size_t k) {
    if (const auto* number = std::get_if<MechanismVariable>(&variable)) {
      variable_in(mechanism, *number).d[k] = 1;
      if (has_symmetric_entry(*number))
        variable_in(mechanism, {number->kind, number->index, number->column, number->row}).d[k] = 1;
      return;
    }
    const StateVariable& state_variable = std::get<StateVariable>(variable);
    auto& values = state_variable.kind == StateVariable::Kind::q    ? target.value
                   : state_variable.kind == StateVariable::Kind::dq ? target.rate
                                                                    : target.acceleration;
    values[state_variable.index].d[k] = 1;
  }
};

void require_variables(const InverseDynamics& inverse_dynamics, const std::vector<DifferentiationVariable>& variables) {
  for (const DifferentiationVariable& variable : variables) {
    if (const auto* number = std::get_if<MechanismVariable>(&variable)) {
      require_variable(inverse_dynamics.mechanism(), *number);
    } else if (const int index = std::get<StateVariable>(variable).index;
               index < 0 || index >= inverse_dynamics.degrees_of_freedom()) {
      throw std::invalid_argument("state variable: there is no coordinate " + std::to_string(index) + " of " +
                                  std::to_string(inverse_dynamics.degrees_of_freedom()));
    }
  }
}

/// Appends the derivatives with respect to the `count` variables seeded. @return whether the actuators hold the
/// mechanism
template <class S>
bool add_derivatives(const dynamics::InverseDynamicsOf<S>& engine, const SeededState& seeded, double time,
                     std::size_t count, StateGradient& gradient) {
  const kinematics::AssemblyBranch<S>& branch = engine.branch();
  trajectory::DriveQuantities quantities;
  quantities.coordinates = branch.independent();
  DualEvaluator<S> evaluator(seeded.mechanism, branch.tree(), branch.required_coordinates(), quantities,
                             branch.has_redundant_closures(), branch.freedoms(),
                             kinematics::to_vector<S>(engine.options.about).template cast<DualNumber>());
  evaluator.differentiate_motion(branch.y(), seeded.target);
  if (!evaluator.evaluate(time, engine.options.time_scale, dynamics::Detail::all)) return false;
  trajectory::SampleOf<DualNumber> sample = evaluator.sample();
  sample.mobility = evaluator.mobility();
  for (std::size_t k = 0; k < count; ++k) {
    gradient.derivatives.push_back(derivative_of(sample, k));
    gradient.closure_gaps.push_back(evaluator.closure_gaps(k));
  }
  return true;
}

Expected<StateGradient> evaluate_state(InverseDynamics& inverse_dynamics, const VectorX& q, const VectorX& dq,
                                       const VectorX& ddq, double time) {
  Expected<Sample> sample = inverse_dynamics.at(q, dq, ddq, time);
  return {sample.outcome, {std::move(sample.value), {}, {}}};
}

trajectory::DriveSampleOf<DualNumber> target_of(const VectorX& q, const VectorX& dq, const VectorX& ddq) {
  return {q.cast<DualNumber>(),          dq.cast<DualNumber>(),
          ddq.cast<DualNumber>(),        Matrix3Of<DualNumber>::Identity(),
          Vector3Of<DualNumber>::Zero(), Vector3Of<DualNumber>::Zero()};
}

/// @return whether the actuators hold the mechanism
bool add_state_derivatives(const InverseDynamics& inverse_dynamics, const SeededState& seeded, double time,
                           std::size_t count, Expected<StateGradient>& gradient) {
  const auto& engine = inverse_dynamics.implementation();
  const bool is_held = kinematics::dispatch_space(inverse_dynamics.mechanism().space, [&]<class S>(S) {
    return add_derivatives(static_cast<const dynamics::InverseDynamicsOf<S>&>(engine), seeded, time, count,
                           gradient.value);
  });
  if (is_held) return true;
  gradient.outcome.status = MotionStatus::actuation_singularity;
  gradient.outcome.reason = "actuation singularity: the efforts have no derivatives there";
  return false;
}

}  // namespace

Expected<StateGradient> differentiate_state(InverseDynamics& inverse_dynamics, const VectorX& q, const VectorX& dq,
                                            const VectorX& ddq, const std::vector<DifferentiationVariable>& variables,
                                            double time) {
  require_variables(inverse_dynamics, variables);
  Expected<StateGradient> gradient = evaluate_state(inverse_dynamics, q, dq, ddq, time);
  if (!gradient) return gradient;
  const SeededState unseeded{to_dual(inverse_dynamics.mechanism()), target_of(q, dq, ddq)};
  for (std::size_t first = 0; first < variables.size(); first += numerics::dual_width) {
    const std::size_t count = std::min<std::size_t>(numerics::dual_width, variables.size() - first);
    SeededState seeded = unseeded;
    for (std::size_t k = 0; k < count; ++k) seeded.seed(variables[first + k], k);
    if (!add_state_derivatives(inverse_dynamics, seeded, time, count, gradient)) break;
  }
  return gradient;
}

Expected<StateGradient> derivatives(InverseDynamics& inverse_dynamics, const MechanismOf<DualNumber>& mechanism,
                                    const VectorX& q, const VectorX& dq, const VectorX& ddq, double time) {
  Expected<StateGradient> gradient = evaluate_state(inverse_dynamics, q, dq, ddq, time);
  if (gradient)
    add_state_derivatives(inverse_dynamics, {mechanism, target_of(q, dq, ddq)}, time, numerics::dual_width, gradient);
  return gradient;
}

}  // namespace balance::derivatives
