#pragma once
/// A RunResult as a group of an HDF5 file: the root of a run's own file, or one of several runs in a design's.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"

#include <string>

namespace balance {

// Payloads taken up and set down in a run, as text, JSON and HDF5.

/// "cargo taken up at 0.2 s: R1 from 3.1 to 7.4 N m, R2 from …", a line each; empty if there is none.
std::string format_payload_events(const RunResult& result);

/// [{payload, change, time, speed, turning, torque: [{actuator, unit, before, after}]}].
Json payload_events_json(const RunResult& result);

/// The group `payload_events`, if there is any.
void write_payload_events(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result);

/// Attributes of the root that say where the file comes from.
void write_source_attributes(Hdf5Writer& file, const Provenance& description);

/// Attributes that say what was run.
void write_run_attributes(Hdf5Writer& file, Hdf5Writer::Group group, const Provenance& description);

/// Attributes that say how a run under control ended.
void write_outcome_attributes(Hdf5Writer& file, Hdf5Writer::Group group, const MotionOutcome& outcome);

/// All dimensions and datasets of a result that has samples, metrics included.
/// @throws Cancelled if options.cancelled says so
void write_result_variables(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& result,
                            const WriteOptions& options);

/// Standard deviations of a run's samples, under the same names; orientations in space have none, nor have counts.
/// @throws Cancelled if options.cancelled says so
void write_deviation_variables(Hdf5Writer& file, Hdf5Writer::Group group, const RunResult& deviation,
                               const WriteOptions& options);

}  // namespace balance
