#pragma once
/// Identifies a mechanism from records of its motion: base parameters, physically consistent bodies, friction, drive
/// inertias, gains of currents and payloads, with deviations, and what the records cannot say.

#include "balance/motion/simulation/measurement_record.hpp"
#include "balance/synthesis/identification/base_combinations.hpp"
#include "balance/synthesis/identification/regression.hpp"
#include "balance/synthesis/identification/unknown_parameters.hpp"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace balance::identification {

struct IdentificationOptions {
  SignalOptions signals;
  UnknownOptions unknowns;
  std::vector<std::pair<int, double>> gains;  ///< known ones: actuator, effort per current [N m/A or N/A]
  double prior_weight = 1;                    ///< of the spec's bodies against measurements of unit variance, > 0
  double correlation_time = 1;                ///< within which residuals are correlated [s], > 0
  double hold_out =
      0;  ///< of every two spans of this duration the second is predicted, not fitted [s]; 0: all are fitted
  std::uint64_t seed = 1;  ///< of the random states from which the structural rank follows
};

/// Residual of one channel, of rows in which its coordinate moves.
struct ChannelResidual {
  long rows = 0, moving_rows = 0;
  double measured = 0;  ///< root mean square of what was measured [N m, N or A]
  double residual = 0;  ///< of the identified mechanism
  double spec = 0;      ///< of the spec's mechanism
  double max_rate = 0;  ///< [rad/s or m/s]

  double relative() const { return residual / measured; }
};

/// One time series of a channel for plots: all rows of all records.
struct ChannelSeries {
  std::vector<int> record;
  std::vector<double> time, rate, measured, predicted;  ///< [SI; currents in A]
  std::vector<double> friction;                         ///< what is friction of `predicted`, passive joints' included
  std::vector<bool> moving;
};

struct ChannelReport {
  std::string name, unit;  ///< "A1", "N m", of a current "A"
  MeasuredSignal signal;
  ChannelResidual training;
  std::optional<ChannelResidual> validation;
  double residual_rms = 0;                     ///< deviation by which the channel is weighted [as its unit]
  std::optional<double> gain, gain_deviation;  ///< of a current [N m/A or N/A]
  ChannelSeries training_series, validation_series;
};

/// A combination of unknowns that the motion of this mechanism can determine.
struct BaseParameter {
  std::string name;  ///< of the unknown whose factor is one
  std::string unit;
  std::vector<std::pair<int, double>> others;       ///< further unknowns and their factors
  double value = 0, deviation = 0, spec_value = 0;  ///< [SI]; without a value if it was not found
  bool is_found = true;                             ///< false: this motion does not find it
};

enum class Determination {
  determined,   ///< the unknown is a base parameter by itself
  combined,     ///< only together with others
  nowhere,      ///< no motion shows it
  not_excited,  ///< this motion does not show it
};

struct UnknownReport {
  UnknownParameter unknown;
  Determination determination = Determination::determined;
  double value = 0;      ///< of the physically consistent mechanism [SI]
  double deviation = 0;  ///< posterior: from measurements and the spec's bodies
};

/// Of one force of the mechanism along the training records: what motors hold at rest, what shakes the frame.
struct DerivedFigure {
  std::string name, unit;  ///< "shaking_force", "weight[A1]"
  double rms = 0;          ///< root mean square along the motion
  double deviation = 0;    ///< root mean square of its deviation, from that of the base parameters; NaN: not determined
  double spec_rms = 0;     ///< of the spec's mechanism
  std::vector<std::vector<std::pair<int, double>>>
      missing;  ///< combinations of unknowns that occur in it and were not measured
};

/// A reading of the record in which it would fit better, which is probably what happened.
struct Suspicion {
  std::string text;                           ///< "the effort of A2 seems to be reversed"
  double residual = 0, residual_as_read = 0;  ///< root mean squares relative to the measured ones, all channels
};

struct Identification {
  std::vector<UnknownReport> unknowns;
  std::vector<BaseParameter> base;
  std::vector<ChannelReport> channels;
  std::vector<DerivedFigure> figures;
  std::vector<Suspicion> suspicions;
  std::vector<std::string> notes;     ///< what was done with the records
  std::vector<std::string> warnings;  ///< what should be checked
  double cutoff = 0;                  ///< [Hz]
  int structural_rank = 0;            ///< base parameters of the mechanism, friction included
  int found_rank = 0;                 ///< those that this motion finds
  double condition = 0;               ///< of columns of norm 1, of the base parameters found
  Mechanism mechanism;                ///< with the consistent values
  MatrixX base_covariance;            ///< robust against correlated residuals
};

/// The identification of an invalid request: too few columns, gains and masses at once.
struct IdentificationError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// @param training at least one; all have the same signals
/// @param validation records that are only predicted
/// @throws RecordError, IdentificationError; std::invalid_argument as MotionEquations
Identification identify(const Mechanism& mechanism, const std::vector<MeasurementRecord>& training,
                        const std::vector<MeasurementRecord>& validation, const IdentificationOptions& options = {});

/// "link1.mx + 0.25 link2.m".
std::string format_combination(const std::vector<UnknownReport>& unknowns, const std::string& name,
                               const std::vector<std::pair<int, double>>& others);

}  // namespace balance::identification
