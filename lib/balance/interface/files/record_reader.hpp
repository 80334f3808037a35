#pragma once
/// Reads records of measurements: CSV from a machine's log, or HDF5 from `balance simulate`.

#include "balance/interface/specification/measurement_csv.hpp"

#include <string>

namespace balance::files {

/// @throws SystemError as specification::read_measurement_csv, or if a result is not of this mechanism
MeasurementRecord read_record_file(const std::string& path, const Mechanism& mechanism,
                                   const specification::SpecUnits& units,
                                   const specification::RecordOptions& options = {});

}  // namespace balance::files
