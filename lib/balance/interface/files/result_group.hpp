#pragma once
/// A RunResult as a group of an HDF5 file: the root of a run's own file, or one of several runs in a design file.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/mechanics/results/result.hpp"

#include <functional>
#include <string>

namespace balance::files {

/// The figures of one quantity.
const ReportFields<Metric>& metric_fields();

// Payloads taken up or set down during a run, as text, JSON and HDF5.

/// "cargo taken up at 0.2 s: R1 from 3.1 to 7.4 N m, R2 from …", one line each; empty if there are none.
std::string format_payload_events(const RunResult& result, const specification::SpecUnits& units = {});

/// [{payload, change, time, speed, turning, torque: [{actuator, unit, before, after}]}].
Json payload_events_json(const RunResult& result);

/// Writes the group `payload_changes`, unless it would be empty.
void write_payload_events(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const RunResult& result);

// Counterweights that moved with the payload during a run.

/// "cw1 moved from 0 to 75 mm, 1 to 1.3 s: force up to 35 N, work 4.2 J, 5 J back and forth, …", one line each, and the
/// time and energy of all; empty if there are none.
std::string format_adaptation(const RunResult& result, const specification::SpecUnits& units = {});

/// {start, end, work, energy, moves: [{counterweight, start, end, from, to, work, energy, torque: [{actuator, unit, peak}]}]}.
Json adaptation_json(const RunResult& result);

/// Writes the group `adaptation`, unless it would be empty.
void write_adaptation(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const RunResult& result);

/// Writes attributes of the root with the provenance of the file, then what `write` adds: the complete file or none.
/// @throws SystemError, Cancelled
void write_hdf5_file(const std::string& path, const Provenance& description, const WriteOptions& options,
                     const std::function<void(hdf5::Hdf5Writer&)>& write);

/// Writes attributes that describe the run.
void write_run_attributes(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const Provenance& description);

/// Writes attributes that describe how a controlled run ended.
void write_outcome_attributes(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const MotionOutcome& outcome);

/// Writes all dimensions and datasets of a result that has samples, including metrics.
/// @throws Cancelled if options.is_cancelled returns true
void write_result_variables(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const RunResult& result,
                            const WriteOptions& options);

/// Writes the standard deviations of a run's samples under the same names, except for spatial orientations and counts.
/// @throws Cancelled if options.is_cancelled returns true
void write_deviation_variables(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const RunResult& deviation,
                               const WriteOptions& options);

}  // namespace balance::files
