#pragma once
/// A state on the command line: where a mechanism is, how its independent coordinates move, and when.

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
  std::string trajectory;            ///< whose start and end; empty: the first of the spec
  double time = 0;                   ///< of loads that change [s]
  std::vector<std::string> independent;
};

/// --at, --rates, --accelerations, --time and --independent.
/// @param at_help what --at is said to be
void add_state_options(CLI::App& parser, StateOptions& options, const std::string& at_help);

/// The trajectory of that name; null if there is none.
const Trajectory* find_trajectory(const std::string& name, const Study& study);

/// The pose that --at means, found on the mechanism, with the rates asked for.
/// @throws UsageError, SpecError; MotionFailure if the mechanism cannot take the pose
SingleState read_state(const StateOptions& options, const Study& study);

/// Runs what may be asked something that the options, or else the spec, should not have asked.
/// @param by_options whether they say anything beyond the spec
template <class Question>
auto call_library(bool by_options, const Study& study, const Question& question) {
  try {
    return question();
  } catch (const UnsolvableMechanism& error) {
    throw MotionFailure(error.outcome);
  } catch (const std::invalid_argument& error) {
    if (by_options) throw UsageError(error.what());
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
}

}  // namespace balance::app
