#pragma once
/// What to minimize, in a spec or on the command line.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// One term or a list of terms. @param study whose actuators, joints and trajectories the terms may name
std::vector<ObjectiveTerm> read_terms(const Cursor& at, Parameters& parameters, const Study& study);

/// Parts of a term.
std::string read_quantity(const Cursor& at, const Study& study);
std::string read_along(const Cursor& at, const Study& study);
double read_weight(const Cursor& at, Parameters& parameters);
/// How many deviations are added to a figure's mean. The spec must have tolerances.
double read_deviations(const Cursor& at, Parameters& parameters, const Study& study);
/// Fails if the term's trajectory is found anew for every mechanism: runs along it have no deviations.
void require_stated(const Cursor& at, const ObjectiveTerm& term, const Study& study);
/// The trajectory of a figure without one: the spec's first. Fails at the figure if there is none.
std::string first_along(const Cursor& at, const Study& study);

}  // namespace balance::read
