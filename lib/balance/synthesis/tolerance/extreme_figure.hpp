#pragma once
/// The deviation of a run's peak or range if several instants may have the maximum or minimum: that of the maximum of
/// linear functions of the same random numbers (C. E. Clark, The greatest of a finite set of random variables,
/// Operations Research 9, 1961, p. 145), evaluated on random draws.

#include "balance/foundation/base/types.hpp"
#include "balance/motion/study/study.hpp"

#include <vector>

namespace balance::tolerance {

/// A quantity at one instant of a run: value + sensitivityᵀ z, with independent numbers z of mean 0 and variance 1.
struct LinearizedSample {
  double time = 0;
  VectorX value;        ///< scalar or vector
  MatrixX sensitivity;  ///< numbers × components
};

class ExtremeFigure {
 public:
  enum class Kind {
    peak,   ///< maximum magnitude
    range,  ///< maximum minus minimum: of the value of a scalar, of the magnitude of a vector
  };

  /// Keeps the instants that may be the extremum within a few deviations, without those that vary together with a
  /// larger one.
  ExtremeFigure(const std::vector<LinearizedSample>& samples, Kind kind);

  /// Whether several instants compete, so that the figure has no gradient within a few deviations.
  bool has_several_candidates() const;
  /// The functions below evaluate all draws added so far.
  /// @param z as in LinearizedSample
  void add_draw(const VectorX& z);
  double deviation() const;
  /// Averages of the derivatives over the draws.
  VectorX contributions() const;
  /// Instants that were the maximum or minimum in at least 2 % of the draws, in order of time; neighbours are merged.
  std::vector<double> extremum_times() const;

 private:
  struct Candidate {
    LinearizedSample sample;
    long extremum_count = 0;
    VectorX gradient_sum;  ///< derivatives with respect to the components, summed over the draws that it won
  };
  struct ValueWithGradient {
    double value = 0;
    VectorX gradient;  ///< with respect to the numbers
  };

  double magnitude(const VectorX& value) const;
  ValueWithGradient magnitude_with_gradient(const LinearizedSample& sample, double sign) const;
  std::vector<Candidate> find_candidates(const std::vector<LinearizedSample>& samples, double sign);
  double update_extremum(std::vector<Candidate>& candidates, double sign, const VectorX& z) const;

  Kind kind_;
  bool near_zero_ = false;  ///< the minimum of a magnitude may be zero
  std::vector<Candidate> maximum_candidates_, minimum_candidates_;
  double duration_ = 0;
  long draws_ = 0;
  double sum_ = 0, sum_of_squares_ = 0, reference_value_ = 0;
};

/// Feeds the same draws to all figures, and the same ones every time. Deviations are accurate to a hundredth.
void sample_extreme_figures(std::vector<ExtremeFigure*>& figures, const Tolerances& numbers);

}  // namespace balance::tolerance
