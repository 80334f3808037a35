#pragma once
/// Limits of a motion, and what only laws that are searched for say: whose peak is to be least, speeds at both ends.

#include "balance/spec/draft.hpp"

#include <optional>

namespace balance::specification {

/// Where they stand in a trajectory.
struct OptimisedLawKeys {
  std::optional<SpecCursor> limits, of, speeds;
};

/// Into the trajectory, whose law and drive are known. Fails if the law needs what is missing or is none that may say it.
/// @param at the trajectory @param corridor its path is one: then any law may say whose peak is to be least
void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& text, bool corridor, StudyBuilder& draft,
                        TrajectoryOf<Expression>& trajectory);

}  // namespace balance::specification
