#pragma once
/// The provenance of a result file.

#include "balance/interface/files/result_file.hpp"
#include "balance/motion/study/study.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::files {

/// Joins words to a command for a POSIX shell, quoted where necessary.
std::string join_command(std::vector<std::string> words);

/// Adds `--set NAME=VALUE` for every parameter that the study was read with a different value of.
void append_overrides(std::vector<std::string>& words, const Study& study);

/// What was requested, in terms of `balance simulate` or, with a controller, of `balance control`.
struct SimulateCommand {
  std::string spec_file;  ///< its folder is ignored
  std::string trajectory;
  std::optional<long> samples;
  std::optional<double> duration;  ///< [s]
  std::string about;               ///< "x,y" or "x,y,z"; empty: as in the spec
  bool compress = false;
  bool poses = false;
  std::optional<int> orders;
  std::optional<double> fluctuation;
  bool split = false;
  std::string formulation = "tree";  ///< or "natural"
  std::string controller = {};       ///< empty: none
  double settle = 0;                 ///< [s]
  long steps = 0;                    ///< maximum number of integration steps; 0: the default
};

/// A single state, in terms of `balance simulate --at`.
struct StateCommand {
  std::string spec_file;  ///< its folder is ignored
  std::string at, rates, accelerations;
  std::string trajectory;  ///< provides start, end and the reference point of moments; empty: the first
  std::vector<std::string> independent;
  double time = 0;    ///< [s]
  std::string about;  ///< "x,y" or "x,y,z"; empty: the trajectory's
  bool compress = false;
  bool poses = false;
};

/// The provenance of any result of a study.
/// @param command_line computes the same file again. It has neither options that do not change the content nor the
/// spec's folder: the same spec gives the same bytes wherever it and the result are stored.
Provenance make_provenance(const Study& study, std::string command_line);

/// @param trajectory one of the study's, possibly modified. The controller, if there is one, is one of the study's
Provenance make_simulation_provenance(const Study& study, const Trajectory& trajectory, const SimulateCommand& command);

Provenance describe_state(const Study& study, const StateCommand& command);

}  // namespace balance::files
