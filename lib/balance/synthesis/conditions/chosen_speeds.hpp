#pragma once
/// Speeds in whose derivatives the conditions of velocity terms and inertia are stated (P0 definition 2.1).

#include "balance/mechanics/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// Points whose velocities the speeds contain follow the points of the same names when a mechanism's lengths change.
class ChosenSpeeds {
 public:
  ChosenSpeeds() = default;
  /// @param mechanism for which the speeds were read
  ChosenSpeeds(const Mechanism& mechanism, std::vector<model::GeneralisedSpeed> speeds);

  bool empty() const { return speeds_.empty(); }
  std::size_t size() const { return speeds_.size(); }
  /// The speeds of a mechanism that differs in its numbers.
  std::vector<model::GeneralisedSpeed> in(const Mechanism& mechanism) const;
  /// The speeds of several copies of a mechanism side by side (disjoint_union).
  ChosenSpeeds repeat(const Mechanism& mechanism, int copies) const;
  /// Coordinates whose joints must not be cut.
  std::vector<CoordinateId> coordinates() const;
  /// Whether the velocity of the centre of mass is among their terms. Conditions in such speeds are not linear in the
  /// parameters; derived ones are those of a centre of mass that stays that of the mechanism.
  bool depend_on_masses() const;
  /// Whether factors contain parameters, which do not follow a change of the mechanism's numbers.
  bool has_parameters() const;

 private:
  std::vector<model::GeneralisedSpeed> speeds_;
  std::vector<std::vector<int>> points_;  ///< per term: index of a named point of its body; −1: none
};

}  // namespace balance::conditions
