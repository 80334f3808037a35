#pragma once
/// Reading back what a run was written to; docs/file-format.md describes the file.

#include "balance/result/result.hpp"

#include <string>

namespace balance {

/// A run from a file: where it comes from and all of its samples and metrics.
struct StoredRun {
  std::string path;   ///< as named by the user, without the group
  std::string group;  ///< of a design file: "after/cycloid"; "" for a run's own file
  std::string title;  ///< the mechanism's name
  std::string version, spec_text, command_line;
  std::string trajectory, law, drive, formulation;
  std::string controller, controller_type;  ///< of a run under control; else empty
  std::string at;                           ///< of a single state (`simulate --at`): the pose; of a run empty
  std::string ended_early;                  ///< why a run under control did not reach its end; else empty
  RunResult result;                         ///< outcome.status is done; outcome.notes are not stored
};

/// Whether a name is that of a result file rather than of a spec: `….h5`, `….hdf5`, `….nc`, or a group of one behind a colon.
bool names_result_file(const std::string& name);

/// Reads `run.h5`, or one run of a design file: `design.h5:after/cycloid`.
/// @throws SystemError with the name and what is wrong: no such file, not HDF5, not written by this program, equations of motion
/// (`equations -o`), a dataset missing or of another size (a damaged file), a group that does not exist (with those that do)
StoredRun read_result_file(const std::string& name);

/// The same, of a motion. @throws SystemError as read_result_file, and for a single state, which has no figures to compare or to draw
StoredRun read_motion_file(const std::string& name);

}  // namespace balance
