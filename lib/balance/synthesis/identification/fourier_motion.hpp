#pragma once
/// Finite Fourier series of several coordinates, at rest where every period begins and ends.

#include "balance/foundation/base/types.hpp"

namespace balance::identification {

/// q(t) = Σ_j u_j φ_j(t) with φ₀ = 1 and, for j ≥ 1, combinations of sin(kωt)/k and cos(kωt)/k, k = 1 … H, whose rate and
/// acceleration are zero at t = 0. With q = u₀ + Σ_k (a_k sin kωt + b_k cos kωt)/k these conditions are Σ a_k = 0 and
/// Σ k b_k = 0: two of the 2H + 1 coefficients of a coordinate are not free.
class FourierMotion {
 public:
  FourierMotion() = default;
  /// @param harmonics H ≥ 2 @param period [s], positive
  FourierMotion(int harmonics, double period);

  int harmonics() const { return static_cast<int>(sines_.rows()); }
  double period() const { return period_; }
  /// 2H − 1: free coefficients u of one coordinate.
  int coefficient_count() const { return 1 + 2 * static_cast<int>(sines_.cols()); }

  /// Values φ_j or their derivatives. @param order 0, 1 or 2 @return coefficient_count() numbers
  VectorX basis(double time, int order) const;
  /// The same at several times: times × coefficient_count().
  MatrixX basis(const VectorX& times, int order) const;
  /// Factors of sin(kωt) in column 0 and cos(kωt) in column 1, per harmonic, of q with the coefficients u.
  MatrixX series(const VectorX& u) const;

 private:
  double period_ = 1;
  MatrixX sines_, cosines_;  ///< H × (H − 1): a and b of the free coefficients, orthonormal columns
};

/// `count` times that divide a period evenly, from 0.
VectorX period_times(double period, Eigen::Index count);

}  // namespace balance::identification
