#pragma once
/// Builds objectives from the terms of `minimize`.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/design/design_problem.hpp"
#include "balance/synthesis/design/motion_cache.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::design {

// Limits from `subject_to`.

/// @param start, loose as for build_objective
/// @throws std::invalid_argument as build_objective
std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<study::FigureLimit>& limits,
                                             const VectorX& start, const dynamics::FreeSprings& loose,
                                             MotionCache& cache);

/// The limits that are upper bounds of convex or lower bounds of concave functions of the parameters for any motion.
std::vector<study::FigureLimit> select_convex_limits(const DesignSpace& space,
                                                     const std::vector<study::FigureLimit>& limits);

/// Whether convex terms with coarse sampling, and limits, have all samples of their trajectories.
bool are_samples_complete(const Study& study, const std::vector<ObjectiveTerm>& terms,
                          const std::vector<study::FigureLimit>& limits);

/// Such limits for the lengths and motion of x. @return std::nullopt if there is no motion
std::optional<std::vector<ConvexLimit>> compute_convex_limits(const DesignSpace& space,
                                                              const std::vector<study::FigureLimit>& limits,
                                                              const dynamics::FreeSprings& loose, const VectorX& x,
                                                              MotionCache& cache);

/// The weighted sum of the terms. For motions that do not change with the free numbers no simulation is required: the
/// sum is a function of the parameters, convex if every term is.
/// It has no value if the mechanism cannot follow the trajectory of a term; DesignFunction::failure_reason says why.
/// @param start values of the free numbers
/// @param loose as used for deriving the conditions
/// @throws std::invalid_argument if the trajectory or quantity of a term does not exist
Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const dynamics::FreeSprings& loose);
/// The same for one of several load cases.
Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const dynamics::FreeSprings& loose, MotionCache& cache);

/// Whether every term is a convex function of the parameters alone, for any motion.
/// @throws std::invalid_argument as build_objective
bool are_convex_in_parameters(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms);

/// Whether every term is a mass, or any statistic of a quantity that is affine in the parameters, for any motion.
bool are_statistics_of_affine_quantities(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms);

/// Whether every term is a concave function: a mass, or the minimum of a signed quantity.
bool are_concave_in_parameters(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms);

/// Whether a quantity of runs has a sign, not a magnitude alone.
bool is_scalar_quantity(const Mechanism& mechanism, const std::string& quantity);

/// The individual terms for the lengths and motion of x. @return std::nullopt if there is no motion
std::optional<std::vector<AffineFigure>> compute_convex_terms(const DesignSpace& space,
                                                              const std::vector<ObjectiveTerm>& terms,
                                                              const dynamics::FreeSprings& loose,
                                                              FigureSampling sampling, const VectorX& x,
                                                              MotionCache& cache);

/// Mass of all moving parts [kg], and the sum of their moments of inertia about the frame origins (spatial: half the
/// trace) [kg m^2], as coefficients of the parameters.
VectorX mass_coefficients(const std::vector<dynamics::Parameter>& parameters);
VectorX inertia_coefficients(const std::vector<dynamics::Parameter>& parameters);

/// A mass or inertia as coefficients of the parameters: of all moving parts, or of those added for balancing.
VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const dynamics::FreeSprings& loose);

/// 1 for parameters of elements added for balancing (counterweights and discs), else 0.
VectorX added_parameter_mask(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters);

/// "rms(torque) along cycloid", "added mass"
std::string objective_term_name(const ObjectiveTerm& term);
std::string objective_term_name(Statistic figure);

// A weighted sum of figures as a sum of maxima of smooth functions of the free numbers, with derivatives.

/// Each figure as a maximum: a peak over the extremes of short segments of the run, a range as two such maxima, other
/// figures as single functions.
/// @return std::nullopt if a trajectory cannot be followed
/// @throws SpecError, std::invalid_argument if there is no mechanism or motion
std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const dynamics::FreeSprings& loose, const VectorX& x);

}  // namespace balance::design
