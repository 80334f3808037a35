#pragma once
/// How far a run's peak or range is off where several moments may be the largest, or the least: the greatest of linear functions of the
/// same random numbers (C. E. Clark, The greatest of a finite set of random variables, Operations Research 9, 1961, p. 145), on draws of
/// them.

#include "balance/foundation/base/types.hpp"
#include "balance/motion/study/study.hpp"

#include <vector>

namespace balance {

/// What a run has at a moment: value + changeᵀ z, the numbers z being independent, of mean 0 and variance 1.
struct LinearizedSample {
  double time = 0;
  VectorX value;        ///< of a scalar or a vector
  MatrixX sensitivity;  ///< numbers × components
};

class ExtremeFigure {
 public:
  enum class Kind {
    peak,   ///< largest magnitude
    range,  ///< largest less least value of a scalar, magnitude of a vector
  };

  /// Keeps the moments that may be the largest or the least within a few deviations; those that go along with a larger one are left out.
  ExtremeFigure(const std::vector<LinearizedSample>& moments, Kind kind);

  /// Whether the figure has no slope within a few deviations.
  bool has_several_candidates() const;
  /// What follows counts everything met. @param z as in LinearizedSample
  void add_draw(const VectorX& z);
  double deviation() const;
  /// Averages of the derivatives.
  VectorX contributions() const;
  /// Of the moments that were the largest or the least in a fiftieth of the draws or more, in the order of time, neighbours taken as one.
  std::vector<double> extremum_times() const;

 private:
  struct Candidate {
    LinearizedSample sample;
    long extremum_count = 0;
    VectorX gradient_sum;  ///< sum of the height's derivatives by the components, where it won
  };
  struct ValueWithGradient {
    double value = 0;
    VectorX gradient;  ///< by the numbers
  };

  double magnitude(const VectorX& value) const;
  ValueWithGradient magnitude_with_gradient(const LinearizedSample& moment, double sign) const;
  std::vector<Candidate> find_candidates(const std::vector<LinearizedSample>& moments, double sign);
  double update_extremum(std::vector<Candidate>& rivals, double sign, const VectorX& z) const;

  Kind kind_;
  bool near_zero_ = false;  ///< a magnitude whose least value may be zero
  std::vector<Candidate> maximum_candidates_, minimum_candidates_;
  double duration_ = 0;
  long draws_ = 0;
  double sum_ = 0, sum_of_squares_ = 0, reference_value_ = 0;
};

/// Has all figures with rivals meet the same draws, which are the same every time: deviations are good to a hundredth.
void sample_extreme_figures(std::vector<ExtremeFigure*>& figures, const Tolerances& numbers);

}  // namespace balance
