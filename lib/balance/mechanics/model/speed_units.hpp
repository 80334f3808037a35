#pragma once
/// Whether generalised speeds are lengths or angles per time.

#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>

namespace balance::model {

inline bool is_length_term(const Mechanism& mechanism, const GeneralisedSpeedTerm& term) {
  using enum GeneralisedSpeedTerm::Kind;
  return term.kind == coordinate ? is_length_coordinate(mechanism, CoordinateId(term.index))
                                 : term.kind != angular_velocity && term.kind != angular_velocity_body;
}

/// Factors of angles in a sum with lengths are lengths.
inline bool is_length_speed(const Mechanism& mechanism, const GeneralisedSpeed& speed) {
  return std::any_of(speed.terms.begin(), speed.terms.end(),
                     [&](const GeneralisedSpeedTerm& term) { return is_length_term(mechanism, term); });
}

}  // namespace balance::model
