#pragma once
/// Finds a motion along which a mechanism should be measured: it shows the base parameters best within given limits.

#include "balance/synthesis/identification/fourier_motion.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace balance::identification {

/// A bound that holds at every moment of the motion.
struct ExcitationLimit {
  enum class Kind { position, rate, acceleration, effort };
  Kind kind = Kind::position;
  int index =
      0;  ///< coordinate of the mechanism; of an effort the actuator or, without actuators, the independent coordinate
  double lower = 0, upper = 0;  ///< lower < upper [SI]
};

struct ExcitationOptions {
  UnknownOptions unknowns;
  int harmonics = 5;   ///< 2 or more
  double period = 10;  ///< of the lowest harmonic [s]
  int periods = 1;     ///< the motion is repeated
  /// At most one of a kind and index. Coordinates of loops that are not independent may be limited, too.
  std::vector<ExcitationLimit> limits;
  std::vector<double> noise_deviations;  ///< per channel: assumed deviation [SI]; 0, or missing: relative_noise
  double relative_noise = 0.01;          ///< of the largest measured value along random series
  bool has_frame_sensor = false;         ///< force and moment on the frame are measured, too
  double sampling_rate = 250;            ///< of the measurement, whose noise is white [Hz]
  double min_mobility = 0.1;             ///< of loops, at every moment
  double rest_rate = 0.02;               ///< as SignalOptions::rest_rate
  int random_series = 21;                ///< with which the motion is compared; the search starts at the best of them
  int starts = 3;                        ///< local searches, at most
  double max_time = 30;                  ///< CPU time of the search [s]; 0: unlimited
  int max_evaluations = 0;  ///< of all local searches together; 0: unlimited. With it alone the result is reproducible
  std::uint64_t seed = 1;
  std::function<bool(double fraction)> on_progress;  ///< false ends the search; may be null
};

/// How well a motion shows the base parameters.
struct MotionInformation {
  double log_det = 0;    ///< natural logarithm of the determinant of the information about the base parameters [SI]
  double condition = 0;  ///< of its weighted columns, scaled to norm 1
};

/// What is measured, and how large it is along the motion.
struct ExcitedChannel {
  std::string name, unit;      ///< "A1", "N m"
  double noise_deviation = 0;  ///< assumed deviation of a sample
  bool is_noise_given = false;
  double rms = 0, peak = 0;
  double moving_share = 0;  ///< part of the samples in which its coordinate is not at rest
};

struct ExcitationLimitUse {
  ExcitationLimit limit;
  std::string name, unit;          ///< "A1", "A1.rate"; SI
  double lowest = 0, highest = 0;  ///< along the motion
  bool is_given = true;            ///< false: a position limit that was assumed
  bool is_active = false;          ///< less than 2 % of the range is left

  double used() const;  ///< part of the range that is used on the nearer side: 1 at the limit
};

struct ExcitedParameter {
  BaseParameter parameter;      ///< `deviation`: expected for the assumed noise; `value` is that of the spec
  double random_deviation = 0;  ///< along the median of the random series
};

struct Excitation {
  FourierMotion motion;
  int periods = 1;
  std::vector<CoordinateId> coordinates;  ///< independent ones, that move along the series
  MatrixX coefficients;                   ///< coordinates × FourierMotion::coefficient_count() [rad or m]
  std::vector<ExcitedChannel> channels;
  std::vector<ExcitationLimitUse> limits;
  std::vector<ExcitedParameter> base;
  std::vector<UnknownReport> unknowns;  ///< without values and deviations
  int structural_rank = 0, found_rank = 0;
  MotionInformation found;
  MotionInformation median_random;     ///< medians of both numbers
  MotionInformation start;             ///< of the best random series
  std::vector<DerivedFigure> figures;  ///< only what of force and moment on the frame stays hidden
  double min_mobility = 1;             ///< along the motion; 1 without loops
  bool has_loops = false;
  int random_series = 0;  ///< of those within the limits
  int local_searches = 0;
  long evaluations = 0;
  bool is_time_exhausted = false;
  std::vector<std::string> notes;

  double duration() const { return motion.period() * periods; }
  /// Independent coordinates, or their derivatives. @param order 0, 1 or 2
  VectorX evaluate(double time, int order) const { return coefficients * motion.basis(time, order); }
};

/// No motion of this form is within the limits, or none can be measured.
struct ExcitationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Nothing limits the speed, so that no motion is the best one.
struct UnlimitedSpeedError : ExcitationError {
  using ExcitationError::ExcitationError;
};

/// Maximises the determinant of the information, Σ Yᵀ W Y over the samples of a measurement, with the regressor Y of the
/// base parameters that identify() uses and W of the noise. Its volume of confidence is the least, whatever the units of
/// the parameters. Source: J. Swevers, C. Ganseman, D. Tükel, J. De Schutter, H. Van Brussel, Optimal robot excitation and
/// identification, IEEE Trans. Robotics and Automation 13(5), 1997.
/// @throws ExcitationError; std::invalid_argument as MotionEquations
Excitation find_excitation(const Mechanism& mechanism, const ExcitationOptions& options);

}  // namespace balance::identification
