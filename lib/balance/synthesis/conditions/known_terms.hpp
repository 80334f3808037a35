#pragma once
/// Loads, friction, dampers and springs with a table act on a mechanism, but are not parameters of its design: columns
/// of conditions with known values.
///
/// A load has one term per component of its force and moment, whose value is the one at the table's first time (or the
/// constant one). With a table, it has another term per component for the changes, whose value is the largest change.
/// Friction has a viscous and a dry term, or one dry term per direction. A damper has its damping, a spring with a table
/// its largest force.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/load_table.hpp"
#include "balance/mechanics/model/mechanism.hpp"

namespace balance::conditions {

/// Symbols of dry friction that depends on the direction.
inline constexpr const char* coulomb_forward = "coulomb.forward";
inline constexpr const char* coulomb_backward = "coulomb.backward";

bool is_known_term(const dynamics::Parameter& parameter);
/// The coefficient that a term of friction stands for.
double& friction_coefficient(Friction& friction, const dynamics::Parameter& term);
/// Resistance of a coordinate at this rate per unit of a term of its friction.
double friction_resistance(const dynamics::Parameter& term, double rate);
/// A component of a load over a coordinate, relative to its largest entry, which is the value of the term.
double relative_load(const model::LoadTable<double>& table, const dynamics::Parameter& term, double coordinate,
                     bool planar);
/// Whether a known term stands for the changes of a load over time.
bool is_load_change(const dynamics::Parameter& parameter);

/// Loads, then friction, then dampers and springs with a table, in the mechanism's order; their number is the same for all mechanisms of the same structure.
std::vector<dynamics::Parameter> list_known_terms(const Mechanism& mechanism);
/// Their values [SI], in the same order.
VectorX known_term_values(const Mechanism& mechanism);

/// All columns of conditions: parameters, then known terms.
std::vector<dynamics::Parameter> list_terms(const Mechanism& mechanism, const dynamics::FreeSprings& loose = {});
VectorX term_values(const Mechanism& mechanism, const dynamics::FreeSprings& loose = {});

/// How the components of all loads change together: column c contains the multiples of all components (force, then
/// moment, load by load) that change with component c. Loads that change in proportion share one column. Columns of
/// components that do not change, or that change in proportion to others, are zero.
/// @param length relates moments to forces [m]
MatrixX load_changes(const Mechanism& mechanism, double length);

/// Whether `names` exclude a term: sections (`friction`, `loads`, `springs`, `dampers`, `payloads`, `counterweights`,
/// `discs`), the elements in them, or both joined by a dot; a joint coordinate stands for its friction.
bool is_excluded(const Mechanism& mechanism, const dynamics::Parameter& term, const std::vector<std::string>& names);
/// All names of a mechanism that can be excluded.
std::vector<std::string> list_excludable_names(const Mechanism& mechanism);

}  // namespace balance::conditions
