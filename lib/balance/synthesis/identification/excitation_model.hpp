#pragma once
/// What a motion along Fourier series shows of a mechanism and demands of it, with derivatives.

#include "balance/synthesis/identification/excitation.hpp"
#include "balance/synthesis/identification/motion_equation.hpp"
#include "balance/synthesis/identification/regression.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::identification {

/// A motion at sampled times; coefficients are scaled by those of the model.
struct SampledMotion {
  MatrixX q, dq, ddq;            ///< samples × independent coordinates
  std::vector<MatrixX> columns;  ///< per sample: channels × unknowns, weighted by the noise of the channels
  MatrixX measured;              ///< samples × channels: efforts and frame forces of the spec [SI]
  MatrixX limited;               ///< samples × limits: values
  VectorX mobility;              ///< per sample
  std::vector<std::vector<bool>> is_fitted;  ///< per sample and channel: no dry friction of a joint at rest
  MatrixX channel_rates;                     ///< samples × channels; zero of the frame
};

/// Evaluates motions of one mechanism.
class ExcitationModel {
 public:
  ExcitationModel(const Mechanism& mechanism, const ExcitationOptions& options);

  int freedoms() const { return equations_.degrees_of_freedom(); }
  const FourierMotion& motion() const { return motion_; }
  const std::vector<UnknownParameter>& unknowns() const { return unknowns_; }
  const std::vector<Channel>& channels() const { return channels_; }
  const std::vector<ExcitationLimit>& limits() const { return limits_; }
  const std::vector<bool>& is_limit_given() const { return is_limit_given_; }
  MotionEquations& equations() { return equations_; }
  const Mechanism& mechanism() const { return equations_.mechanism(); }
  const std::vector<std::string>& payloads() const { return payloads_; }
  const VectorX& start() const {
    return start_;
  }                        ///< independent coordinates as assembled, or the middle of their limits
  VectorX middle() const;  ///< of their positions' limits
  VectorX half_range() const;
  bool has_loops() const { return has_loops_; }

  /// Weights of the rows: 1/noise. @param noise per channel
  void set_noise(const VectorX& noise_deviations) { weights_ = noise_deviations.cwiseInverse(); }
  const VectorX& weights() const { return weights_; }
  const VectorX& spec_values() const { return spec_; }

  /// @param coefficients freedoms × coefficient_count [rad or m] @param dry_rate below it, dry friction grows with the rate
  /// @return none if the mechanism cannot be there
  std::optional<SampledMotion> sample(const MatrixX& coefficients, const VectorX& times, double dry_rate);

  /// Derivatives at one state by differences, forward in positions and rates; accelerations enter linearly.
  struct StateSlopes {
    VectorX information;  ///< 3 freedoms: of Σ weights of `factors` · columns
    MatrixX limited;      ///< limits × 3 freedoms
    VectorX mobility;     ///< freedoms
  };
  /// @param factors channels × unknowns
  std::optional<StateSlopes> differentiate(const SampledMotion& motion, Eigen::Index sample, const VectorX& times,
                                           double dry_rate, const MatrixX& factors);

 private:
  struct State {
    RegressorRows rows;
    VectorX limited;
    double mobility = 1;
    VectorX rates;
  };
  bool evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time, double dry_rate, State& state);
  bool return_to_start();
  void list_channels();
  void set_limits(const std::vector<ExcitationLimit>& given);
  Eigen::Index row_of(std::size_t channel) const;
  VectorX actuator_efforts(const RegressorRows& rows) const;

  const ExcitationOptions& options_;
  std::vector<UnknownParameter> unknowns_;
  MotionEquations equations_;
  FourierMotion motion_;
  std::vector<std::string> payloads_;
  std::vector<Channel> channels_;
  std::vector<ExcitationLimit> limits_;
  std::vector<bool> is_limit_given_;
  VectorX start_, start_coordinates_, spec_, known_values_, weights_;
  bool has_loops_ = false, needs_positions_ = false;
  MotionEquation equation_;
};

}  // namespace balance::identification
