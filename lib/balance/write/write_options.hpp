#pragma once
/// What every result file needs to know beyond the result.

#include "balance/write/pending_file.hpp"

#include <functional>
#include <string>

namespace balance {

/// Where a result comes from.
struct Provenance {
  std::string title;         ///< the mechanism's name
  std::string version;       ///< of the program
  std::string spec_text;     ///< the whole spec
  std::string command_line;  ///< what computes the same file again
  std::string trajectory;    ///< its name
  std::string law;           ///< as in the spec: "cycloidal"
  std::string drive;         ///< as in the spec: "tool"
  std::string formulation = "tree";
  std::string controller;       ///< its name; empty: a run without one
  std::string controller_type;  ///< as in the spec: "computed-torque"
  std::string pose;             ///< a single state, as it was asked for; empty: a run along the trajectory
};

enum class Compression { none, gzip };

struct WriteOptions {
  OverwritePolicy existing = OverwritePolicy::forbid;
  Durability durability = Durability::synced;
  Compression compression = Compression::none;  ///< HDF5 only; costs more than ten times the dynamics
  std::function<bool()> is_cancelled;           ///< asked now and then if set; true stops and leaves no file
  std::string temporary_tag;                    ///< in the temporary file's name, as for AtomicFile
};

/// @throws Cancelled if the user wants to stop
inline void throw_if_cancelled(const WriteOptions& options) {
  if (options.is_cancelled && options.is_cancelled()) throw Cancelled("interrupted, nothing written");
}

}  // namespace balance
