#pragma once
/// What the runs of both formulations have in common: one motion, recorded from its begin to its end.

#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/trajectory/motion_source.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance::simulation {

class RunRecorder {
 public:
  /// All references must outlive the recorder.
  RunRecorder(const Mechanism& mechanism, const Trajectory& trajectory, const Progress& progress)
      : mechanism_(mechanism), trajectory_(trajectory), progress_(progress) {}
  virtual ~RunRecorder() = default;
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

 protected:
  /// @param samples_per_report samples between two calls of Progress
  RunResult record(trajectory::MotionSource& source, const results::RecordedContents& contents,
                   long samples_per_report);

  const Mechanism& mechanism_;
  const Trajectory& trajectory_;

 private:
  /// The sample that the source evaluated last has been written into this row.
  virtual void take_sample(long /*row*/) {}
  /// Sets the magnitudes of the terms that the figures are made of, and with them the figures' round-off.
  virtual void set_term_magnitudes(RunResult& result) = 0;
  virtual std::vector<std::string> actuation_notes() = 0;
  virtual std::vector<std::string> motion_notes() { return {}; }

  const Progress& progress_;
};

using Run = std::function<RunResult(const Mechanism& mechanism, const Trajectory& trajectory)>;

/// Runs along a trajectory once its counterweights that move are modelled, the motion of its free coordinates and its
/// law, momentum and path have been found, and adds what was found to the result.
/// @param run of the mechanism and the trajectory that this leads to
RunResult run_resolved(const Mechanism& mechanism, const Trajectory& trajectory, const Run& run);

}  // namespace balance::simulation
