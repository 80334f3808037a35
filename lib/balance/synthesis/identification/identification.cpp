#include "balance/synthesis/identification/identification.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/identification/consistent_bodies.hpp"
#include "balance/synthesis/identification/diagnosis.hpp"
#include "balance/synthesis/identification/estimation.hpp"
#include "balance/synthesis/identification/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::identification {

namespace {

constexpr Eigen::Index max_figure_states = 500;
constexpr double moved_body_ratio = 3;  ///< of mass or inertia against the spec, beyond which a body is questioned
constexpr double negative_friction_deviations = 3;
constexpr double covered_rate_ratio = 1.25;  ///< of a validation's fastest motion against that of the training

/// The equations in coordinates that were measured.
MotionEquations make_equations(const Mechanism& mechanism, const MeasurementRecord& record) {
  const std::vector<std::string> measured = choose_measured_coordinates(mechanism, record);
  MotionEquations equations(mechanism);
  std::vector<std::string> missing;
  for (const CoordinateId c : equations.independent())
    if (const std::string& name = mechanism.coordinates[c].name;
        std::find(measured.begin(), measured.end(), name) == measured.end())
      missing.push_back(name);
  if (missing.empty()) return equations;
  const auto n = static_cast<std::size_t>(equations.degrees_of_freedom());
  if (measured.size() < n)
    throw RecordError(
        fmt::format("{}: expected the positions of {}, as many as there are degrees of freedom; that of {} is missing",
                    record.source, count_noun(static_cast<long>(n), "coordinate", "coordinates"),
                    join_with_conjunction(missing, "and")));
  return MotionEquations(mechanism, {measured.begin(), measured.begin() + static_cast<std::ptrdiff_t>(n)});
}

double root_mean_square(double sum, long count) { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0; }

class Identifier {
 public:
  Identifier(const Mechanism& mechanism, const std::vector<MeasurementRecord>& training,
             const std::vector<MeasurementRecord>& validation, const IdentificationOptions& options)
      : mechanism_(mechanism),
        training_(training),
        validation_(validation),
        options_(options),
        unknowns_(list_unknowns(mechanism, options.unknowns)),
        equations_(make_equations(with_friction_coordinates(mechanism, unknowns_), training.at(0))) {
    for (const UnknownParameter& unknown : unknowns_) groups_.push_back(column_group(unknown));
    spec_.resize(static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t k = 0; k < unknowns_.size(); ++k) spec_[static_cast<Eigen::Index>(k)] = unknowns_[k].spec_value;
  }

  Identification run() {
    regression_ = build_regression(equations_, unknowns_, training_, options_.signals);
    out_.cutoff = regression_.cutoff;
    out_.notes = regression_.notes;
    if (options_.hold_out > 0) hold_out_spans();
    choose_gains();
    find_base();
    estimate_ = estimate(regression_.channels, compressed_, base_, spec_, gains_);
    if (estimate_.gains_are_ambiguous)
      throw IdentificationError(
          "gains and masses cannot both be found from these records: every mass could be larger with every gain. Give "
          "the "
          "gains, or a second record with a known payload");
    const MatrixX covariance =
        robust_covariance(regression_.channels, base_, estimate_, gains_, options_.correlation_time);
    out_.base_covariance = covariance.topLeftCorner(base_.rank(), base_.rank());
    fit_bodies();
    report_base();
    report_unknowns();
    report_channels(covariance);
    report_figures();
    out_.suspicions =
        diagnose({equations_, unknowns_, training_, regression_, compressed_, base_, spec_, gains_, estimate_});
    list_warnings();
    return std::move(out_);
  }

 private:
  /// The second of every two spans is neither fitted nor counted in the training; the others not in the validation.
  void hold_out_spans() {
    held_out_ = regression_.channels;
    for (std::size_t c = 0; c < held_out_.size(); ++c)
      for (std::size_t p = 0; p < held_out_[c].pieces.size(); ++p) {
        ChannelPiece &fitted = regression_.channels[c].pieces[p], &predicted = held_out_[c].pieces[p];
        for (Eigen::Index k = 0; k < fitted.time.size(); ++k) {
          const auto row = static_cast<std::size_t>(k);
          const bool is_held_out = std::fmod(std::floor(fitted.time[k] / options_.hold_out), 2) != 0;
          (is_held_out ? fitted : predicted).moving[row] = false;
          if (is_held_out) fitted.is_fitted[row] = false;
        }
      }
  }

  void choose_gains() {
    for (Channel& channel : regression_.channels) {
      gains_.emplace_back();
      if (!channel.is_current) continue;
      for (const auto& [actuator, gain] : options_.gains)
        if (actuator == channel.signal.index) gains_.back() = gain;
    }
    const bool has_unknown_gain = [&] {
      for (std::size_t c = 0; c < gains_.size(); ++c)
        if (regression_.channels[c].is_current && !gains_[c]) return true;
      return false;
    }();
    if (has_unknown_gain && !options_.unknowns.payloads.empty())
      throw IdentificationError(
          "a payload and gains cannot be found from the same records: find the gains with a known payload first, then "
          "give "
          "them");
  }

  void find_base() {
    probes_ = probe(equations_, unknowns_, regression_.channels, regression_.states, training_, options_.seed);
    compressed_ = compress(regression_.channels);
    MatrixX measured(0, static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t c = 0; c < compressed_.size(); ++c) {
      const MatrixX columns = compressed_[c].columns();
      const double size = VectorX(compressed_[c].measured(c)).norm();
      if (!(size > 0)) continue;
      measured.conservativeResize(measured.rows() + columns.rows(), Eigen::NoChange);
      measured.bottomRows(columns.rows()) = columns / size;
    }
    clear_negligible_columns(unknowns_, probes_, measured);
    base_ = find_base_combinations(measured, probes_.measured, groups_);
    out_.structural_rank = static_cast<int>(base_.rank());
  }

  void fit_bodies() {
    Eigen::Index rows = 0;
    for (const CompressedChannel& channel : compressed_) rows += channel.columns().rows();
    MatrixX A(rows, static_cast<Eigen::Index>(unknowns_.size()));
    VectorX b(rows);
    Eigen::Index next = 0;
    for (std::size_t c = 0; c < compressed_.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      const CompressedChannel& channel = compressed_[c];
      const Eigen::Index count = channel.columns().rows();
      A.middleRows(next, count) = estimate_.kappa[i] / estimate_.residual_rms[i] * channel.columns();
      b.segment(next, count) = (channel.measured(c) - estimate_.kappa[i] * channel.known()) / estimate_.residual_rms[i];
      next += count;
    }
    const ConsistentFit fit = fit_consistent_bodies(mechanism_, unknowns_, A, b, options_.prior_weight);
    x_ = fit.x;
    posterior_ = fit.covariance;
    out_.mechanism = apply_values(mechanism_, unknowns_, x_);
    if (!fit.repaired.empty())
      out_.notes.push_back(fmt::format(
          "the inertia of {} in the spec is that of no body: one of the same mass and of a plausible size is the prior",
          join_with_conjunction(fit.repaired, "and")));
    if (!fit.is_converged) out_.warnings.push_back("the physically consistent bodies did not converge");
  }

  std::vector<std::pair<int, double>> others_of(Eigen::Index k) const {
    std::vector<std::pair<int, double>> others;
    for (std::size_t j = 0; j < base_.rest.size(); ++j)
      if (const double factor = base_.factors(k, static_cast<Eigen::Index>(j)); factor != 0)
        others.emplace_back(base_.rest[j], factor);
    return others;
  }

  void report_base() {
    const VectorX spec = base_.evaluate(spec_);
    out_.condition = estimate_.condition;
    for (Eigen::Index k = 0; k < base_.rank(); ++k) {
      const UnknownParameter& unknown = unknowns_[static_cast<std::size_t>(base_.base[static_cast<std::size_t>(k)])];
      out_.base.push_back({.name = unknown.name,
                           .unit = unknown.unit,
                           .others = others_of(k),
                           .value = estimate_.beta[k],
                           .deviation = std::sqrt(std::max(0.0, out_.base_covariance(k, k))),
                           .spec_value = spec[k],
                           .is_found = estimate_.found[static_cast<std::size_t>(k)]});
      out_.found_rank += estimate_.found[static_cast<std::size_t>(k)] ? 1 : 0;
    }
  }

  void report_unknowns() {
    for (std::size_t k = 0; k < unknowns_.size(); ++k) {
      UnknownReport report{
          unknowns_[k], Determination::determined, x_[static_cast<Eigen::Index>(k)],
          std::sqrt(std::max(0.0, posterior_(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k))))};
      const auto in_base = std::find(base_.base.begin(), base_.base.end(), static_cast<int>(k));
      if (in_base != base_.base.end()) {
        const BaseParameter& parameter = out_.base[static_cast<std::size_t>(in_base - base_.base.begin())];
        report.determination = !parameter.is_found        ? Determination::not_excited
                               : parameter.others.empty() ? Determination::determined
                                                          : Determination::combined;
        if (report.determination == Determination::determined) report.deviation = parameter.deviation;
      } else {
        const auto rest = std::find(base_.rest.begin(), base_.rest.end(), static_cast<int>(k)) - base_.rest.begin();
        report.determination = base_.factors.col(rest).isZero(0) ? Determination::nowhere : Determination::combined;
      }
      out_.unknowns.push_back(std::move(report));
    }
  }

  /// The identified values of friction; other unknowns are zero.
  VectorX friction_values() const {
    VectorX values = x_;
    for (std::size_t k = 0; k < unknowns_.size(); ++k)
      if (!is_friction(unknowns_[k].kind)) values[static_cast<Eigen::Index>(k)] = 0;
    return values;
  }

  void add_residuals(const Channel& channel, double kappa, ChannelResidual& residual, ChannelSeries& series) const {
    double measured = 0, error = 0, spec = 0;
    for (const ChannelPiece& piece : channel.pieces) {
      const VectorX predicted = kappa * (piece.columns * x_ + piece.known),
                    with_spec = kappa * (piece.columns * spec_ + piece.known),
                    friction = kappa * (piece.columns * friction_values());
      for (Eigen::Index k = 0; k < piece.measured.size(); ++k) {
        ++residual.rows;
        residual.max_rate = std::max(residual.max_rate, std::abs(piece.rate[k]));
        series.record.push_back(piece.record);
        series.time.push_back(piece.time[k]);
        series.rate.push_back(piece.rate[k]);
        series.measured.push_back(piece.measured[k]);
        series.predicted.push_back(predicted[k]);
        series.friction.push_back(friction[k]);
        series.moving.push_back(piece.moving[static_cast<std::size_t>(k)]);
        if (!piece.moving[static_cast<std::size_t>(k)]) continue;
        ++residual.moving_rows;
        measured += piece.measured[k] * piece.measured[k];
        error += (piece.measured[k] - predicted[k]) * (piece.measured[k] - predicted[k]);
        spec += (piece.measured[k] - with_spec[k]) * (piece.measured[k] - with_spec[k]);
      }
    }
    residual.measured = root_mean_square(measured, residual.moving_rows);
    residual.residual = root_mean_square(error, residual.moving_rows);
    residual.spec = root_mean_square(spec, residual.moving_rows);
  }

  void report_channels(const MatrixX& covariance) {
    std::optional<Regression> validation;
    if (!validation_.empty()) {
      SignalOptions signals = options_.signals;
      signals.cutoff = regression_.cutoff;
      validation = build_regression(equations_, unknowns_, validation_, signals);
      for (const std::string& note : validation->notes) out_.notes.push_back("validation: " + note);
      if (validation->channels.size() != regression_.channels.size())
        throw RecordError(validation_.front().source + ": does not have the same efforts or currents as the training");
    }
    Eigen::Index unknown_gain = base_.rank();
    for (std::size_t c = 0; c < regression_.channels.size(); ++c) {
      const Channel& channel = regression_.channels[c];
      const double kappa = estimate_.kappa[static_cast<Eigen::Index>(c)];
      ChannelReport report{
          .name = channel.name, .unit = channel.is_current ? "A" : channel.unit, .signal = channel.signal};
      add_residuals(channel, kappa, report.training, report.training_series);
      report.residual_rms = estimate_.residual_rms[static_cast<Eigen::Index>(c)];
      if (!held_out_.empty()) add_residuals(held_out_[c], kappa, report.validation.emplace(), report.validation_series);
      if (validation)
        add_residuals(validation->channels[c], kappa, report.validation.emplace(), report.validation_series);
      if (channel.is_current) {
        report.gain = 1 / kappa;
        if (!gains_[c]) {
          report.gain_deviation = std::sqrt(std::max(0.0, covariance(unknown_gain, unknown_gain))) / (kappa * kappa);
          ++unknown_gain;
        }
      }
      out_.channels.push_back(std::move(report));
    }
  }

  std::vector<std::vector<std::pair<int, double>>> missing_in(const MatrixX& rows) const {
    std::vector<std::vector<std::pair<int, double>>> all;
    const MatrixX combinations = find_missing_combinations(rows, base_, groups_);
    for (Eigen::Index k = 0; k < combinations.rows(); ++k) {
      std::vector<std::pair<int, double>> one;
      for (Eigen::Index p = 0; p < combinations.cols(); ++p)
        if (combinations(k, p) != 0) one.emplace_back(static_cast<int>(p), combinations(k, p));
      all.push_back(std::move(one));
    }
    return all;
  }

  struct FigureSum {
    double square = 0, variance = 0, spec_square = 0;
    long count = 0;
  };

  void add_figure_rows(const MatrixX& columns, const VectorX& known, FigureSum& sum) const {
    sum.square += (columns * x_ + known).squaredNorm();
    sum.spec_square += (columns * spec_ + known).squaredNorm();
    const MatrixX base = base_columns(columns, base_);
    sum.variance += (base * out_.base_covariance).cwiseProduct(base).sum();
    ++sum.count;
  }

  /// Shaking force and moment, and the efforts that weight needs, along the training records.
  void report_figures() {
    const int n = equations_.degrees_of_freedom(), axes = mechanism_.space == SpaceKind::planar ? 2 : 3;
    const int moments = equations_.frame_rows() - axes;
    FigureSum force, moment;
    std::vector<FigureSum> weight(static_cast<std::size_t>(n));
    Eigen::Index states = 0;
    for (const MeasuredStates& part : regression_.states) states += part.q.rows();
    const Eigen::Index stride = states / max_figure_states + 1;
    MotionEquation equation;
    const VectorX zero = VectorX::Zero(n);
    for (const MeasuredStates& part : regression_.states) {
      const MeasurementRecord& record = training_[static_cast<std::size_t>(part.record)];
      const VectorX known = known_inertial_values(mechanism_, equations_.inertial_values(), unknowns_, record.payloads);
      const auto rows_of = [&] {
        return make_regressor_rows(mechanism_, equation, unknowns_, known, record.payloads, options_.signals.rest_rate);
      };
      for (Eigen::Index k = 0; k < part.q.rows(); k += stride) {
        if (equations_
                .evaluate(part.q.row(k).transpose(), part.dq.row(k).transpose(), part.ddq.row(k).transpose(),
                          part.time[k], equation)
                .status != MotionStatus::done)
          continue;
        equation.frame = equation.shaking;
        equation.known_frame.setZero();
        const RegressorRows shaking = rows_of();
        add_figure_rows(shaking.columns.middleRows(n, axes), shaking.known.segment(n, axes), force);
        add_figure_rows(shaking.columns.bottomRows(moments), shaking.known.tail(moments), moment);
        if (equations_.evaluate(part.q.row(k).transpose(), zero, zero, part.time[k], equation).status !=
            MotionStatus::done)
          continue;
        RegressorRows rest = rows_of();
        for (std::size_t u = 0; u < unknowns_.size(); ++u)
          if (is_friction(unknowns_[u].kind)) rest.columns.col(static_cast<Eigen::Index>(u)).setZero();
        for (int j = 0; j < n; ++j)
          add_figure_rows(rest.columns.row(j), rest.known.segment(j, 1), weight[static_cast<std::size_t>(j)]);
      }
    }
    const auto add = [&](const std::string& name, const std::string& unit, const FigureSum& sum, const MatrixX& rows) {
      DerivedFigure figure{name,
                           unit,
                           root_mean_square(sum.square, sum.count),
                           root_mean_square(sum.variance, sum.count),
                           root_mean_square(sum.spec_square, sum.count),
                           missing_in(rows)};
      if (!figure.missing.empty()) figure.deviation = std::numeric_limits<double>::quiet_NaN();
      out_.figures.push_back(std::move(figure));
    };
    add("shaking_force", "N", force, probes_.shaking_force);
    add("shaking_moment", "N m", moment, probes_.shaking_moment);
    if (mechanism_.gravity.norm() == 0) return;
    double largest_weight = 0;
    for (const FigureSum& sum : weight) largest_weight = std::max(largest_weight, sum.square);
    for (int j = 0; j < n; ++j) {
      if (!(weight[static_cast<std::size_t>(j)].square > negligible_column * negligible_column * largest_weight))
        continue;  // a vertical axis
      MatrixX rows(probes_.weight.rows() / n, probes_.weight.cols());
      for (Eigen::Index k = 0; k < rows.rows(); ++k) rows.row(k) = probes_.weight.row(k * n + j);
      const CoordinateId c = has_effort_rows(mechanism_, n) ? mechanism_.actuators[static_cast<std::size_t>(j)]
                                                            : equations_.independent()[static_cast<std::size_t>(j)];
      add("weight[" + mechanism_.coordinates[c].name + "]", is_length_coordinate(mechanism_, c) ? "N" : "N m",
          weight[static_cast<std::size_t>(j)], rows);
    }
  }

  void list_warnings() {
    for (const BaseParameter& parameter : out_.base) {
      const bool cannot_be_negative = parameter.name.ends_with(".viscous") || parameter.name.ends_with(".coulomb");
      if (cannot_be_negative && parameter.is_found &&
          parameter.value < -negative_friction_deviations * parameter.deviation)
        out_.warnings.push_back(
            fmt::format("{} is negative, {:.4g} ± {:.2g} {}: is its position or its effort reversed?", parameter.name,
                        parameter.value, parameter.deviation, parameter.unit));
    }
    std::vector<std::string> moved;
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) {
      const Body &before = mechanism_.bodies[b], &after = out_.mechanism.bodies[b];
      if (!(before.mass > 0)) continue;
      const auto size_of = [](const Body& body) { return body.inertia.trace() + body.mass * body.com.squaredNorm(); };
      const double mass = after.mass / before.mass, inertia = size_of(after) / size_of(before);
      if (std::max({mass, 1 / mass, inertia, 1 / inertia}) > moved_body_ratio && std::isfinite(inertia))
        moved.push_back(before.name);
    }
    if (!moved.empty())
      out_.warnings.push_back(
          fmt::format("{} {} more than threefold from the spec: is the zero of a joint where the spec has it?",
                      join_with_conjunction(moved, "and"), moved.size() == 1 ? "has moved" : "have moved"));
    for (const ChannelReport& channel : out_.channels)
      if (channel.validation && channel.validation->max_rate > covered_rate_ratio * channel.training.max_rate)
        out_.warnings.push_back(
            fmt::format("the validation moves {} at up to {:.4g}, the training at {:.4g}: friction is extrapolated",
                        channel.name, channel.validation->max_rate, channel.training.max_rate));
    for (const ChannelReport& channel : out_.channels)
      if (channel.training.moving_rows == 0)
        out_.warnings.push_back(fmt::format("{} never moves: nothing is known of its friction", channel.name));
  }

  const Mechanism& mechanism_;
  const std::vector<MeasurementRecord>& training_;
  const std::vector<MeasurementRecord>& validation_;
  const IdentificationOptions& options_;
  const std::vector<UnknownParameter> unknowns_;
  MotionEquations equations_;
  std::vector<int> groups_;
  VectorX spec_;
  Regression regression_;
  std::vector<std::optional<double>> gains_;
  ProbeRows probes_;
  BaseCombinations base_;
  std::vector<Channel> held_out_;  ///< if spans are held out: what is predicted
  std::vector<CompressedChannel> compressed_;
  Estimate estimate_;
  VectorX x_;
  MatrixX posterior_;
  Identification out_;
};

}  // namespace

Identification identify(const Mechanism& mechanism, const std::vector<MeasurementRecord>& training,
                        const std::vector<MeasurementRecord>& validation, const IdentificationOptions& options) {
  if (training.empty()) throw std::invalid_argument("expected at least one record");
  if (!(options.hold_out >= 0) || (options.hold_out > 0 && !validation.empty()))
    throw std::invalid_argument("expected validation records or a span that is held out, not both");
  if (!(options.prior_weight > 0) || !(options.correlation_time > 0))
    throw std::invalid_argument("expected positive weights and times");
  return Identifier(mechanism, training, validation, options).run();
}

std::string format_combination(const std::vector<UnknownReport>& unknowns, const std::string& name,
                               const std::vector<std::pair<int, double>>& others) {
  std::string text = name;
  for (const auto& [index, factor] : others) {
    const std::string& other = unknowns[static_cast<std::size_t>(index)].unknown.name;
    text += text.empty() ? (factor < 0 ? "-" : "") : (factor < 0 ? " - " : " + ");
    const double magnitude = std::abs(factor);
    text += std::abs(magnitude - 1) < 1e-9 ? other : fmt::format("{:.4g} {}", magnitude, other);
  }
  return text;
}

}  // namespace balance::identification
