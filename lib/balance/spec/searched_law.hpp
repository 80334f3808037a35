#pragma once
/// What only laws that are searched for say: limits, whose peak is to be least, speeds at both ends.

#include "balance/spec/draft.hpp"

#include <optional>

namespace balance::read {

/// Where they stand in a trajectory.
struct SearchedLawText {
  std::optional<Cursor> limits, of, speeds;
};

/// Into the trajectory, whose law and drive are known. Fails if the law needs what is missing or is none that may say it.
/// @param at the trajectory
void read_searched_law(const Cursor& at, const SearchedLawText& text, Draft& draft,
                       TrajectoryOf<Expression>& trajectory);

}  // namespace balance::read
