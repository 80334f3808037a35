#pragma once
/// Where the file of a run comes from, in the words that it is described by.

#include "balance/interface/files/result_file.hpp"
#include "balance/motion/study/study.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// Words as a command for a POSIX shell, quoted where they need to be.
std::string join_command(std::vector<std::string> words);

/// Adds `--set NAME=VALUE` for every parameter that the study was read with another value of.
void append_overrides(std::vector<std::string>& words, const Study& study);

/// What was asked for, as it would be asked of `balance simulate` or, with a controller, of `balance control`.
struct SimulateCommand {
  std::string spec_file;  ///< its folder does not matter
  std::string trajectory;
  std::optional<long> samples;
  std::optional<double> duration;  ///< [s]
  std::string about;               ///< "x,y" or "x,y,z"; empty: as in the spec
  bool compress = false;
  bool poses = false;
  bool split = false;
  std::string formulation = "tree";  ///< or "natural"
  std::string controller = {};       ///< empty: none
  double settle = 0;                 ///< [s]
  long steps = 0;                    ///< that the integration may take; 0: the default
};

/// A single state, as it would be asked of `balance simulate --at`.
struct StateCommand {
  std::string spec_file;  ///< its folder does not matter
  std::string at, rates, accelerations;
  std::string trajectory;  ///< whose start, end and point of moments are meant; empty: the first
  std::vector<std::string> independent;
  double time = 0;    ///< [s]
  std::string about;  ///< "x,y" or "x,y,z"; empty: the trajectory's
  bool compress = false;
  bool poses = false;
};

/// Of any answer about a study.
/// @param command_line what computes the same file again. Options that do not change its content are left out, and so is the spec's
/// folder: the same spec gives the same bytes wherever it and the result lie
Provenance make_provenance(const Study& study, std::string command_line);

/// @param trajectory one of the study's, perhaps changed. The controller, if there is one, is one of the study's
Provenance make_simulation_provenance(const Study& study, const Trajectory& trajectory, const SimulateCommand& call);

Provenance describe_state(const Study& study, const StateCommand& call);

}  // namespace balance
