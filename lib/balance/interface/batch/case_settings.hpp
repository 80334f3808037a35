#pragma once
/// Reads what a case computes: its kind, its state, its points and the parameters that it solves for.

#include "balance/interface/batch/suite.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <functional>
#include <string>

namespace balance::batch {

/// Records where a part of a case is given: "points.D".
using RecordLocation = std::function<void(const std::string& key, const specification::SpecCursor& at)>;

/// `motion`, `design`, `conditions` or `equations`.
CaseKind read_case_kind(const specification::SpecCursor& at);

/// A mapping from joints to values, a pose as in trajectories, `start` or `end`. @return the text of --at
std::string read_state_pose(const specification::SpecCursor& at);

/// A mapping from joints to values. @return the text of --rates
std::string read_state_rates(const specification::SpecCursor& at);

/// `{D: rod.D, E: {rod: [0.1, 0]}}`. A point replaces one of the same name.
void read_case_points(const specification::SpecCursor& at, SuiteCase& suite_case, const RecordLocation& record);

/// `{N: {figure: "value(torque[Z], 0)", equals: 0, within: [100, 300]}}`.
void read_solved_parameters(const specification::SpecCursor& at, SuiteCase& suite_case, const RecordLocation& record);

/// Fails if keys of the case contradict its kind.
void check_case(const specification::SpecCursor& at, const SuiteCase& suite_case);

/// Fails if a case has a key that its kind does not use. Keys of `defaults` are for the cases that use them.
void check_case_keys(const specification::SpecCursor& at, CaseKind kind);

}  // namespace balance::batch
