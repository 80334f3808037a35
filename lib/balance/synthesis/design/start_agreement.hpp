#pragma once
/// How far the independent starts of a search agree.

#include <vector>

namespace balance::design {

/// Difference, relative to the best value, up to which two starts ended at the same value.
inline constexpr double start_agreement_tolerance = 1e-6;
/// Number of starts that have to end at the best value before a search stops of itself.
inline constexpr int min_agreeing_starts = 3;

struct StartAgreement {
  int starts = 0;            ///< independent starts that ended
  int agreeing = 0;          ///< of them at the best value
  int failed = 0;            ///< of them without a design
  double nearest_other = 0;  ///< least and largest distance of the other ends from the best value, relative to it
  double farthest_other = 0;

  bool is_reached() const { return agreeing >= min_agreeing_starts; }
};

/// @param ends values of the objective at which starts ended; not finite: without a design
/// @param best value of the design
StartAgreement compare_starts(const std::vector<double>& ends, double best);

}  // namespace balance::design
