#pragma once
/// What to minimize, in a spec or on the command line.

#include "balance/interface/specification/study_builder.hpp"

namespace balance::specification {

/// One term or a list of terms. @param study whose actuators, joints and trajectories the terms may name
std::vector<ObjectiveTerm> read_objective_terms(const SpecCursor& at, SpecParameters& parameters, const Study& study);

/// Parts of a term.
std::string read_quantity(const SpecCursor& at, const Study& study);
std::string read_trajectory_name(const SpecCursor& at, const Study& study);
double read_weight(const SpecCursor& at, SpecParameters& parameters);
/// Number of standard deviations to add to a figure's mean. The spec must have tolerances.
double read_deviation_multiple(const SpecCursor& at, SpecParameters& parameters, const Study& study);
/// Fails if the figure has no deviations: of a quantity without derivatives, or along a trajectory that depends on the
/// mechanism.
void require_deviations(const SpecCursor& at, const ObjectiveTerm& term, const Study& study);
/// The default trajectory of a figure: the spec's first. Fails at the figure if there is none, or if
/// it depends on the mechanism.
std::string default_trajectory_name(const SpecCursor& at, const Study& study);

// Limits on figures of a design.

/// `peak(torque[A1]) <= 12`, or a list of limits.
std::vector<study::FigureLimit> read_figure_limits(const SpecCursor& at, StudyBuilder& draft);

}  // namespace balance::specification
