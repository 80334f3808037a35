#include "balance/foundation/numerics/bounded_least_squares.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <algorithm>
#include <vector>

namespace balance::numerics {

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
        state_(static_cast<std::size_t>(x.size()), VariableState::free) {
    for (Eigen::Index i = 0; i < x.size(); ++i)
      if (!(lower[i] < upper[i])) at(i) = VariableState::lower;
  }

  void run() {
    const auto limit = 10 * x_.size() + 50;
    Eigen::Index freed = -1;
    for (Eigen::Index iteration = 0; iteration < limit; ++iteration) {
      const VectorX minimiser = solve_free();
      if (freed >= 0 && (minimiser[freed] - x_[freed]) * (freed_from_ == VariableState::lower ? 1 : -1) <= 0) {
        // the gradient was round-off: return to the bound and do not release it again for now
        at(freed) = freed_from_;
        refused_[static_cast<std::size_t>(freed)] = true;
      } else if (step_to_bound(minimiser)) {
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
  VariableState& at(Eigen::Index i) { return state_[static_cast<std::size_t>(i)]; }

  VectorX solve_free() {
    std::vector<Eigen::Index> free;
    VectorX rhs = b_;
    for (Eigen::Index i = 0; i < x_.size(); ++i)
      if (at(i) == VariableState::free)
        free.push_back(i);
      else
        rhs -= a_.col(i) * x_[i];
    VectorX minimiser = x_;
    if (!free.empty()) minimiser(free) = a_(Eigen::all, free).householderQr().solve(rhs);
    return minimiser;
  }

  /// Moves towards `minimiser` as far as the bounds allow. @return true if a bound stopped it
  bool step_to_bound(const VectorX& minimiser) {
    double step_fraction = 1;
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) != VariableState::free) continue;
      if (minimiser[i] < lower_[i])
        step_fraction = std::min(step_fraction, (lower_[i] - x_[i]) / (minimiser[i] - x_[i]));
      if (minimiser[i] > upper_[i])
        step_fraction = std::min(step_fraction, (upper_[i] - x_[i]) / (minimiser[i] - x_[i]));
    }
    const bool stopped = step_fraction < 1;
    bool bound_reached = false;
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) != VariableState::free) continue;
      const double next = stopped ? x_[i] + step_fraction * (minimiser[i] - x_[i]) : minimiser[i];
      const double slack = stopped ? 1e-15 * (upper_[i] - lower_[i]) : 0;
      x_[i] = next;
      if (minimiser[i] < lower_[i] && next <= lower_[i] + slack)
        bound_reached = true, at(i) = VariableState::lower, x_[i] = lower_[i];
      if (minimiser[i] > upper_[i] && next >= upper_[i] - slack)
        bound_reached = true, at(i) = VariableState::upper, x_[i] = upper_[i];
    }
    return stopped && bound_reached;
  }

  /// Releases the variable with the largest gradient away from its bound. @return its index, −1 if there is none
  Eigen::Index release() {
    const VectorX residual = b_ - a_ * x_;
    const VectorX gradient = a_.transpose() * residual;
    Eigen::Index best = -1;
    double max_gradient = 1e-15 * residual.norm() * a_.norm();  // below it is round-off
    for (Eigen::Index i = 0; i < x_.size(); ++i) {
      if (at(i) == VariableState::free || refused_[static_cast<std::size_t>(i)] || !(lower_[i] < upper_[i])) continue;
      const double inwards = at(i) == VariableState::lower ? gradient[i] : -gradient[i];
      if (inwards > max_gradient) max_gradient = inwards, best = i;
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
  std::vector<VariableState> state_;
  std::vector<bool> refused_ = std::vector<bool>(state_.size(), false);
  VariableState freed_from_ = VariableState::free;
};

}  // namespace

void bounded_least_squares(const MatrixX& a, const VectorX& b, const VectorX& lower, const VectorX& upper, VectorX& x) {
  ActiveSetMethod(a, b, lower, upper, x).run();
}

}  // namespace balance::numerics
