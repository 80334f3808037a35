#include "balance/mechanics/dynamics/single_state.hpp"

#include "balance/mechanics/dynamics/inverse_dynamics_impl.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace balance::dynamics {

namespace {

template <class S>
class SingleStateEvaluator {
 public:
  SingleStateEvaluator(const Mechanism& mechanism, const SingleState& state, const InverseOptions& options)
      : state_(state), engine_(mechanism, options) {}

  RunResult evaluate() {
    const Mechanism& mechanism = engine_.mechanism;
    const std::vector<CoordinateId>& independent = engine_.branch().independent();
    const VectorX dq = independent_rates(mechanism, independent, state_.rates),
                  ddq = independent_rates(mechanism, independent, state_.accelerations);
    const VectorX q = independent_positions(independent, state_.configuration);
    VectorX coordinates;
    RunResult result;
    result.outcome = engine_.assemble(q.data(), state_.configuration, coordinates);
    if (result.outcome.status != MotionStatus::done) return result;
    Sample sample;
    MotionOutcome outcome = engine_.observe({q.data(), dq.data(), ddq.data(), state_.time}, sample);
    const bool lacks_efforts =
        outcome.status == MotionStatus::mismatch || outcome.status == MotionStatus::actuation_singularity;
    if (outcome.status != MotionStatus::done && !lacks_efforts) {
      result.outcome = std::move(outcome);
      return result;
    }
    restore_turns(sample);
    record(sample, result);
    result.outcome.notes = engine_.notes;
    if (lacks_efforts)
      result.outcome.notes.push_back("no torques: " + outcome.reason);
    else
      record_torque_distribution(engine_.mechanism, {}, 0, results::EffortOrigin::motion, result);
    for (const Quantity& quantity : list_sampled_quantities(result))
      if (!quantity.samples->allFinite()) (result.*quantity.member).resize(0, 0);
    return result;
  }

 private:
  /// Angles of loop joints are read off poses, which do not determine full turns.
  void restore_turns(Sample& sample) const {
    for (const CoordinateValue& coordinate_value : state_.configuration) {
      if (engine_.mechanism.coordinates[coordinate_value.coordinate].kind != CoordinateKind::angle) continue;
      double& position = sample.position[coordinate_value.coordinate];
      position += 2 * std::numbers::pi * std::round((coordinate_value.value - position) / (2 * std::numbers::pi));
    }
  }

  void record(const Sample& sample, RunResult& result) {
    name_columns(engine_.mechanism, result);
    results::resize_arrays(engine_.mechanism, 1, {}, result);
    result.moment_reference = engine_.options.about;
    results::ResultRecorder(result).write(sample, 0, result);
    result.time[0] = state_.time;
    results::TermMagnitudes terms, amplified;
    engine_.measure_terms(sample, state_.time, terms, amplified);
    set_round_off(result, terms, amplified);
    clear_round_off(result);
  }

  const SingleState& state_;
  InverseDynamicsOf<S> engine_;
};

}  // namespace

InverseOptions make_state_options(const Trajectory* trajectory) {
  InverseOptions options{.about = Vector3::Zero(), .time_scale = 1};
  if (trajectory == nullptr) return options;
  options.about = trajectory->about;
  if (trajectory->duration > 0) options.time_scale = trajectory->duration;
  return options;
}

VectorX independent_rates(const Mechanism& mechanism, const std::vector<CoordinateId>& independent,
                          const std::vector<CoordinateValue>& values) {
  VectorX rates = VectorX::Zero(static_cast<Eigen::Index>(independent.size()));
  for (const CoordinateValue& value : values) {
    const auto entry = std::find(independent.begin(), independent.end(), value.coordinate);
    if (entry == independent.end())
      throw std::invalid_argument("rates must be those of independent coordinates; " +
                                  mechanism.coordinates[static_cast<std::size_t>(value.coordinate)].name +
                                  " is not one of them");
    rates[entry - independent.begin()] = value.value;
  }
  return rates;
}

VectorX independent_positions(const std::vector<CoordinateId>& independent,
                              const std::vector<CoordinateValue>& configuration) {
  VectorX q = VectorX::Zero(static_cast<Eigen::Index>(independent.size()));
  for (const CoordinateValue& coordinate_value : configuration)
    for (std::size_t k = 0; k < independent.size(); ++k)
      if (independent[k] == coordinate_value.coordinate) q[static_cast<Eigen::Index>(k)] = coordinate_value.value;
  return q;
}

RunResult evaluate_single_state(const Mechanism& mechanism, const SingleState& state, const InverseOptions& options) {
  require_valid(mechanism);
  if (!std::isfinite(state.time)) throw std::invalid_argument("time: expected a finite number");
  const Mechanism loaded_mechanism = mechanism_at_time(mechanism, state.time);
  RunResult result = kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    return SingleStateEvaluator<S>(loaded_mechanism, state, options).evaluate();
  });
  for (std::string& note : list_payload_notes(mechanism, state.time)) result.outcome.notes.push_back(std::move(note));
  return result;
}

}  // namespace balance::dynamics
