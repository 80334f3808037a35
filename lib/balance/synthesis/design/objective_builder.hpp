#pragma once
/// What `minimize` asks for, as one function that a search can call.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"

#include <optional>
#include <vector>

namespace balance {

// What `subject_to` asks for, as functions that a search can call.

/// @param start, loose as for build_objective
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                             const VectorX& start, const FreeSprings& loose);

/// Those among them that are convex functions of the parameters along any motion. @param known how many they are
std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> build_convex_limits(
    const DesignSpace& space, const std::vector<FigureLimit>& limits, const FreeSprings& loose, int& known);

/// The weighted sum of the terms. Along motions that do not change with the free numbers it needs no simulation: a function of the
/// parameters, convex if every term is.
/// Where the mechanism cannot follow a term's trajectory there is no value, and `trouble` says why.
/// @param start values of the free numbers
/// @param loose as the conditions are derived with
/// @throws std::invalid_argument if a term's trajectory or quantity does not exist
Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const FreeSprings& loose);

/// As often looked at as a search over lengths needs; as the trajectory says.
enum class FigureSampling { coarse, full };

/// The same terms one by one at the lengths and along the motion of x.
/// @return null if a term is no convex function of the parameters alone
std::function<std::optional<std::vector<AffineFigure>>(const VectorX& x)> build_convex_terms(
    const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const FreeSprings& loose,
    FigureSampling samples = FigureSampling::coarse);

/// Mass of everything that moves [kg], and the sum of its moments of inertia about the frames' origins (space: half the
/// trace) [kg m^2], as coefficients of the parameters.
VectorX mass_coefficients(const std::vector<Parameter>& parameters);
VectorX inertia_coefficients(const std::vector<Parameter>& parameters);

/// A size as coefficients of the parameters: of everything that moves, or of what was added to balance it.
VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const FreeSprings& loose);

/// 1 for parameters of what is added to balance a mechanism, counterweights and discs, else 0.
VectorX added_parameter_mask(const Mechanism& mechanism, const std::vector<Parameter>& parameters);

/// "rms(torque) along cycloid", "added mass"
std::string objective_term_name(const ObjectiveTerm& term);
std::string objective_term_name(Statistic figure);

// A weighted sum of figures as a sum of maxima of smooth functions of the free numbers, with slopes.

/// Every figure as what it is a maximum of: a peak of the extremes of short stretches of the run, a range of two such maxima, others of
/// themselves alone.
/// @return nothing where a trajectory cannot be followed
/// @throws SpecError, std::invalid_argument where the numbers make no mechanism or motion
std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const FreeSprings& loose, const VectorX& x);

}  // namespace balance
