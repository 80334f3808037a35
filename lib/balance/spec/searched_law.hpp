#pragma once
/// Limits of a motion, and what only laws that are searched for say: whose peak is to be least, speeds at both ends.

#include "balance/spec/draft.hpp"

#include <optional>

namespace balance::read {

/// Where they stand in a trajectory.
struct SearchedLawText {
  std::optional<Cursor> limits, of, speeds;
};

/// Into the trajectory, whose law and drive are known. Fails if the law needs what is missing or is none that may say it.
/// @param at the trajectory @param corridor its path is one: then any law may say whose peak is to be least
void read_searched_law(const Cursor& at, const SearchedLawText& text, bool corridor, Draft& draft,
                       TrajectoryOf<Expression>& trajectory);

}  // namespace balance::read
