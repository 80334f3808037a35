#pragma once
/// What acts on a mechanism and is no parameter of its design: loads and friction. In conditions they stand as columns whose
/// values are known.
///
/// A load has one term per component of its force and moment, worth what it is at the table's first time (or always), and,
/// with a table, one per component that changes, worth the largest change. Friction has a viscous and a dry term, or a dry term for each
/// direction.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/mechanism.hpp"

namespace balance {

/// Symbols of dry friction where directions differ.
inline constexpr const char* coulomb_forward = "coulomb.forward";
inline constexpr const char* coulomb_backward = "coulomb.backward";

bool is_known_term(const Parameter& parameter);
/// The number that a term of friction is worth.
double& friction_coefficient(Friction& friction, const Parameter& term);
/// What a coordinate resists with at this rate per unit of a term of its friction.
double friction_resistance(const Parameter& term, double rate);
/// A known term that stands for the changes of a load over time.
bool is_load_change(const Parameter& parameter);

/// Loads, then friction, in the mechanism's order: as many for every mechanism of the same structure.
std::vector<Parameter> list_known_terms(const Mechanism& mechanism);
/// Their values [SI], in the same order.
VectorX known_term_values(const Mechanism& mechanism);

/// All columns of conditions: parameters, then known terms.
std::vector<Parameter> list_terms(const Mechanism& mechanism, const FreeSprings& loose = {});
VectorX term_values(const Mechanism& mechanism, const FreeSprings& loose = {});

/// How all loads' components change together: column c says which multiples of the components (force, then moment, load by load)
/// change with the change of component c. Loads that change in step share one column; columns of components that do not
/// change, or change as others do, are zero.
/// @param length by which moments are compared with forces [m]
MatrixX load_changes(const Mechanism& mechanism, double length);

/// Whether a term is among what `names` leave out: sections (`friction`, `loads`, `springs`, `payloads`, `counterweights`,
/// `discs`), what is in them, or both joined by a dot; joint coordinates stand for their friction.
bool is_excluded(const Mechanism& mechanism, const Parameter& term, const std::vector<std::string>& names);
/// All such names of a mechanism.
std::vector<std::string> list_excludable_names(const Mechanism& mechanism);

}  // namespace balance
