#pragma once
/// The best of the exact solutions. Private to design.

#include "balance/design/convex.hpp"

#include <chrono>

namespace balance::designing {

/// Time left to searches whose evaluations are simulations.
class Deadline {
 public:
  explicit Deadline(double seconds) : end_(Clock::now() + std::chrono::duration<double>(seconds)) {}
  /// [s], positive.
  double left() const { return std::max(1e-3, std::chrono::duration<double>(end_ - Clock::now()).count()); }

 private:
  using Clock = std::chrono::steady_clock;
  std::chrono::time_point<Clock, std::chrono::duration<double>> end_;
};

/// Local searches from exact solutions, with the conditions as equalities.
/// @param back brings a point near the conditions onto them
/// @param solutions at least one
Optimum best_exact(const Context& context, const FigureOfMerit& merit, const Equations& equations,
                   const std::function<VectorX(const VectorX&)>& back, const std::vector<VectorX>& solutions,
                   const Deadline& deadline);

/// Global, then local search of the objective over all physical designs, met conditions or not.
Optimum best_compromise(const Context& context, const FigureOfMerit& merit, const VectorX& start,
                        const Deadline& deadline);

/// Global, then local search of the sum of squared residuals.
/// @param start the best known
/// @return physical, if the start values or the best known point are
VectorX least_residual(const Context& context, const Equations& equations, const Descent& start, int evaluations);

}  // namespace balance::designing
