#pragma once
/// What to minimize, in a spec or on the command line.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// One term or a list of terms. @param study whose actuators, joints and trajectories the terms may name
std::vector<ObjectiveTerm> read_terms(const Cursor& at, Parameters& parameters, const Study& study);

}  // namespace balance::read
