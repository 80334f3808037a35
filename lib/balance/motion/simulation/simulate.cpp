#include "balance/motion/simulation/simulate.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/term_magnitude_recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/group_stepper.hpp"
#include "balance/motion/simulation/run_recorder.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace balance::simulation {

namespace {

/// Selects samples for term magnitudes: some fifty evenly spaced ones, and those with larger accelerations or a smaller
/// mobility than all before.
class MagnitudeSampling {
 public:
  explicit MagnitudeSampling(long samples) : stride_(std::max(1L, samples / 50)) {}

  bool is_sample_due(long row, const VectorX& accelerations, double mobility) {
    const double max_acceleration = numerics::max_abs(accelerations);
    if (row % stride_ != 0 && max_acceleration <= 1.25 * max_acceleration_ && mobility >= 0.8 * min_mobility_)
      return false;
    max_acceleration_ = std::max(max_acceleration_, max_acceleration);
    min_mobility_ = std::min(min_mobility_, mobility);
    return true;
  }

 private:
  long stride_;
  double max_acceleration_ = 0, min_mobility_ = 1;
};

template <class S>
class SimulationRun : public RunRecorder {
 public:
  SimulationRun(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress)
      : RunRecorder(mechanism, trajectory, progress),
        motion_(mechanism, trajectory),
        source_(mechanism, motion_, trajectory.about, dynamics::Detail::all),
        magnitude_sampling_(trajectory.samples) {}

  RunResult run() {
    if (source_.outcome().status != MotionStatus::done) return record(source_, {}, 1);
    const double inverse_duration = 1 / source_.prescribed_motion().duration(),
                 free_fall = mechanism_.gravity.norm() / source_.tree().characteristic_length;
    magnitude_recorder_.emplace(
        mechanism_, source_.tree(), source_.about(),
        dynamics::RestScale{inverse_duration, std::max(inverse_duration * inverse_duration, free_fall)});
    group_stepper_.emplace(source_, trajectory_.samples);
    return record(*group_stepper_, {}, 1 + (1 << 15) / (8 + source_.tree().columns));  // large mechanisms take longer
  }

 private:
  void take_sample(long row) override {
    const Sample& sample = group_stepper_->sample();
    if (magnitude_sampling_.is_sample_due(row, sample.acceleration, sample.mobility))
      magnitude_recorder_->sample(group_stepper_->at_current_sample(), sample,
                                  source_.evaluator().actuation().multipliers(), sample.mobility);
  }

  void set_term_magnitudes(RunResult& result) override {
    set_round_off(result, magnitude_recorder_->magnitudes(), magnitude_recorder_->amplified_magnitudes());
  }

  std::vector<std::string> actuation_notes() override { return source_.evaluator().actuation().notes(); }

  std::vector<std::string> motion_notes() override {
    std::vector<std::string> notes = source_.stepper().notes();
    for (const model::PassiveFreedom& spin : source_.tree().locked_freedoms)
      notes.push_back(trajectory::describe_locked_freedom(mechanism_, spin));
    return notes;
  }

  const kinematics::CompiledMotion<S> motion_;
  dynamics::TreeMotionSource<S> source_;
  std::optional<GroupStepper<S>> group_stepper_;
  std::optional<dynamics::TermMagnitudeRecorder<S>> magnitude_recorder_;
  MagnitudeSampling magnitude_sampling_;
};

}  // namespace

RunResult simulate(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress) {
  return run_resolved(mechanism, trajectory, [&](const Mechanism& modelled, const Trajectory& resolved) {
    return kinematics::dispatch_space(modelled.space,
                                      [&]<class S>(S) { return SimulationRun<S>(modelled, resolved, progress).run(); });
  });
}

}  // namespace balance::simulation
