#pragma once
/// Weighted least squares of all channels, with the deviations of its result.

#include "balance/synthesis/identification/base_combinations.hpp"
#include "balance/synthesis/identification/regression.hpp"

#include <optional>
#include <vector>

namespace balance::identification {

/// Singular values of columns of norm 1 below this part of the largest belong to what the motion does not show.
inline constexpr double excitation_threshold = 1e-3;
/// A parameter is found unless directions that are not shown contain this much of it.
inline constexpr double hidden_share_tolerance = 1e-3;

/// A channel's fitted rows as the triangular factor of [columns, known, measured of all channels]: the same normal
/// equations in as many rows as there are columns.
class CompressedChannel {
 public:
  CompressedChannel(const std::vector<Channel>& channels, std::size_t channel);

  Eigen::Index rows() const { return rows_; }
  auto columns() const { return factor_.leftCols(unknowns_); }
  auto known() const { return factor_.col(unknowns_); }
  /// What channel k measured, in the rows of this channel.
  auto measured(std::size_t k) const { return factor_.col(unknowns_ + 1 + static_cast<Eigen::Index>(k)); }

 private:
  Eigen::Index rows_ = 0, unknowns_ = 0;
  MatrixX factor_;
};

std::vector<CompressedChannel> compress(const std::vector<Channel>& channels);

/// What a channel measures: `factor` times what channel `source` recorded.
struct Reading {
  std::size_t source = 0;
  double factor = 1;
};

/// measured ≈ κ (columns · x + known), with κ = 1 for efforts and 1/gain for currents.
struct Estimate {
  VectorX beta;                  ///< base parameters; directions that the motion does not show are as in the spec
  VectorX kappa;                 ///< per channel
  VectorX residual_rms;          ///< per channel: root mean square of the residual
  std::vector<bool> found;       ///< per base parameter
  int rank = 0;                  ///< of the base columns, weighted
  double condition = 0;          ///< of the base columns of norm 1, without what the motion does not show
  double relative_residual = 0;  ///< root of the mean over the channels of (residual / measured)²
  bool gains_are_ambiguous = false;
};

/// Weights and, where gains are unknown, their inverses are found by repetition (Gauss–Newton).
/// @param spec values of all unknowns in the spec @param gains per channel: known ones of currents
Estimate estimate(const std::vector<Channel>& channels, const std::vector<CompressedChannel>& compressed,
                  const BaseCombinations& base, const VectorX& spec, const std::vector<std::optional<double>>& gains,
                  const std::vector<Reading>& readings = {});

/// Covariance of (β, κ of channels with unknown gains), robust against residuals that are correlated for a while: Bartlett
/// weights over `correlation_time`. Rows and columns of what was not found are zero.
/// Source: W. K. Newey, K. D. West, A simple, positive semi-definite, heteroskedasticity and autocorrelation consistent
/// covariance matrix, Econometrica 55(3), 1987.
MatrixX robust_covariance(const std::vector<Channel>& channels, const BaseCombinations& base, const Estimate& estimate,
                          const std::vector<std::optional<double>>& gains, double correlation_time);

/// The columns of the base parameters.
MatrixX base_columns(const MatrixX& columns, const BaseCombinations& base);

}  // namespace balance::identification
