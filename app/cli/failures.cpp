#include "cli/failures.hpp"

#include "balance/interface/specification/spec_locations.hpp"

namespace balance::app {

MotionFailure::MotionFailure(const MotionOutcome& result, const Study& study, const std::string& trajectory)
    : MotionFailure(result) {
  const Trajectory* found = study::find_by_name(study.trajectories, trajectory);
  if (found == nullptr) return;
  if (found->free_motion || (result.status == MotionStatus::mismatch && found->drive == DriveKind::joints))
    place = specification::locate_trajectory(study, *found);
}

std::string MotionFailure::text() const { return (place.line > 0 ? place.text() + ": " : "error: ") + what(); }

}  // namespace balance::app
