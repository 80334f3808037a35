#include "balance/synthesis/identification/diagnosis.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace balance::identification {

namespace {

/// Records that fit as well as this are not questioned, but for delays.
constexpr double questionable_residual = 0.12;
/// Another reading is reported if its residual is at most this part of that as read.
constexpr double convincing_ratio = 0.6;
/// A delay is looked for if its linear estimate promises a residual of at most this part, and reported if it is.
constexpr double promising_delay_ratio = 0.93, convincing_delay_ratio = 0.9;
constexpr int max_delay_steps = 4;
constexpr double max_delay = 0.5;  ///< [s]

class Diagnosis {
 public:
  explicit Diagnosis(const DiagnosisInput& input) : in_(input) {}

  std::vector<Suspicion> run() {
    if (in_.estimate.relative_residual > questionable_residual) {
      try_other_efforts();
      if (out_.empty()) try_other_positions();
    }
    if (out_.empty()) try_delay();
    std::sort(out_.begin(), out_.end(), [](const Suspicion& a, const Suspicion& b) { return a.residual < b.residual; });
    return std::move(out_);
  }

 private:
  const Channel& channel(std::size_t c) const { return in_.regression.channels[c]; }
  const char* what(std::size_t c) const { return channel(c).is_current ? "current" : "effort"; }

  void report(const std::string& text, double residual, double ratio = convincing_ratio) {
    if (residual <= ratio * in_.estimate.relative_residual)
      out_.push_back({text, residual, in_.estimate.relative_residual});
  }

  double residual_of(const std::vector<Reading>& readings) const {
    return estimate(in_.regression.channels, in_.compressed, in_.base, in_.spec, in_.gains, readings).relative_residual;
  }

  void try_other_efforts() {
    const std::size_t C = in_.regression.channels.size();
    std::vector<Reading> as_read;
    for (std::size_t c = 0; c < C; ++c) as_read.push_back({c, 1});
    for (std::size_t a = 0; a < C; ++a) {
      std::vector<Reading> reversed = as_read;
      reversed[a].factor = -1;
      report(fmt::format("the {} of {} seems to be reversed", what(a), channel(a).name), residual_of(reversed));
      for (std::size_t b = a + 1; b < C; ++b) {
        if (channel(a).coordinate < 0 || channel(b).coordinate < 0) continue;
        std::vector<Reading> swapped = as_read;
        std::swap(swapped[a], swapped[b]);
        report(fmt::format("the {}s of {} and {} seem to be swapped", what(a), channel(a).name, channel(b).name),
               residual_of(swapped));
      }
    }
  }

  /// The residual if the records are changed; infinite if the mechanism cannot make such a motion.
  double residual_with(const std::function<void(MeasurementRecord&)>& change) const {
    std::vector<MeasurementRecord> records = in_.records;
    for (MeasurementRecord& record : records) change(record);
    try {
      const Regression regression =
          build_regression(in_.equations, in_.unknowns, records, {.cutoff = in_.regression.cutoff});
      return estimate(regression.channels, compress(regression.channels), in_.base, in_.spec, in_.gains)
          .relative_residual;
    } catch (const RecordError&) {
      return INFINITY;
    }
  }

  void try_other_positions() {
    using Kind = MeasuredSignal::Kind;
    const Mechanism& mechanism = in_.equations.mechanism();
    const auto scale = [](MeasurementRecord& record, Kind kind, int index, double factor) {
      if (const int column = find_signal(record, {kind, index}); column >= 0) record.values.col(column) *= factor;
    };
    report("the positions seem to be in degrees, not in radians", residual_with([&](MeasurementRecord& record) {
             for (const CoordinateId c : in_.equations.independent())
               if (!is_length_coordinate(mechanism, c)) scale(record, Kind::position, c, std::numbers::pi / 180);
           }));
    for (const CoordinateId c : in_.equations.independent()) {
      const std::string& name = mechanism.coordinates[c].name;
      report(fmt::format("the position of {} seems to be reversed", name),
             residual_with([&](MeasurementRecord& record) { scale(record, Kind::position, c, -1); }));
      const auto actuator = std::find(mechanism.actuators.begin(), mechanism.actuators.end(), c);
      if (actuator == mechanism.actuators.end()) continue;
      report(fmt::format("position and effort of {} seem to be reversed", name),
             residual_with([&](MeasurementRecord& record) {
               scale(record, Kind::position, c, -1);
               for (const Kind kind : {Kind::effort, Kind::current})
                 scale(record, kind, static_cast<int>(actuator - mechanism.actuators.begin()), -1);
             }));
    }
  }

  /// Efforts that are read `delay` later than they were measured.
  static void shift_efforts(MeasurementRecord& record, double delay) {
    for (std::size_t s = 0; s < record.signals.size(); ++s) {
      if (record.signals[s].kind == MeasuredSignal::Kind::position ||
          record.signals[s].kind == MeasuredSignal::Kind::rate)
        continue;
      const VectorX values = record.values.col(static_cast<Eigen::Index>(s));
      Eigen::Index k = 0;
      for (Eigen::Index row = 0; row < values.size(); ++row) {
        const double at = record.time[row] + delay;
        while (k > 0 && record.time[k] > at) --k;
        while (k + 2 < values.size() && record.time[k + 1] < at) ++k;
        const double weight = std::clamp((at - record.time[k]) / (record.time[k + 1] - record.time[k]), 0.0, 1.0);
        record.values(row, static_cast<Eigen::Index>(s)) = values[k] + weight * (values[k + 1] - values[k]);
      }
    }
  }

  /// The delay of a linear model, measured + delay · slope ≈ fit, and the residual that it promises, relative to that
  /// without a delay.
  static std::pair<double, double> estimate_delay(const std::vector<Channel>& channels, const BaseCombinations& base,
                                                  const Estimate& found) {
    const Eigen::Index B = base.rank();
    MatrixX normal = MatrixX::Zero(B + 1, B + 1);
    VectorX right = VectorX::Zero(B + 1);
    double square = 0;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto i = static_cast<Eigen::Index>(c);
      for (const ChannelPiece& piece : channels[c].pieces) {
        const MatrixX columns = base_columns(piece.columns, base);
        MatrixX jacobian(piece.measured.size(), B + 1);
        jacobian.leftCols(B) = found.kappa[i] * columns;
        jacobian.col(B) = -piece.slope;
        jacobian /= found.residual_rms[i];
        VectorX residual =
            (piece.measured - found.kappa[i] * (columns * found.beta + piece.known)) / found.residual_rms[i];
        for (Eigen::Index k = 0; k < residual.size(); ++k)
          if (!piece.is_fitted[static_cast<std::size_t>(k)]) residual[k] = 0, jacobian.row(k).setZero();
        normal += jacobian.transpose() * jacobian;
        right += jacobian.transpose() * residual;
        square += residual.squaredNorm();
      }
    }
    VectorX scale = normal.diagonal().cwiseSqrt();
    for (double& one : scale) one = one > 0 ? 1 / one : 0;
    const numerics::CompleteOrthogonalDecomposition solver(MatrixX(scale.asDiagonal() * normal * scale.asDiagonal()));
    const VectorX solution = scale.cwiseProduct(solver.solve(VectorX(scale.cwiseProduct(right))));
    return {solution[B], square > 0 ? std::sqrt(std::max(0.0, 1 - solution.dot(right) / square)) : 1};
  }

  struct Shifted {
    Regression regression;
    Estimate estimate;
  };

  /// The fit with efforts that are read `delay` later; none if the records are too short.
  std::optional<Shifted> fit_shifted(double delay) const {
    std::vector<MeasurementRecord> records = in_.records;
    for (MeasurementRecord& record : records) shift_efforts(record, delay);
    try {
      Shifted shifted{build_regression(in_.equations, in_.unknowns, records, {.cutoff = in_.regression.cutoff}), {}};
      shifted.estimate =
          estimate(shifted.regression.channels, compress(shifted.regression.channels), in_.base, in_.spec, in_.gains);
      return shifted;
    } catch (const RecordError&) {
      return {};
    }
  }

  /// A linear model finds small delays; for large ones, some are tried first.
  void try_delay() {
    double delay = 0;
    std::optional<Shifted> best;
    if (in_.estimate.relative_residual > questionable_residual)
      for (const double start : {-0.2, -0.1, -0.05, 0.05, 0.1, 0.2}) {
        std::optional<Shifted> shifted = fit_shifted(start);
        const double residual = best ? best->estimate.relative_residual : in_.estimate.relative_residual;
        if (shifted && shifted->estimate.relative_residual < residual) best = std::move(shifted), delay = start;
      }
    for (int step = 0; step < max_delay_steps; ++step) {
      const auto [correction, ratio] = best ? estimate_delay(best->regression.channels, in_.base, best->estimate)
                                            : estimate_delay(in_.regression.channels, in_.base, in_.estimate);
      if (!best && ratio > promising_delay_ratio) return;
      if (!(std::abs(delay + correction) <= max_delay)) break;
      std::optional<Shifted> shifted = fit_shifted(delay + correction);
      if (!shifted || (best && shifted->estimate.relative_residual >= best->estimate.relative_residual)) break;
      best = std::move(shifted);
      delay += correction;
      if (std::abs(correction) < 0.01 * std::abs(delay)) break;
    }
    if (!best) return;
    report(fmt::format("the efforts seem to {} the positions by {:.3g} ms", delay > 0 ? "lag behind" : "be ahead of",
                       std::abs(delay) * 1e3),
           best->estimate.relative_residual, convincing_delay_ratio);
  }

  const DiagnosisInput& in_;
  std::vector<Suspicion> out_;
};

}  // namespace

std::vector<Suspicion> diagnose(const DiagnosisInput& input) { return Diagnosis(input).run(); }

}  // namespace balance::identification
