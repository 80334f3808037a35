#include "balance/foundation/numerics/bounded_least_squares.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <algorithm>
#include <vector>

namespace balance::design {

namespace {

enum class VariableState { free, lower, upper };

class ActiveSetMethod {
 public:
  ActiveSetMethod(const MatrixX& a, const VectorX& b, const VectorX& lower, const VectorX& upper, VectorX& x)
      : a_(a),
        b_(b),
        lower_(lower),
        upper_(upper),
        x_(x),
        place_(static_cast<std::size_t>(x.size()), VariableState::free) {
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (!(lower[i] < upper[i])) at(i) = VariableState::lower;
  }

  void run() {
    const auto limit = 10 * x_.size() + 50;
    Eigen::Index freed = -1;
    for (Eigen::Index iteration = 0; iteration < limit; ++iteration) {
      const VectorX aim = solve_free();
      if (freed >= 0 && (aim[freed] - x_[freed]) * (freed_from_ == VariableState::lower ? 1 : -1) <= 0) {
        // the gradient was round-off: back to the bound, and there it stays
        at(freed) = freed_from_;
        refused_[static_cast<std::size_t>(freed)] = true;
      } else if (step_to_bound(aim)) {
        freed = -1;
        continue;
      } else {
        refused_.assign(refused_.size(), false);
      }
      freed = release();
      if (freed < 0) return;
    }
  }

 private:
  VariableState& at(Eigen::Index i) { return place_[static_cast<std::size_t>(i)]; }

  VectorX solve_free() {
    std::vector<Eigen::Index> free;
    VectorX right = b_;
    for (Eigen::Index i = 0; i < x_.size(); ++i)
      if (at(i) == VariableState::free)
        free.push_back(i);
      else
        right -= a_.col(i) * x_[i];
    VectorX aim = x_;
    if (!free.empty()) aim(free) = a_(Eigen::all, free).householderQr().solve(right);
    return aim;
  }

  /// As far as the bounds allow. @return a bound stopped it
  bool step_to_bound(const VectorX& aim) {
    double part = 1;
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) != VariableState::free) continue;
      if (aim[i] < lower_[i]) part = std::min(part, (lower_[i] - x_[i]) / (aim[i] - x_[i]));
      if (aim[i] > upper_[i]) part = std::min(part, (upper_[i] - x_[i]) / (aim[i] - x_[i]));
    }
    const bool stopped = part < 1;
    bool any = false;
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) != VariableState::free) continue;
      const double next = stopped ? x_[i] + part * (aim[i] - x_[i]) : aim[i];
      const double slack = stopped ? 1e-15 * (upper_[i] - lower_[i]) : 0;
      x_[i] = next;
      if (aim[i] < lower_[i] && next <= lower_[i] + slack) any = true, at(i) = VariableState::lower, x_[i] = lower_[i];
      if (aim[i] > upper_[i] && next >= upper_[i] - slack) any = true, at(i) = VariableState::upper, x_[i] = upper_[i];
    }
    return stopped && any;
  }

  /// Frees the number that wants to leave its bound most.
  Eigen::Index release() {
    const VectorX rest = b_ - a_ * x_;
    const VectorX gradient = a_.transpose() * rest;
    Eigen::Index best = -1;
    double most = 1e-15 * rest.norm() * a_.norm();  // below it is round-off
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) == VariableState::free || refused_[static_cast<std::size_t>(i)] || !(lower_[i] < upper_[i])) continue;
      const double inwards = at(i) == VariableState::lower ? gradient[i] : -gradient[i];
      if (inwards > most) most = inwards, best = i;
    }
    if (best >= 0) {
      freed_from_ = at(best);
      at(best) = VariableState::free;
    }
    return best;
  }

  const MatrixX& a_;
  const VectorX& b_;
  const VectorX &lower_, &upper_;
  VectorX& x_;
  std::vector<VariableState> place_;
  std::vector<bool> refused_ = std::vector<bool>(place_.size(), false);
  VariableState freed_from_ = VariableState::free;
};

}  // namespace

void bounded_least_squares(const MatrixX& a, const VectorX& b, const VectorX& lower, const VectorX& upper, VectorX& x) {
  ActiveSetMethod(a, b, lower, upper, x).run();
}

}  // namespace balance::design
