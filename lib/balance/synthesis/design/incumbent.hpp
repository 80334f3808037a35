#pragma once
/// The best design that a search has found so far, and the ends of its independent starts.

#include "balance/foundation/base/types.hpp"

#include <cmath>
#include <limits>
#include <vector>

namespace balance::design {

/// Keeps the best admissible design that was evaluated, whatever the search does later: an exact one before any
/// compromise, then by value.
class Incumbent {
 public:
  /// @param u unit coordinates of an admissible design
  /// @param is_exact whether it meets the conditions to `condition_tolerance`
  /// @param value of the objective (without one 0), or for compromises what they are compared by; not finite: ignored
  void offer(const VectorX& u, bool is_exact, double value) {
    if (!std::isfinite(value) || (has_design() && is_exact_ && !is_exact)) return;
    if (has_design() && is_exact == is_exact_ && !(value < value_)) return;
    u_ = u;
    is_exact_ = is_exact;
    value_ = value;
  }

  bool has_design() const { return u_.size() > 0; }
  bool is_exact() const { return has_design() && is_exact_; }
  const VectorX& u() const { return u_; }
  double value() const { return value_; }

 private:
  VectorX u_;
  bool is_exact_ = false;
  double value_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace balance::design
