#pragma once
/// Reads and writes result files; docs/file-format.md describes the format.

#include "balance/interface/files/atomic_file.hpp"
#include "balance/mechanics/results/result.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace balance::files {

/// A run read from a file: its provenance and all of its samples and metrics.
struct StoredRun {
  std::string path;   ///< as named by the user, without the group
  std::string group;  ///< in a design file: "after/cycloid"; "" for a run's own file
  std::string title;  ///< the mechanism's name
  std::string version, spec_text, command_line;
  std::vector<std::pair<std::string, std::string>>
      overrides;  ///< parameter values that the spec was read with: `--set`
  std::string trajectory, law, drive, formulation;
  std::string controller, controller_type;  ///< of a controlled run; otherwise empty
  std::string at;                           ///< pose of a single state (`simulate --at`); empty for a run
  std::string ended_early;                  ///< why a controlled run did not reach its end; otherwise empty
  VectorX free_values;                      ///< of a design file: the spec's free numbers in this run [SI]; else empty
  RunResult result;                         ///< outcome.status is done; outcome.notes are not stored
};

/// Whether a name refers to a result file rather than a spec: `….h5`, `….hdf5`, `….nc`, or a group of one after a
/// colon.
bool names_result_file(const std::string& name);

/// Reads `run.h5`, or one run of a design file: `design.h5:after/cycloid`.
/// @throws SystemError with the name and the reason: no such file, not HDF5, not written by this program, equations of
/// motion (`equations -o`), a dataset missing or of another size (a damaged file), a group that does not exist (lists
/// those that do)
StoredRun read_result_file(const std::string& name);

/// The same for a motion. @throws SystemError as read_result_file, and for a single state, which has no figures to
/// compare or to plot
StoredRun read_motion_file(const std::string& name);

// What every result file contains besides the result.

/// Where a result comes from.
struct Provenance {
  std::string title;         ///< the mechanism's name
  std::string version;       ///< of the program
  std::string spec_text;     ///< the whole spec
  std::string command_line;  ///< command that computes the same file again, for people
  std::vector<std::pair<std::string, std::string>>
      overrides;           ///< parameter values that the spec was read with: `--set`
  std::string trajectory;  ///< its name
  std::string law;         ///< as in the spec: "cycloidal"
  std::string drive;       ///< as in the spec: "tool"
  std::string formulation = "tree";
  std::string controller;       ///< its name; empty: none
  std::string controller_type;  ///< as in the spec: "computed-torque"
  std::string pose;             ///< pose of a single state, as requested; empty: a run along the trajectory
};

enum class Compression { none, gzip };

struct WriteOptions {
  OverwritePolicy existing = OverwritePolicy::forbid;
  Durability durability = Durability::synced;
  Compression compression = Compression::none;  ///< HDF5 only; takes more than ten times as long as the dynamics
  std::function<bool()> is_cancelled;           ///< polled from time to time if set; true cancels and leaves no file
  std::string temporary_tag;                    ///< part of the temporary file's name, as for AtomicFile
};

/// @throws Cancelled if the user cancels
inline void throw_if_cancelled(const WriteOptions& options) {
  if (options.is_cancelled && options.is_cancelled()) throw Cancelled("interrupted, nothing written");
}

// A RunResult as CSV.

/// One row per sample; the first line names each column with its unit in brackets: `time [s],A1.position [rad],…`.
/// Numbers have 17 significant digits, enough to recover the same double. Written under a temporary name and renamed
/// when complete.
/// @throws SystemError, Cancelled, std::invalid_argument as write_result_hdf5
void write_result_csv(const std::string& path, const RunResult& result, const WriteOptions& options = {});

// A RunResult as HDF5 that is also netCDF-4; docs/file-format.md describes the format.

/// Writes the file under a temporary name and renames it when it is complete. The same result and description give the
/// same bytes. The samples are not copied.
/// @param result of a completed run, or of a controlled run that ended early
/// @throws SystemError with path and reason; an older file of that name is then unchanged
/// @throws Cancelled if options.is_cancelled returns true
/// @throws std::invalid_argument if the result is neither, has no samples, or has inconsistent sizes
void write_result_hdf5(const std::string& path, const RunResult& result, const Provenance& description,
                       const WriteOptions& options = {});

}  // namespace balance::files

namespace balance {

using files::read_result_file;
using files::write_result_csv;
using files::write_result_hdf5;

}  // namespace balance
