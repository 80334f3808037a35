#pragma once
/// A Result as a group of an HDF5 file: the root of a run's own file, or one of several runs in a design's.

#include "balance/hdf5/file.hpp"
#include "balance/result/result.hpp"
#include "balance/write/write_options.hpp"

namespace balance {

/// Attributes of the root that say where the file comes from.
void describe_source(Hdf5File& file, const FileDescription& description);

/// Attributes that say what was run.
void describe_run(Hdf5File& file, Hdf5File::Group group, const FileDescription& description);

/// Attributes that say how a run under control ended.
void describe_end(Hdf5File& file, Hdf5File::Group group, const MotionOutcome& outcome);

/// All dimensions and datasets of a result that has samples, metrics included.
/// @throws Cancelled if options.cancelled says so
void add_result(Hdf5File& file, Hdf5File::Group group, const Result& result, const WriteOptions& options);

/// Standard deviations of a run's samples, under the same names; orientations in space have none, nor have counts.
/// @throws Cancelled if options.cancelled says so
void add_deviations(Hdf5File& file, Hdf5File::Group group, const Result& deviation, const WriteOptions& options);

}  // namespace balance
