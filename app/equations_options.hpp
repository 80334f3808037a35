#pragma once
/// What the user asks of `balance equations`, and what it means for the study.

#include "pose_options.hpp"

#include "balance/analysis/equations.hpp"

#include <string>
#include <vector>

namespace balance::app {

/// `at` may also be a trajectory's name, or empty: formulas.
struct EquationsOptions : StateOptions {
  SpecOptions spec;
  std::string speeds, constraints;  ///< `v: tool.u, w: {A: 0.5}`; empty: none
  std::vector<std::string> only;
  std::string output;
  bool latex = false, force = false, compress = false;

  // of formulas
  std::string code;  ///< `c` or `python`; empty: none
  bool expand = false, numbers = false, all = false;
};

void add_equations_options(CLI::App& parser, EquationsOptions& options);

/// The sections that --only names; without it those that a page of text has room for, or all.
/// @throws UsageError
std::set<EquationSection> choose_sections(const EquationsOptions& options);

/// The trajectory that --at names as a whole; null if it names a pose.
const Trajectory* trajectory_at(const EquationsOptions& options, const Study& study);

/// The pose that --at means, found on the mechanism, with the rates asked for.
/// @throws UsageError, SpecError; MotionFailure if the mechanism cannot take the pose
EquationsQuery make_query(const EquationsOptions& options, const Study& study);

/// Refuses at once what would fail after the computation. @throws UsageError, SystemError
void check_outputs(const EquationsOptions& options, const Study& study);

}  // namespace balance::app
