#pragma once
/// Force and moment of a load as a function of time or of a joint coordinate.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <algorithm>
#include <cmath>

namespace balance::model {

/// Evaluates a load's table: straight lines between its entries, or the C² cubic spline through them, which is closed for
/// a periodic table, else not-a-knot (natural for two or three entries). End values are held outside.
template <class T>
class LoadTable {
 public:
  /// @param load must outlive the table
  explicit LoadTable(const LoadOf<T>& load) : load_(&load) {
    if (load.is_spline && load.arguments.size() > 1) find_second_derivatives();
  }

  const LoadOf<T>& load() const { return *load_; }

  /// @param argument time [s] or coordinate [rad or m] @param force, moment in the load's frame [N, N m]
  void evaluate(T argument, Vector3Of<T>& force, Vector3Of<T>& moment) const {
    const std::vector<T>& x = load_->arguments;
    if (x.empty()) {
      force = load_->force[0], moment = load_->moment[0];
      return;
    }
    if (load_->is_periodic) {
      const T period = x.back() - x.front();
      argument -= std::floor(value_of((argument - x.front()) / period)) * period;
    }
    const auto next = std::upper_bound(x.begin(), x.end(), argument);
    if (next == x.begin() || next == x.end()) {
      const std::size_t k = next == x.begin() ? 0 : x.size() - 1;
      force = load_->force[k], moment = load_->moment[k];
      return;
    }
    const auto k = static_cast<std::size_t>(next - x.begin());
    const T step = x[k] - x[k - 1], right = (argument - x[k - 1]) / step, left = 1 - right;
    force = left * load_->force[k - 1] + right * load_->force[k];
    moment = left * load_->moment[k - 1] + right * load_->moment[k];
    if (force_second_.empty()) return;
    const T bend_left = (left * left - 1) * left * step * step / 6,
            bend_right = (right * right - 1) * right * step * step / 6;
    force += bend_left * force_second_[k - 1] + bend_right * force_second_[k];
    moment += bend_left * moment_second_[k - 1] + bend_right * moment_second_[k];
  }

 private:
  /// The second derivatives at the entries are linear in the entries: their matrix follows from unit entries.
  void find_second_derivatives() {
    using numerics::SplineEnd;
    std::vector<double> knots;
    for (const T& argument : load_->arguments) knots.push_back(value_of(argument));
    const auto n = static_cast<Eigen::Index>(knots.size());
    const SplineEnd end = load_->is_periodic ? SplineEnd::periodic : n < 4 ? SplineEnd::natural : SplineEnd::not_a_knot;
    Samples unit = Samples::Identity(n, n);
    if (load_->is_periodic) unit.row(n - 1) = unit.row(0);
    const Samples matrix = numerics::find_spline_second_derivatives(knots, unit, end);
    const auto apply = [&](const std::vector<Vector3Of<T>>& entries, std::vector<Vector3Of<T>>& second) {
      second.assign(entries.size(), Vector3Of<T>::Zero());
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
          second[static_cast<std::size_t>(i)] += T(matrix(i, j)) * entries[static_cast<std::size_t>(j)];
    };
    apply(load_->force, force_second_);
    apply(load_->moment, moment_second_);
  }

  const LoadOf<T>* load_;
  std::vector<Vector3Of<T>> force_second_, moment_second_;  ///< per entry; empty: straight lines
};

}  // namespace balance::model
