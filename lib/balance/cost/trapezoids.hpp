#pragma once
/// Time averages by the trapezoidal rule, of what comes place by place. Private to cost.

#include "balance/base/types.hpp"

#include <utility>

namespace balance {

/// Hands every place's rows on with their weight, the time that they stand for [s], which is known one place later.
template <class Add>
class TrapezoidalAverage {
 public:
  /// @param add called with rows and weight, in order
  explicit TrapezoidalAverage(Add add) : add_(std::move(add)) {}

  /// @param rows taken over, and given other memory in exchange
  void add_sample(double time, MatrixX& rows) {
    if (any_) {
      add_(rows_, (step_ + time - time_) / 2);
      step_ = time - time_;
    }
    any_ = true;
    time_ = time;
    rows_.swap(rows);
  }

  /// The last place's.
  void finish() { add_(rows_, step_ / 2); }

 private:
  Add add_;
  bool any_ = false;
  double time_ = 0, step_ = 0;
  MatrixX rows_;
};

}  // namespace balance
