#pragma once
/// Signals of a record as they enter the regression: evenly sampled pieces, low-passed without delay, and their
/// derivatives.

#include "balance/foundation/base/types.hpp"
#include "balance/motion/simulation/measurement_record.hpp"

#include <string>
#include <vector>

namespace balance::simulation {

/// An evenly sampled part of a record.
struct UniformPiece {
  double start = 0, step = 0;  ///< time of the first sample, distance of the samples [s]
  MatrixX values;              ///< samples × signals

  double time(Eigen::Index k) const { return start + step * static_cast<double>(k); }
};

/// Cuts a record at gaps and resamples each piece at the median step: positions by a cubic spline, all else linearly.
/// Pieces whose steps are even already are not changed.
/// @param notes where the record is cut, and which pieces are too short for use
std::vector<UniformPiece> resample(const MeasurementRecord& record, std::vector<std::string>& notes);

/// Low-pass filter without delay: a Butterworth filter of fourth order, forwards and backwards. The ends are continued
/// by odd reflection, and each pass starts in the steady state of the first value.
/// Source: F. Gustafsson, Determining the initial states in forward-backward filtering, IEEE Trans. Signal Process.
/// 44(4), 1996.
class ZeroPhaseFilter {
 public:
  /// @param cutoff [Hz], below half of the sampling rate; else signals are not changed @param step [s]
  ZeroPhaseFilter(double cutoff, double step);
  /// Filters every column in place.
  void apply(Eigen::Ref<MatrixX> columns) const;

 private:
  struct Section {
    double b0, b1, b2, a1, a2;
  };
  void run(std::vector<double>& signal) const;

  std::vector<Section> sections_;  ///< none: no change
  Eigen::Index padding_ = 0;       ///< samples of the reflection at each end
};

/// Derivatives by central differences of sixth order; the first and last three samples are those of the nearest one
/// that has all its neighbours.
void differentiate(const MatrixX& values, double step, MatrixX& rates, MatrixX& accelerations);
/// Samples at each end whose derivatives are copies.
inline constexpr Eigen::Index derivative_margin = 3;

/// Frequency below which a fraction of the energy of the signals' rates lies, in all pieces together: of the fastest
/// signal, relative to its own energy, white noise of the positions apart [Hz].
/// @param positions of every piece, the same signals @param steps of every piece [s]
double find_bandwidth(const std::vector<MatrixX>& positions, const std::vector<double>& steps, double fraction);

/// Cut-off of the low-pass filter for these positions: six times the frequency below which 99 % of the energy of the
/// rates lies, at most a fifth of the sampling rate; two digits, which do not depend on round-off [Hz]. 0: nothing moves.
/// @param notes says so if the sampling rate limits it
double find_cutoff(const std::vector<MatrixX>& positions, const std::vector<double>& steps,
                   std::vector<std::string>& notes);
/// Positions are low-passed at this multiple of the cut-off: what they pass below it is flat.
inline constexpr double position_cutoff_ratio = 3;

/// Samples at each end that the filter and the derivatives distort.
Eigen::Index count_edge_samples(double cutoff, double step);

}  // namespace balance::simulation
