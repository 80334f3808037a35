#pragma once
/// The mechanism of a spec for all lengths of a box: every number as an interval with its derivatives by the lengths.

#include "balance/foundation/base/interval_jet.hpp"
#include "balance/motion/study/design_space.hpp"

#include <set>
#include <vector>

namespace balance::certificate {

/// Which free numbers the numbers of a spec depend on.
class NumberDependence {
 public:
  explicit NumberDependence(const DesignSpace& space);

  /// Indices of free numbers.
  const std::set<int>& of(const Expression& expression) const;
  /// The free number that the expression is itself; −1: none.
  int number_of(const Expression& expression) const;

 private:
  const study::Recording& recording_;
  std::vector<std::set<int>> numbers_;  ///< per node of the graph
  std::vector<int> number_of_input_;    ///< −1: it is not free
  std::set<int> none_;
};

/// @param numbers per free number of the study
/// @throws EnclosureError if an expression has no enclosure: a quotient by zero, or a function other than roots, sines,
/// cosines and powers with constant exponents
MechanismOf<IntervalJet> enclose_mechanism(const DesignSpace& space, const std::vector<IntervalJet>& numbers);

}  // namespace balance::certificate
