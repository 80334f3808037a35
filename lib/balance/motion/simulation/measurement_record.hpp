#pragma once
/// What was measured with a machine: positions and efforts over time, as plain numbers.

#include "balance/foundation/base/types.hpp"

#include <string>
#include <vector>

namespace balance::simulation {

/// The meaning of one column of a record.
struct MeasuredSignal {
  enum class Kind {
    position,  ///< of a joint coordinate [rad or m]
    rate,      ///< of a joint coordinate; compared with the positions only
    effort,    ///< of an actuator [N m or N]
    current,   ///< of an actuator's motor [A]
    frame,     ///< component of the force [N] or moment about the world's origin [N m] on the frame
  };
  Kind kind = Kind::position;
  int index = 0;  ///< coordinate or actuator of the mechanism, or row of MotionEquation::frame

  friend bool operator==(const MeasuredSignal&, const MeasuredSignal&) = default;
};

/// One record. Angles have no jumps by full turns.
struct MeasurementRecord {
  std::string source;                   ///< name of the file
  VectorX time;                         ///< N, increasing [s]
  std::vector<MeasuredSignal> signals;  ///< per column, all different
  MatrixX values;                       ///< N × signals [SI; currents in A]
  std::vector<std::string> payloads;    ///< payloads of the mechanism that were carried, by name
  std::vector<std::string> notes;       ///< what the reader did: rows dropped, turns counted
};

/// Index of a signal among a record's columns; −1 if it was not measured.
int find_signal(const MeasurementRecord& record, MeasuredSignal signal);

}  // namespace balance::simulation

namespace balance {

using simulation::MeasuredSignal;
using simulation::MeasurementRecord;

}  // namespace balance
