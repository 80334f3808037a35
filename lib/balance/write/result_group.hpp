#pragma once
/// A Result as a group of an HDF5 file: the root of a run's own file, or one of several runs in a design's.

#include "balance/hdf5/file.hpp"
#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

namespace balance {

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
