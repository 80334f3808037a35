#pragma once
/// What a run under control looks like at one moment, as a row of a Result. Private to analysis.

#include "balance/control/control_law.hpp"
#include "balance/control/desired_motion.hpp"
#include "balance/control/plant.hpp"
#include "balance/result/recorder.hpp"

#include <optional>

namespace balance {

/// Of the controller, at one moment.
struct ControllerState {
  const VectorX& variation;  ///< sum of all changes of the efforts so far, per actuator
  const VectorX& saturated;  ///< 1 where the limit cuts, per actuator; may be empty
};

class ClosedLoopRecorder {
 public:
  /// @param desired may be filled in later, but stays where it is; law must be started before rows are written
  ClosedLoopRecorder(const Mechanism& mechanism, const ControlLaw& law, const DesiredMotion& desired)
      : mechanism_(mechanism), law_(law), desired_(desired) {}

  /// Names and room for as many rows. Nothing that a desired motion is needed for if that motion is not known.
  void allocate_rows(long rows, const Vector3& about, RunResult& result) const;

  /// @param event row of the desired motion
  void write_row(const Sample& seen, const ControllerState& state, double time, Eigen::Index event, long row,
                 RunResult& result);

 private:
  void write_tracking_errors(Eigen::Index event);

  const Mechanism& mechanism_;
  const ControlLaw& law_;
  const DesiredMotion& desired_;
  std::optional<ResultRecorder> recorder_;
  Sample sample_;
};

}  // namespace balance
