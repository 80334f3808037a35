#pragma once
/// How far a run's peak or range is off where several moments may be the largest, or the least: the greatest of linear functions of the
/// same random numbers (C. E. Clark, The greatest of a finite set of random variables, Operations Research 9, 1961, p. 145), on draws of
/// them. Private to analysis.

#include "balance/base/types.hpp"
#include "balance/study/tolerances.hpp"

#include <vector>

namespace balance {

/// What a run has at a moment: value + changeᵀ z, the numbers z being independent, of mean 0 and variance 1.
struct LinearMoment {
  double time = 0;
  VectorX value;   ///< of a scalar or a vector
  MatrixX change;  ///< numbers × components
};

class ExtremeFigure {
 public:
  enum class Kind {
    peak,   ///< largest magnitude
    range,  ///< largest less least value of a scalar, magnitude of a vector
  };

  /// Keeps the moments that may be the largest or the least within a few deviations; those that go along with a larger one are left out.
  ExtremeFigure(const std::vector<LinearMoment>& moments, Kind kind);

  /// Whether the figure has no slope within a few deviations.
  bool has_rivals() const;
  /// What follows counts everything met. @param z as in LinearMoment
  void meet(const VectorX& z);
  double deviation() const;
  /// Averages of the derivatives.
  VectorX by_number() const;
  /// Of the moments that were the largest or the least in a fiftieth of the draws or more, in the order of time, neighbours taken as one.
  std::vector<double> times() const;

 private:
  struct Rival {
    LinearMoment moment;
    long wins = 0;
    VectorX slope;  ///< sum of the height's derivatives by the components, where it won
  };
  struct Height {
    double value = 0;
    VectorX slope;  ///< by the numbers
  };

  double height(const VectorX& value) const;
  Height height_of(const LinearMoment& moment, double sign) const;
  std::vector<Rival> find_rivals(const std::vector<LinearMoment>& moments, double sign);
  double settle(std::vector<Rival>& rivals, double sign, const VectorX& z) const;

  Kind kind_;
  bool near_zero_ = false;  ///< a magnitude whose least value may be zero
  std::vector<Rival> highest_, lowest_;
  double duration_ = 0;
  long met_ = 0;
  double sum_ = 0, squares_ = 0, first_ = 0;
};

/// Has all figures with rivals meet the same draws, which are the same every time: deviations are good to a hundredth.
void meet_draws(std::vector<ExtremeFigure*>& figures, const Tolerances& numbers);

}  // namespace balance
