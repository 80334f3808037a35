#pragma once
/// A state given on the command line: configuration, rates and accelerations of the independent coordinates, and time.

#include "cli/command.hpp"
#include "cli/failures.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/kinematics/assembly_diagnostics.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::app {

struct StateOptions {
  std::string at;                    ///< a pose, `start` or `end`
  std::string rates, accelerations;  ///< `A1=1,A2=0`; empty: none
  std::string trajectory;            ///< the trajectory that `start` and `end` refer to; empty: the first of the spec
  double time = 0;                   ///< at which time-dependent loads are evaluated [s]
  std::vector<std::string> independent;
};

/// Adds --at, --rates, --accelerations, --time and --independent.
/// @param at_help help text of --at
void add_state_options(CLI::App& parser, StateOptions& options, const std::string& at_help);

/// Assembles the mechanism in the pose given by --at and sets the requested rates and accelerations.
/// @throws UsageError, SpecError; MotionFailure if the mechanism cannot reach the pose
dynamics::SingleState read_state(const StateOptions& options, const Study& study);

/// Calls `question` and translates the library's exceptions: an invalid argument becomes a UsageError or a SpecError.
/// @param by_options whether the options ask for anything beyond the spec
template <class Question>
auto call_library(bool by_options, const Study& study, const Question& question) {
  try {
    return question();
  } catch (const kinematics::UnsolvableMechanism& error) {
    throw MotionFailure(error.outcome);
  } catch (const std::invalid_argument& error) {
    if (by_options) throw UsageError(error.what());
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
}

}  // namespace balance::app
