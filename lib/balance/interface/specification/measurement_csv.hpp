#pragma once
/// Reads records of measurements from a machine's log.

#include "balance/interface/specification/display_units.hpp"
#include "balance/motion/simulation/measurement_record.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {

struct RecordOptions {
  /// Other names of columns: "A1.effort" and "tau1", or "A1" and "2", the number of the column from 1.
  std::vector<std::pair<std::string, std::string>> columns = {};
  std::optional<std::pair<long, long>> rows = {};      ///< first and last row of numbers, from 1; the rest is not read
  std::optional<std::pair<double, double>> time = {};  ///< first and last time, in the unit of the spec
  std::string prefix = "--";                           ///< of the names of these options in messages
};

/// A CSV file has a line of names (none if columns are chosen by numbers) and lines of numbers, separated by commas,
/// semicolons or tabs; `#` starts a comment. Names are `time`; of a coordinate `A1`, `A1.position`, `A1.rate` or
/// `A1.velocity`; of an actuator `A1.effort`, `A1.torque`, `tau_A1` or `A1.current`; of the frame `fx`, `fy`, `m`, in space
/// `fx` … `mz`. A unit in brackets, `A1 [deg]`, replaces that of the spec. Other columns are not read.
///
/// A last line that was cut off is dropped. Angles that jump by full turns are continued.
/// @throws SystemError with the file, the row and the column: times that do not increase, values that are no numbers or
/// beyond all others, missing or unknown columns
MeasurementRecord read_measurement_csv(const std::string& path, const Mechanism& mechanism, const SpecUnits& units,
                                       const RecordOptions& options = {});

}  // namespace balance::specification
