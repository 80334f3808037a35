#pragma once
/// What a design may spend, and what it has done with it. Private to design.

#include "balance/design/computing_time.hpp"
#include "balance/design/problem.hpp"

#include <algorithm>

namespace balance::designing {

class Budget {
 public:
  explicit Budget(double seconds) : end_(computing_time() + seconds) {}

  /// [s], positive.
  double left() const { return std::max(1e-3, end_ - computing_time()); }
  /// Nothing is left; remembered.
  bool spent() {
    if (computing_time() >= end_) stopped = true;
    return stopped;
  }

  bool stopped = false;  ///< a search ended for lack of time or evaluations
  int starts = 0;        ///< from which conditions were solved
  int solutions = 0;     ///< different ones found
  int descents = 0;      ///< local searches
  int evaluations = 0;   ///< of the objective in searches
  int alike = 0;         ///< of the local searches over lengths: ended as well as the best one
  int geometries = 0;    ///< lengths and ratios at which the other numbers were solved for

 private:
  double end_;
};

}  // namespace balance::designing
