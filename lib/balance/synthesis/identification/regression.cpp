#include "balance/synthesis/identification/regression.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/signal_processing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace balance::identification {

using dynamics::ParameterOwner;
using simulation::differentiate;
using simulation::UniformPiece;
using simulation::ZeroPhaseFilter;

namespace {

/// Below this fraction of rest_rate, dry friction is proportional to the rate.
constexpr double dry_ramp_fraction = 0.25;
/// Regressors are evaluated at least at this multiple of the cut-off.
constexpr double evaluation_ratio = 20;
/// Singular values of the map from efforts to generalised forces below this part of the largest one.
constexpr double singular_input_threshold = 1e-8;
/// The decimated rows follow at this multiple of the cut-off.
constexpr double decimation_ratio = 2;

double dry_direction(double rate, double rest_rate) {
  return std::clamp(rate / (dry_ramp_fraction * rest_rate), -1.0, 1.0);
}

}  // namespace

long Channel::count(std::vector<bool> ChannelPiece::*mask) const {
  long rows = 0;
  for (const ChannelPiece& piece : pieces) rows += std::count((piece.*mask).begin(), (piece.*mask).end(), true);
  return rows;
}

bool has_effort_rows(const Mechanism& mechanism, int freedoms) {
  return static_cast<int>(mechanism.actuators.size()) == freedoms;
}

std::vector<std::string> choose_measured_coordinates(const Mechanism& mechanism, const MeasurementRecord& record) {
  std::vector<std::string> names;
  const auto add = [&](int coordinate) {
    const std::string& name = mechanism.coordinates[static_cast<std::size_t>(coordinate)].name;
    if (find_signal(record, {MeasuredSignal::Kind::position, coordinate}) >= 0 &&
        std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  };
  for (const CoordinateId actuated : mechanism.actuators) add(actuated);
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) add(static_cast<int>(c));
  return names;
}

RegressorRows make_regressor_rows(const Mechanism& mechanism, const MotionEquation& equation,
                                  const std::vector<UnknownParameter>& unknowns, const VectorX& known_values,
                                  const std::vector<std::string>& carried, double rest_rate) {
  const auto n = equation.inertial.rows(), frame = equation.frame.rows();
  const auto U = static_cast<Eigen::Index>(unknowns.size());
  const int count = inertial_parameter_count(mechanism);
  RegressorRows out{MatrixX::Zero(n + frame, U), VectorX(n + frame), equation.input, true,
                    std::vector<std::vector<int>>(static_cast<std::size_t>(n + frame))};
  out.known << equation.inertial * known_values + equation.known, equation.frame * known_values + equation.known_frame;
  MatrixX dry_effects(n, 0);
  std::vector<int> dry_coordinates;
  for (Eigen::Index k = 0; k < U; ++k) {
    const UnknownParameter& unknown = unknowns[static_cast<std::size_t>(k)];
    const auto along = [&] { return equation.rate_map.row(unknown.element).transpose(); };
    const auto take = [&](ParameterOwner owner) {
      const int column = first_inertial_parameter(mechanism, owner, unknown.element) + unknown.slot;
      out.columns.col(k) << equation.inertial.col(column), equation.frame.col(column);
    };
    switch (unknown.kind) {
      case UnknownKind::body: take(ParameterOwner::body); break;
      case UnknownKind::payload:
        if (std::find(carried.begin(), carried.end(),
                      mechanism.attachments[static_cast<std::size_t>(unknown.element)].name) != carried.end())
          take(ParameterOwner::attachment);
        break;
      case UnknownKind::disc_inertia: {
        const Disc& disc = mechanism.discs[static_cast<std::size_t>(unknown.element)];
        const VectorX factors = axial_inertia_factors(mechanism, disc);
        const int first = first_inertial_parameter(mechanism, ParameterOwner::disc, unknown.element);
        out.columns.col(k) << equation.inertial.middleCols(first, count) * factors,
            equation.frame.middleCols(first, count) * factors;
        break;
      }
      case UnknownKind::viscous: out.columns.col(k).head(n) = along() * equation.rates[unknown.element]; break;
      case UnknownKind::coulomb:
        out.columns.col(k).head(n) = along() * dry_direction(equation.rates[unknown.element], rest_rate);
        dry_coordinates.push_back(unknown.element);
        dry_effects.conservativeResize(Eigen::NoChange, dry_effects.cols() + 1);
        dry_effects.rightCols(1) = along();
        break;
      case UnknownKind::offset: out.columns.col(k).head(n) = along(); break;
    }
  }
  if (has_effort_rows(mechanism, static_cast<int>(n))) {
    numerics::CompleteOrthogonalDecomposition solver;
    solver.setThreshold(singular_input_threshold);
    solver.compute(equation.input);
    out.is_held = solver.rank() == n;
    out.columns.topRows(n) = solver.solve(MatrixX(out.columns.topRows(n)));
    out.known.head(n) = solver.solve(VectorX(out.known.head(n)));
    dry_effects = solver.solve(MatrixX(dry_effects));
    out.effort_map.setIdentity(n, n);
  }
  for (Eigen::Index row = 0; row < n; ++row)
    for (Eigen::Index k = 0; k < dry_effects.cols(); ++k)
      if (std::abs(dry_effects(row, k)) > 1e-6 * numerics::max_abs(dry_effects.col(k)))
        out.dry[static_cast<std::size_t>(row)].push_back(dry_coordinates[static_cast<std::size_t>(k)]);
  return out;
}

namespace {

/// Builds the channels of all records.
class RegressionBuilder {
 public:
  RegressionBuilder(MotionEquations& equations, const std::vector<UnknownParameter>& unknowns,
                    const std::vector<MeasurementRecord>& records, const SignalOptions& options)
      : equations_(equations),
        mechanism_(equations.mechanism()),
        unknowns_(unknowns),
        records_(records),
        options_(options),
        n_(equations.degrees_of_freedom()) {}

  Regression run() {
    list_channels();
    std::vector<std::vector<UniformPiece>> pieces;
    for (const MeasurementRecord& record : records_) {
      for (const std::string& note : record.notes) out_.notes.push_back(record.source + ": " + note);
      pieces.push_back(resample(record, out_.notes));
      if (pieces.back().empty()) throw RecordError(record.source + ": too few rows to identify anything");
    }
    choose_cutoff(pieces);
    for (std::size_t r = 0; r < records_.size(); ++r)
      for (const UniformPiece& piece : pieces[r]) add_piece(static_cast<int>(r), piece);
    for (const Channel& channel : out_.channels)
      if (channel.pieces.empty())
        throw RecordError(records_.front().source +
                          ": every piece of the record is shorter than what its filter needs");
    return std::move(out_);
  }

 private:
  bool efforts_are_rows() const { return has_effort_rows(mechanism_, n_); }

  void list_channels() {
    const MeasurementRecord& first = records_.front();
    using Kind = MeasuredSignal::Kind;
    const auto add = [&](Channel channel) { out_.channels.push_back(std::move(channel)); };
    if (efforts_are_rows()) {
      for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
        const int actuator = static_cast<int>(a);
        const CoordinateId coordinate = mechanism_.actuators[a];
        for (const Kind kind : {Kind::effort, Kind::current})
          if (find_signal(first, {kind, actuator}) >= 0) {
            add({.name = mechanism_.coordinates[coordinate].name,
                 .unit = is_length_coordinate(mechanism_, coordinate) ? "N" : "N m",
                 .signal = {kind, actuator},
                 .coordinate = coordinate,
                 .is_current = kind == Kind::current});
            break;
          }
      }
    } else if (mechanism_.actuators.empty() || has_any_effort(first)) {
      for (int k = 0; k < n_; ++k) {
        const CoordinateId coordinate = equations_.independent()[static_cast<std::size_t>(k)];
        add({.name = mechanism_.coordinates[coordinate].name,
             .unit = is_length_coordinate(mechanism_, coordinate) ? "N" : "N m",
             .signal = {Kind::effort, k},
             .coordinate = coordinate});
      }
      for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a)
        if (find_signal(first, {Kind::effort, static_cast<int>(a)}) < 0)
          throw RecordError(fmt::format(
              "{}: expected the efforts of all {} actuators, because they are not as many as the {}; "
              "that of '{}' is missing",
              first.source, mechanism_.actuators.size(), count_noun(n_, "degree of freedom", "degrees of freedom"),
              mechanism_.coordinates[mechanism_.actuators[a]].name));
    }
    const bool is_planar = mechanism_.space == SpaceKind::planar;
    const char* const planar[] = {"fx", "fy", "m"};
    const char* const spatial[] = {"fx", "fy", "fz", "mx", "my", "mz"};
    for (int row = 0; row < equations_.frame_rows(); ++row)
      if (find_signal(first, {Kind::frame, row}) >= 0)
        add({.name = std::string("frame ") + (is_planar ? planar[row] : spatial[row]),
             .unit = row < (is_planar ? 2 : 3) ? "N" : "N m",
             .signal = {Kind::frame, row}});
    if (out_.channels.empty())
      throw RecordError(first.source + ": no effort, current or force on the frame was measured");
  }

  static bool has_any_effort(const MeasurementRecord& record) {
    return std::any_of(record.signals.begin(), record.signals.end(),
                       [](const MeasuredSignal& signal) { return signal.kind == MeasuredSignal::Kind::effort; });
  }

  MatrixX positions_of(int record, const UniformPiece& piece) const {
    MatrixX positions(piece.values.rows(), n_);
    for (int k = 0; k < n_; ++k) positions.col(k) = piece.values.col(position_signal(record, k));
    return positions;
  }
  int position_signal(int record, int k) const {
    const CoordinateId coordinate = equations_.independent()[static_cast<std::size_t>(k)];
    const int signal =
        find_signal(records_[static_cast<std::size_t>(record)], {MeasuredSignal::Kind::position, coordinate});
    if (signal < 0)
      throw RecordError(fmt::format("{}: expected the position of '{}', which the other records have",
                                    records_[static_cast<std::size_t>(record)].source,
                                    mechanism_.coordinates[coordinate].name));
    return signal;
  }

  void choose_cutoff(const std::vector<std::vector<UniformPiece>>& pieces) {
    std::vector<MatrixX> positions;
    std::vector<double> steps;
    for (std::size_t r = 0; r < pieces.size(); ++r)
      for (const UniformPiece& piece : pieces[r]) {
        positions.push_back(positions_of(static_cast<int>(r), piece));
        steps.push_back(piece.step);
      }
    out_.cutoff = options_.cutoff > 0 ? options_.cutoff : simulation::find_cutoff(positions, steps, out_.notes);
    if (!(out_.cutoff > 0)) throw RecordError(records_.front().source + ": no joint moves in this record");
  }

  void add_piece(int record, const UniformPiece& piece) {
    const MeasurementRecord& source = records_[static_cast<std::size_t>(record)];
    MatrixX q = positions_of(record, piece), dq, ddq;
    ZeroPhaseFilter(simulation::position_cutoff_ratio * out_.cutoff, piece.step).apply(q);
    differentiate(q, piece.step, dq, ddq);
    compare_rates(record, piece, dq);
    const auto stride =
        std::max<Eigen::Index>(1, static_cast<Eigen::Index>(1 / (evaluation_ratio * out_.cutoff * piece.step)));
    const Eigen::Index samples = (q.rows() - 1) / stride + 1;
    const double step = piece.step * static_cast<double>(stride);
    const Eigen::Index edge = simulation::count_edge_samples(out_.cutoff, step);
    if (samples <= 2 * edge + 4) {
      out_.notes.push_back(
          fmt::format("{}: the piece of {:.4g} s from {:.6g} s is shorter than its filter needs and is left out",
                      source.source, piece.step * static_cast<double>(q.rows()), piece.start));
      return;
    }
    evaluate(record, piece, stride, q, dq, ddq);
    measure(source, piece, stride);
    ZeroPhaseFilter filter(out_.cutoff, step);
    filter.apply(columns_), filter.apply(known_);
    const auto decimation =
        std::max<Eigen::Index>(1, static_cast<Eigen::Index>(1 / (decimation_ratio * out_.cutoff * step)));
    store(record, piece, stride, {edge, samples - edge, decimation}, q, dq, ddq);
  }

  struct Decimation {
    Eigen::Index begin, end, step;
  };

  /// Regressors at every `stride`-th sample: columns_ has a block of columns per channel.
  void evaluate(int record, const UniformPiece& piece, Eigen::Index stride, const MatrixX& q, const MatrixX& dq,
                const MatrixX& ddq) {
    const MeasurementRecord& source = records_[static_cast<std::size_t>(record)];
    const VectorX known_values =
        known_inertial_values(mechanism_, equations_.inertial_values(), unknowns_, source.payloads);
    const auto U = static_cast<Eigen::Index>(unknowns_.size()), C = static_cast<Eigen::Index>(out_.channels.size());
    const Eigen::Index samples = (q.rows() - 1) / stride + 1;
    columns_.resize(samples, C * U);
    known_.resize(samples, C);
    rates_.resize(samples, static_cast<Eigen::Index>(mechanism_.coordinates.size()));
    dry_.assign(static_cast<std::size_t>(samples), {});
    effort_maps_.clear();
    MotionEquation equation;
    for (Eigen::Index k = 0; k < samples; ++k) {
      const Eigen::Index s = k * stride;
      const MotionOutcome outcome = equations_.evaluate(q.row(s).transpose(), dq.row(s).transpose(),
                                                        ddq.row(s).transpose(), piece.time(s), equation);
      if (outcome.status != MotionStatus::done)
        throw RecordError(
            fmt::format("{}: at {:.6g} s the mechanism cannot have the measured positions: {}; is a joint's "
                        "direction, zero or unit another one than in the spec, or its assembly?",
                        source.source, piece.time(s), outcome.reason));
      const RegressorRows rows =
          make_regressor_rows(mechanism_, equation, unknowns_, known_values, source.payloads, options_.rest_rate);
      if (!rows.is_held)
        throw RecordError(fmt::format(
            "{}: at {:.6g} s the actuators do not hold the mechanism, so that no effort says anything of it; "
            "leave that part out (--time) or measure along another motion",
            source.source, piece.time(s)));
      rates_.row(k) = equation.rates.transpose();
      for (Eigen::Index c = 0; c < C; ++c) {
        const Eigen::Index row = row_of(out_.channels[static_cast<std::size_t>(c)]);
        columns_.row(k).segment(c * U, U) = rows.columns.row(row);
        known_(k, c) = rows.known[row];
      }
      dry_[static_cast<std::size_t>(k)] = rows.dry;
      if (!efforts_are_rows()) effort_maps_.push_back(rows.effort_map);
    }
    if (!columns_.allFinite() || !known_.allFinite())
      throw RecordError(source.source + ": the motion is too fast for numbers of this machine");
  }

  Eigen::Index row_of(const Channel& channel) const {
    return channel.signal.kind == MeasuredSignal::Kind::frame ? n_ + channel.signal.index : channel.signal.index;
  }

  /// Filters what was measured at its own rate, then takes every `stride`-th sample.
  void measure(const MeasurementRecord& source, const UniformPiece& piece, Eigen::Index stride) {
    const Eigen::Index samples = (piece.values.rows() - 1) / stride + 1;
    measured_.resize(samples, static_cast<Eigen::Index>(out_.channels.size()));
    const ZeroPhaseFilter filter(out_.cutoff, piece.step);
    if (!efforts_are_rows() && out_.channels.front().coordinate >= 0) {
      MatrixX efforts(piece.values.rows(), static_cast<Eigen::Index>(mechanism_.actuators.size()));
      for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a)
        efforts.col(static_cast<Eigen::Index>(a)) =
            piece.values.col(require_signal(source, {MeasuredSignal::Kind::effort, static_cast<int>(a)}));
      for (Eigen::Index k = 0; k < samples; ++k)
        measured_.row(k).head(n_) =
            (effort_maps_[static_cast<std::size_t>(k)] * efforts.row(k * stride).transpose()).transpose();
      MatrixX generalised = measured_.leftCols(n_);
      ZeroPhaseFilter(out_.cutoff, piece.step * static_cast<double>(stride)).apply(generalised);
      measured_.leftCols(n_) = generalised;
    }
    for (std::size_t c = 0; c < out_.channels.size(); ++c) {
      if (!efforts_are_rows() && out_.channels[c].signal.kind != MeasuredSignal::Kind::frame) continue;
      MatrixX signal = piece.values.col(require_signal(source, out_.channels[c].signal));
      filter.apply(signal);
      for (Eigen::Index k = 0; k < samples; ++k) measured_(k, static_cast<Eigen::Index>(c)) = signal(k * stride, 0);
    }
  }

  int require_signal(const MeasurementRecord& record, MeasuredSignal signal) const {
    const int column = find_signal(record, signal);
    if (column < 0)
      throw RecordError(record.source +
                        ": lacks an effort or current that another record has; all records need the same");
    return column;
  }

  void store(int record, const UniformPiece& piece, Eigen::Index stride, const Decimation& rows, const MatrixX& q,
             const MatrixX& dq, const MatrixX& ddq) {
    const auto U = static_cast<Eigen::Index>(unknowns_.size());
    std::vector<Eigen::Index> kept;
    for (Eigen::Index k = rows.begin; k < rows.end; k += rows.step) kept.push_back(k);
    const auto count = static_cast<Eigen::Index>(kept.size());
    MeasuredStates states{record, VectorX(count), MatrixX(count, n_), MatrixX(count, n_), MatrixX(count, n_)};
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index s = kept[static_cast<std::size_t>(k)] * stride;
      states.time[k] = piece.time(s);
      states.q.row(k) = q.row(s), states.dq.row(k) = dq.row(s), states.ddq.row(k) = ddq.row(s);
    }
    MatrixX slope, curvature;
    differentiate(measured_, piece.step * static_cast<double>(stride), slope, curvature);
    for (std::size_t c = 0; c < out_.channels.size(); ++c) {
      Channel& channel = out_.channels[c];
      ChannelPiece part;
      part.record = record;
      part.step = piece.step * static_cast<double>(stride * rows.step);
      part.time = states.time;
      part.measured.resize(count), part.known.resize(count), part.slope.resize(count), part.rate.setZero(count);
      part.columns.resize(count, U);
      part.moving.assign(kept.size(), true), part.is_fitted.assign(kept.size(), true);
      for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index s = kept[static_cast<std::size_t>(k)];
        part.measured[k] = measured_(s, static_cast<Eigen::Index>(c));
        part.known[k] = known_(s, static_cast<Eigen::Index>(c));
        part.slope[k] = slope(s, static_cast<Eigen::Index>(c));
        part.columns.row(k) = columns_.row(s).segment(static_cast<Eigen::Index>(c) * U, U);
        if (channel.coordinate < 0) continue;
        part.rate[k] = rates_(s, channel.coordinate);
        const auto at_rest = [&](int coordinate) { return std::abs(rates_(s, coordinate)) <= options_.rest_rate; };
        part.moving[static_cast<std::size_t>(k)] = !at_rest(channel.coordinate);
        const std::vector<int>& dry = dry_[static_cast<std::size_t>(s)][static_cast<std::size_t>(row_of(channel))];
        part.is_fitted[static_cast<std::size_t>(k)] =
            part.moving[static_cast<std::size_t>(k)] && std::none_of(dry.begin(), dry.end(), at_rest);
      }
      channel.pieces.push_back(std::move(part));
    }
    out_.states.push_back(std::move(states));
  }

  /// Slope of the measured rates against those from the positions.
  void compare_rates(int record, const UniformPiece& piece, const MatrixX& dq) {
    for (int k = 0; k < n_; ++k) {
      const int signal =
          find_signal(records_[static_cast<std::size_t>(record)],
                      {MeasuredSignal::Kind::rate, equations_.independent()[static_cast<std::size_t>(k)]});
      if (signal < 0 || !(dq.col(k).squaredNorm() > 0)) continue;
      const double slope = piece.values.col(signal).dot(dq.col(k)) / dq.col(k).squaredNorm();
      if (std::abs(slope - 1) > 0.1)
        out_.notes.push_back(
            fmt::format("{}: the measured rate of {} is {:.3g} times that of its position: is one in another unit or "
                        "direction? Rates from positions are used",
                        records_[static_cast<std::size_t>(record)].source,
                        mechanism_.coordinates[equations_.independent()[static_cast<std::size_t>(k)]].name, slope));
    }
  }

  MotionEquations& equations_;
  const Mechanism& mechanism_;
  const std::vector<UnknownParameter>& unknowns_;
  const std::vector<MeasurementRecord>& records_;
  const SignalOptions& options_;
  const int n_;
  Regression out_;
  MatrixX columns_, known_, measured_, rates_;
  std::vector<std::vector<std::vector<int>>> dry_;  ///< per sample and row
  std::vector<MatrixX> effort_maps_;
};

}  // namespace

Regression build_regression(MotionEquations& equations, const std::vector<UnknownParameter>& unknowns,
                            const std::vector<MeasurementRecord>& records, const SignalOptions& options) {
  if (records.empty()) throw std::invalid_argument("expected at least one record");
  if (!(options.rest_rate > 0) || !(options.cutoff >= 0))
    throw std::invalid_argument("expected positive rates and frequencies");
  return RegressionBuilder(equations, unknowns, records, options).run();
}

}  // namespace balance::identification
