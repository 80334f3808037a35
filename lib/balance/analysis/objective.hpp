#pragma once
/// What `minimize` asks for, as one function that a search can call.

#include "balance/design/problem.hpp"
#include "balance/study/design_space.hpp"

namespace balance {

/// The weighted sum of the terms. Along motions that do not change with the free numbers it needs no simulation: a function of the
/// parameters, convex if every term is.
/// Where the mechanism cannot follow a term's trajectory there is no value, and `trouble` says why.
/// @param start values of the free numbers
/// @param loose as the conditions are derived with
/// @throws std::invalid_argument if a term's trajectory or quantity does not exist
Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const LooseSprings& loose);

/// As often looked at as a search over lengths needs; as the trajectory says.
enum class FigureSamples { few, all };

/// The same terms one by one at the lengths and along the motion of x.
/// @return null if a term is no convex function of the parameters alone
std::function<std::optional<std::vector<LinearFigure>>(const VectorX& x)> build_figures(
    const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const LooseSprings& loose,
    FigureSamples samples = FigureSamples::few);

/// Mass of everything that moves [kg], and the sum of its moments of inertia about the frames' origins (space: half the
/// trace) [kg m^2], as coefficients of the parameters.
VectorX mass_coefficients(const std::vector<Parameter>& parameters);
VectorX inertia_coefficients(const std::vector<Parameter>& parameters);

/// A size as coefficients of the parameters: of everything that moves, or of what was added to balance it.
VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const LooseSprings& loose);

/// 1 for parameters of what is added to balance a mechanism, counterweights and discs, else 0.
VectorX is_added(const Mechanism& mechanism, const std::vector<Parameter>& parameters);

/// "rms(torque) along cycloid", "added mass"
std::string name_of(const ObjectiveTerm& term);
std::string name_of(Figure figure);

}  // namespace balance
