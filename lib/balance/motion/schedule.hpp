#pragma once
/// The prescribed quantities as functions of time: a path in the drive's components, run through by a law.

#include "balance/base/types.hpp"
#include "balance/kinematics/drive_sample.hpp"
#include "balance/motion/trajectory.hpp"

#include <memory>
#include <vector>

namespace balance {

/// A law on a path. Immutable; evaluation allocates nothing once the sample has its size.
class Schedule {
 public:
  struct Request {
    Law law;
    Path path;
    double duration = 1;  ///< [s]; replaced by a table's own
    DriveValue from,
        to;  ///< same k. Tables ignore both (k may be given by the table alone); of `to` a circle takes only what does not go round, and nothing where `to.value` is empty
    std::vector<DriveValue> via;  ///< WaypointPath: the points in the drive's components, in order
    int position_components =
        0;  ///< how many leading components are a point's coordinates (2 or 3): arcs and chord lengths use them
    bool turns = false;  ///< the rotation is prescribed too; it follows the shortest rotation, leg by leg
  };

  /// @throws std::invalid_argument if sizes differ, numbers are not finite, the law is not valid, an arc's three points lie on one line, a circle is asked of
  ///         something that is no point, or times do not increase. The message is fit for a user.
  explicit Schedule(const Request& request);
  ~Schedule();
  Schedule(Schedule&&) noexcept;
  Schedule& operator=(Schedule&&) noexcept;

  /// @param time in [0, duration] (counted from the table's first time for a table)
  /// @param side which limit to take where the acceleration jumps; at the ends the inner one is always taken. Times nearer
  ///        to a jump than 1e-12 of the duration are the jump.
  /// @throws std::invalid_argument if time is further outside than round-off explains (1e-9 of the duration)
  void at(double time, Side side, DriveSample& sample) const;

  double duration() const;
  /// Number k of scalar components.
  int size() const;
  /// Times strictly inside (0, duration) at which an acceleration (or a velocity: uniform legs) jumps, increasing.
  const std::vector<double>& jumps() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace balance
