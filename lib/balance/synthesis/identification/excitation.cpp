#include "balance/synthesis/identification/excitation.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/synthesis/design/nlopt_search.hpp"
#include "balance/synthesis/identification/estimation.hpp"
#include "balance/synthesis/identification/excitation_model.hpp"
#include "balance/synthesis/identification/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::identification {

namespace {

/// Samples per period of the highest harmonic: of the search, of random series, and of the motion that is returned. Between
/// samples of the last a sine of that harmonic exceeds its largest sample by at most 1/2 (π/100)² = 5e-4 of it.
constexpr Eigen::Index search_density = 10, refined_density = 20, random_density = 30, final_density = 100;
/// The maximum of N scaled values is replaced by log(Σ exp(ρ v))/ρ, which is larger by at most log(N)/ρ.
constexpr double search_sharpness = 200, final_sharpness = 2000;
/// In the search dry friction grows up to this part of the largest rate, so that its columns change continuously.
constexpr double dry_rate_fraction = 0.5;
constexpr double search_bound = 20;  ///< of the scaled coefficients
constexpr double offset_fraction =
    0.4;  ///< random middles of a coordinate, in half ranges from the middle of its limits
constexpr double search_tolerance = 1e-5;       ///< relative change of scaled coefficients and of the objective
constexpr double feasibility_tolerance = 1e-9;  ///< part of a limit's range
constexpr double max_violation = 0.3, violation_cost = 2;  ///< of points of the search that are shrunk into the limits
constexpr double active_fraction = 0.02;                   ///< part of a limit's range that is left
constexpr int bisection_steps = 30, max_retreats = 6, max_random_failures = 20;
constexpr long max_random_evaluations = 500;  ///< motions tried for all random series together
/// Resolution of the common factor of amplitudes that brings a series into the limits.
constexpr double random_resolution = 0.02, final_resolution = 1e-4;
constexpr double max_growth = 1e6;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

}  // namespace

double ExcitationLimitUse::used() const {
  const double half = (limit.upper - limit.lower) / 2, middle = (limit.upper + limit.lower) / 2;
  return std::max(highest - middle, middle - lowest) / half;
}

namespace {

class ExcitationSearch {
 public:
  ExcitationSearch(const Mechanism& mechanism, const ExcitationOptions& options)
      : options_(options),
        model_(mechanism, options),
        random_(options.seed),
        start_time_(thread_cpu_time()),
        search_times_(times(search_density)),
        random_times_(times(random_density)),
        final_times_(times(final_density)) {
    for (const UnknownParameter& unknown : model_.unknowns()) groups_.push_back(column_group(unknown));
  }

  Excitation run() {
    find_rest_pose();
    draw_random_series();
    choose_noise();
    choose_base();
    rank_random_series();
    search();
    report();
    return std::move(out_);
  }

 private:
  struct Candidate {
    MatrixX coefficients;
    MatrixX information;  ///< of all unknowns, as excitation_information()
    double log_det = -std::numeric_limits<double>::infinity();
  };

  VectorX times(Eigen::Index density) const { return period_times(options_.period, density * options_.harmonics); }

  // Limits

  /// Largest excess over a limit, in half ranges; not positive if all are kept.
  double excess(const SampledMotion& motion) const {
    double worst = -std::numeric_limits<double>::infinity();
    for (std::size_t l = 0; l < model_.limits().size(); ++l) {
      const ExcitationLimit& limit = model_.limits()[l];
      const double half = (limit.upper - limit.lower) / 2;
      const auto values = motion.limited.col(static_cast<Eigen::Index>(l));
      worst = std::max({worst, (numerics::max_coefficient(values) - limit.upper) / half,
                        (limit.lower - numerics::min_coefficient(values)) / half});
    }
    if (model_.has_loops())
      worst = std::max(worst, (min_mobility_ - numerics::min_coefficient(motion.mobility)) / min_mobility_);
    return worst;
  }

  bool keeps_limits(const MatrixX& coefficients, const VectorX& at) {
    const auto motion = model_.sample(coefficients, at, options_.rest_rate);
    ++out_.evaluations;
    return motion && excess(*motion) <= feasibility_tolerance;
  }

  /// The amplitude about the middle, scaled for each coordinate to its own limits of position, rate and acceleration.
  /// @param can_grow false: only shrinks
  MatrixX scale_to_own_limits(MatrixX coefficients, const VectorX& at, bool can_grow) const {
    const MatrixX basis[] = {model_.motion().basis(at, 0), model_.motion().basis(at, 1), model_.motion().basis(at, 2)};
    const Eigen::Index J = coefficients.cols() - 1;
    for (Eigen::Index i = 0; i < coefficients.rows(); ++i) {
      double factor = can_grow ? max_growth : 1;
      for (const ExcitationLimit& limit : model_.limits()) {
        if (limit.kind == ExcitationLimit::Kind::effort || limit.index != independent(i)) continue;
        const int order = limit.kind == ExcitationLimit::Kind::position ? 0
                          : limit.kind == ExcitationLimit::Kind::rate   ? 1
                                                                        : 2;
        const VectorX values = basis[order].rightCols(J) * coefficients.row(i).tail(J).transpose();
        const double offset = order == 0 ? coefficients(i, 0) : 0;
        const double high = numerics::max_coefficient(values), low = numerics::min_coefficient(values);
        if (high > 0) factor = std::min(factor, std::max(0.0, limit.upper - offset) / high);
        if (low < 0) factor = std::min(factor, std::max(0.0, offset - limit.lower) / -low);
      }
      coefficients.row(i).tail(J) *= factor;
    }
    return coefficients;
  }

  CoordinateId independent(Eigen::Index i) const { return independent_[static_cast<std::size_t>(i)]; }

  /// The largest common factor of all amplitudes, at most 1, with which all limits are kept. None: not even at rest.
  std::optional<MatrixX> shrink_to_limits(const MatrixX& coefficients, const VectorX& at, double resolution) {
    if (keeps_limits(coefficients, at)) return coefficients;
    const auto scaled = [&](double factor) {
      MatrixX one = coefficients;
      one.rightCols(one.cols() - 1) *= factor;
      return one;
    };
    double kept = 0, missed = 1;
    for (int step = 0; step < bisection_steps && missed - kept > resolution; ++step) {
      // near 1 first: what a search returns is just beyond its limits
      const double factor = kept == 0 && step < 4 ? 1 - 0.004 * elementary::exp(1.5 * step) : (kept + missed) / 2;
      (keeps_limits(scaled(factor), at) ? kept : missed) = factor;
    }
    if (!(kept > 0)) return {};
    return scaled(kept);
  }

  // Random series

  /// A pose at rest within the limits, from which random series begin.
  void find_rest_pose() {
    independent_ = model_.equations().independent();
    rest_ = model_.start();
    MatrixX coefficients = MatrixX::Zero(rest_.size(), model_.motion().coefficient_count());
    coefficients.col(0) = rest_;
    const auto motion = model_.sample(coefficients, VectorX::Zero(1), options_.rest_rate);
    if (!motion)
      throw ExcitationError(
          "the mechanism cannot be assembled, or its actuators do not hold it, at the start: as in "
          "assembly, or in the middle of the limits of position");
    min_mobility_ = options_.min_mobility;
    if (!model_.has_loops()) return;
    if (!(motion->mobility[0] > min_mobility_))
      throw ExcitationError(
          fmt::format("the start is nearer to a singularity than the motion may come: its mobility is "
                      "{:.3g}, the least one {:.3g}",
                      motion->mobility[0], min_mobility_));
  }

  void draw_random_series() {
    const int n = model_.freedoms(), J = model_.motion().coefficient_count();
    const VectorX middle = model_.middle(), half = model_.half_range();
    int failures = 0;
    while (static_cast<int>(random_series_.size()) < options_.random_series && failures < max_random_failures) {
      if (is_out_of_time(0.5) || (out_.evaluations >= max_random_evaluations && !random_series_.empty())) break;
      MatrixX coefficients(n, J);
      for (int i = 0; i < n; ++i) coefficients.row(i) = random_.sample_normal(J).transpose();
      coefficients.rightCols(J - 1) = half.asDiagonal() * coefficients.rightCols(J - 1);
      const VectorX centre = middle + offset_fraction * half.cwiseProduct(random_.sample_point(n));
      std::optional<MatrixX> found;
      double distance = 1;
      for (int retreat = 0; retreat < max_retreats && !found; ++retreat, distance /= 2) {
        coefficients.col(0) = rest_ + distance * (centre - rest_);
        found =
            shrink_to_limits(scale_to_own_limits(coefficients, random_times_, true), random_times_, random_resolution);
      }
      if (found)
        random_series_.push_back({*found, {}});
      else
        ++failures;
    }
    if (random_series_.empty()) fail_without_motion();
  }

  [[noreturn]] void fail_without_motion() {
    MatrixX coefficients = MatrixX::Zero(rest_.size(), model_.motion().coefficient_count());
    coefficients.col(0) = rest_;
    std::vector<std::string> missed;
    if (const auto motion = model_.sample(coefficients, VectorX::Zero(1), options_.rest_rate))
      for (std::size_t l = 0; l < model_.limits().size(); ++l) {
        const ExcitationLimit& limit = model_.limits()[l];
        const double value = motion->limited(0, static_cast<Eigen::Index>(l));
        if (value > limit.upper || value < limit.lower) missed.push_back(name_of(limit));
      }
    throw ExcitationError(missed.empty() ? "no random series is within the limits, not even a slow one near the start"
                                         : fmt::format("limits are exceeded at rest at the start: {}",
                                                       join_with_conjunction(missed, "and")));
  }

  CoordinateId coordinate_of(const ExcitationLimit& limit) const {
    if (limit.kind != ExcitationLimit::Kind::effort) return limit.index;
    const Mechanism& mechanism = model_.mechanism();
    if (mechanism.actuators.empty()) return independent(limit.index);
    return mechanism.actuators[static_cast<std::size_t>(limit.index)];
  }

  std::string name_of(const ExcitationLimit& limit) const {
    const std::string& name = model_.mechanism().coordinates[coordinate_of(limit)].name;
    switch (limit.kind) {
      case ExcitationLimit::Kind::position: return name;
      case ExcitationLimit::Kind::rate: return name + ".rate";
      case ExcitationLimit::Kind::acceleration: return name + ".acceleration";
      case ExcitationLimit::Kind::effort: return name + ".effort";
    }
    return name;
  }

  std::string unit_of(const ExcitationLimit& limit) const {
    const bool is_length = is_length_coordinate(model_.mechanism(), coordinate_of(limit));
    switch (limit.kind) {
      case ExcitationLimit::Kind::position: return is_length ? "m" : "rad";
      case ExcitationLimit::Kind::rate: return is_length ? "m/s" : "rad/s";
      case ExcitationLimit::Kind::acceleration: return is_length ? "m/s^2" : "rad/s^2";
      case ExcitationLimit::Kind::effort: return is_length ? "N" : "N m";
    }
    return "";
  }

  /// Deviations of the channels, the same for all motions.
  void choose_noise() {
    const auto C = static_cast<Eigen::Index>(model_.channels().size());
    VectorX peak = VectorX::Zero(C), fastest = VectorX::Zero(1);
    for (const Candidate& candidate : random_series_)
      if (const auto motion = model_.sample(candidate.coefficients, search_times_, options_.rest_rate)) {
        for (Eigen::Index c = 0; c < C; ++c)
          peak[c] = std::max(peak[c], numerics::max_abs(VectorX(motion->measured.col(c))));
        fastest[0] += numerics::max_abs(MatrixX(motion->dq)) / static_cast<double>(random_series_.size());
      }
    const double largest = numerics::max_abs(peak);
    if (!(largest > 0)) throw ExcitationError("no motion needs an effort: there is nothing to measure");
    VectorX noise_deviations(C);
    double smallest = largest;
    for (const double value : peak)
      if (value > negligible_column * largest) smallest = std::min(smallest, value);
    for (Eigen::Index c = 0; c < C; ++c) {
      const auto index = static_cast<std::size_t>(c);
      const bool is_given = index < options_.noise_deviations.size() && options_.noise_deviations[index] > 0;
      // a channel that measures nothing, such as a drive whose spec lacks its inertia, has the noise of the smallest one
      noise_deviations[c] =
          is_given ? options_.noise_deviations[index]
                   : options_.relative_noise * (peak[c] > negligible_column * largest ? peak[c] : smallest);
      out_.channels.push_back(
          {model_.channels()[index].name, model_.channels()[index].unit, noise_deviations[c], is_given});
    }
    model_.set_noise(noise_deviations);
    dry_rate_ = std::max(options_.rest_rate, dry_rate_fraction * fastest[0]);
  }

  // Information

  /// @param is_masked rows of joints at rest are left out
  MatrixX information_of(const SampledMotion& motion, bool is_masked) const {
    const auto U = static_cast<Eigen::Index>(model_.unknowns().size());
    MatrixX sum = MatrixX::Zero(U, U);
    const double samples = options_.sampling_rate * options_.period * options_.periods;
    for (std::size_t s = 0; s < motion.columns.size(); ++s) {
      MatrixX columns = motion.columns[s];
      for (Eigen::Index c = 0; c < columns.rows(); ++c)
        if (is_masked && !motion.is_fitted[s][static_cast<std::size_t>(c)]) columns.row(c).setZero();
      sum.noalias() += columns.transpose() * columns;
    }
    return samples / static_cast<double>(motion.columns.size()) * sum;
  }

  MatrixX of_base(const MatrixX& information, const BaseCombinations& base) const {
    MatrixX part(base.rank(), base.rank());
    for (Eigen::Index i = 0; i < part.rows(); ++i)
      for (Eigen::Index j = 0; j < part.cols(); ++j)
        part(i, j) = information(base.base[static_cast<std::size_t>(i)], base.base[static_cast<std::size_t>(j)]);
    return part;
  }

  /// log det, by columns scaled to norm 1; −∞ if the motion does not show all of the base.
  static double log_det_of(const MatrixX& information, VectorX* scale = nullptr, MatrixX* inverse = nullptr) {
    const VectorX norms = information.diagonal().cwiseMax(0).cwiseSqrt();
    constexpr double nothing = -std::numeric_limits<double>::infinity();
    if (!norms.allFinite() || !(numerics::min_coefficient(norms) > 0)) return nothing;
    const VectorX inverse_norms = norms.cwiseInverse();
    const Eigen::LLT<MatrixX> factor(MatrixX(inverse_norms.asDiagonal() * information * inverse_norms.asDiagonal()));
    if (factor.info() != Eigen::Success) return nothing;
    double log_det = 0;
    for (Eigen::Index k = 0; k < norms.size(); ++k)
      log_det += 2 * (elementary::log(factor.matrixLLT()(k, k)) + elementary::log(norms[k]));
    if (scale != nullptr) *scale = inverse_norms;
    if (inverse != nullptr) *inverse = factor.solve(MatrixX::Identity(norms.size(), norms.size()));
    return std::isfinite(log_det) ? log_det : nothing;
  }

  /// Of columns of norm 1, without what the motion does not show.
  static double condition_of(const MatrixX& information) {
    const VectorX norms = information.diagonal().cwiseMax(0).cwiseSqrt();
    const VectorX scale = norms.unaryExpr([](double norm) { return norm > 0 ? 1 / norm : 0; });
    const numerics::SymmetricEigenSolver eigen(MatrixX(scale.asDiagonal() * information * scale.asDiagonal()),
                                               Eigen::EigenvaluesOnly);
    const VectorX sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
    const double largest = numerics::max_abs(sigma);
    for (Eigen::Index k = 0; k < sigma.size(); ++k)
      if (sigma[k] > excitation_threshold * largest) return largest / sigma[k];
    return std::numeric_limits<double>::infinity();
  }

  /// Rows whose squares are the information.
  static MatrixX square_root(const MatrixX& information) {
    const numerics::SymmetricEigenSolver eigen(information);
    return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  }

  /// The columns that identify() would choose for a record of this motion.
  BaseCombinations base_for(const MatrixX& information) {
    MatrixX rows = square_root(information);
    ProbeRows probes = probes_;
    clear_negligible_columns(model_.unknowns(), probes, rows);
    return find_base_combinations(rows, probes.measured, groups_);
  }

  void choose_base() {
    std::vector<MeasuredStates> states;
    for (Candidate& candidate : random_series_) {
      const auto motion = model_.sample(candidate.coefficients, random_times_, options_.rest_rate);
      if (!motion) throw ExcitationError("a random series left the limits");
      candidate.information = information_of(*motion, true);
      states.push_back({0, random_times_, motion->q, motion->dq, motion->ddq});
    }
    MeasurementRecord record;
    record.payloads = model_.payloads();
    probes_ = probe(model_.equations(), model_.unknowns(), model_.channels(), states, {record}, options_.seed);
    base_ = base_for(random_series_.front().information);
    if (base_.rank() == 0) throw ExcitationError("no effort depends on any unknown");
  }

  void rank_random_series() {
    for (Candidate& candidate : random_series_) candidate.log_det = log_det_of(of_base(candidate.information, base_));
    std::stable_sort(random_series_.begin(), random_series_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.log_det > b.log_det; });
    if (!std::isfinite(random_series_.front().log_det))
      throw ExcitationError(
          "no random series within the limits shows all base parameters: the limits leave too little "
          "motion, or the harmonics are too few");
    best_ = random_series_.front();
  }

  // Search

  double elapsed() const { return thread_cpu_time() - start_time_; }
  bool is_out_of_time(double fraction) const {
    return options_.max_time > 0 && elapsed() > fraction * options_.max_time;
  }
  bool has_evaluations_left() const {
    return options_.max_evaluations == 0 || search_evaluations_ < options_.max_evaluations;
  }

  bool should_stop() {
    if (is_interrupted_ || !options_.on_progress) return is_interrupted_;
    double fraction = options_.max_time > 0 ? elapsed() / options_.max_time : 0;
    if (options_.max_evaluations > 0)
      fraction = std::max(fraction, static_cast<double>(search_evaluations_) / options_.max_evaluations);
    return is_interrupted_ = !options_.on_progress(std::min(fraction, 1.0));
  }

  /// Coefficients of scaled variables: the middle in half ranges, amplitudes in those of the start.
  struct Scaling {
    VectorX middle, half, amplitude;

    MatrixX coefficients(const VectorX& u, Eigen::Index J) const {
      MatrixX out(middle.size(), J);
      for (Eigen::Index i = 0; i < middle.size(); ++i) {
        out.row(i) = amplitude[i] * u.segment(i * J, J).transpose();
        out(i, 0) = middle[i] + half[i] * u[i * J];
      }
      return out;
    }
    VectorX variables(const MatrixX& coefficients) const {
      const Eigen::Index J = coefficients.cols();
      VectorX u(coefficients.size());
      for (Eigen::Index i = 0; i < middle.size(); ++i) {
        u.segment(i * J, J) = coefficients.row(i).transpose() / amplitude[i];
        u[i * J] = (coefficients(i, 0) - middle[i]) / half[i];
      }
      return u;
    }
    double factor(Eigen::Index i, Eigen::Index j) const { return j == 0 ? half[i] : amplitude[i]; }
  };

  /// Objective and limits at one point, which NLopt asks for one after the other.
  struct Point {
    VectorX u;
    double objective = std::numeric_limits<double>::quiet_NaN();
    VectorX gradient, margins;  ///< margins: per limit and of the mobility, positive if kept
    MatrixX jacobian;
    bool has_slopes = false;
  };

  Eigen::Index margin_count() const {
    return static_cast<Eigen::Index>(model_.limits().size()) + (model_.has_loops() ? 1 : 0);
  }

  /// Smooth maximum of the samples' values, with its derivatives: a weight per sample.
  double smooth_max(const VectorX& values, VectorX& weights) const {
    const double largest = numerics::max_coefficient(values);
    weights = values.unaryExpr([&](double v) { return elementary::exp(sharpness_ * (v - largest)); });
    const double sum = weights.sum();
    weights /= sum;
    return largest + elementary::log(sum) / sharpness_;
  }

  void evaluate(const Scaling& scaling, const VectorX& u, bool needs_slopes, Point& point) {
    if (point.u.size() == u.size() && point.u == u && (point.has_slopes || !needs_slopes)) return;
    const Eigen::Index n = model_.freedoms(), J = model_.motion().coefficient_count(), S = search_times_.size();
    point = {};
    point.u = u;
    point.has_slopes = needs_slopes;
    point.gradient.setZero(u.size());
    point.margins.setConstant(margin_count(), std::numeric_limits<double>::quiet_NaN());
    point.jacobian.setZero(margin_count(), u.size());
    ++search_evaluations_;
    ++out_.evaluations;
    const auto motion = model_.sample(scaling.coefficients(u, J), search_times_, dry_rate_);
    if (!motion) return;
    const auto L = static_cast<Eigen::Index>(model_.limits().size());
    // per margin and sample: weight of the upper bound minus that of the lower one, per half range
    MatrixX pull(margin_count(), S);
    for (Eigen::Index l = 0; l < margin_count(); ++l) {
      VectorX values(2 * S), weights;
      if (l < L) {
        const ExcitationLimit& limit = model_.limits()[static_cast<std::size_t>(l)];
        const double half = (limit.upper - limit.lower) / 2;
        values.head(S) = (motion->limited.col(l).array() - limit.upper) / half;
        values.tail(S) = (limit.lower - motion->limited.col(l).array()) / half;
        point.margins[l] = -smooth_max(values, weights);
        pull.row(l) = (weights.head(S) - weights.tail(S)).transpose() / half;
      } else {
        const VectorX lacking = (min_mobility_ - motion->mobility.array()) / min_mobility_;
        point.margins[l] = -smooth_max(lacking, weights);
        pull.row(l) = -weights.transpose() / min_mobility_;
      }
    }
    VectorX scale;
    MatrixX inverse;
    const double size = 2 * static_cast<double>(base_.rank());
    const MatrixX information = of_base(information_of(*motion, false), base_);
    const double log_det = log_det_of(information, &scale, &inverse);
    if (!std::isfinite(log_det)) return;
    point.objective = -log_det / size;
    if (!needs_slopes) return;
    // d log det = tr(M⁻¹ dM), M = w Σ YᵀY: 2 w Σ ⟨Y M⁻¹, dY⟩
    inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
    const double weight = 2 * options_.sampling_rate * options_.period * options_.periods / static_cast<double>(S);
    const MatrixX basis[] = {model_.motion().basis(search_times_, 0), model_.motion().basis(search_times_, 1),
                             model_.motion().basis(search_times_, 2)};
    for (Eigen::Index s = 0; s < S; ++s) {
      const MatrixX& columns = motion->columns[static_cast<std::size_t>(s)];
      const MatrixX weighted = weight * base_columns(columns, base_) * inverse;
      MatrixX factors = MatrixX::Zero(columns.rows(), columns.cols());
      for (std::size_t k = 0; k < base_.base.size(); ++k)
        factors.col(base_.base[k]) = weighted.col(static_cast<Eigen::Index>(k));
      const auto slopes = model_.differentiate(*motion, s, search_times_, dry_rate_, factors);
      if (!slopes) {
        point.objective = std::numeric_limits<double>::quiet_NaN();
        return;
      }
      for (int order = 0; order < 3; ++order)
        for (Eigen::Index i = 0; i < n; ++i) {
          const Eigen::Index k = order * n + i;
          const auto add = [&](auto&& row, double slope) {
            if (slope == 0) return;
            for (Eigen::Index j = 0; j < J; ++j) row[i * J + j] += slope * basis[order](s, j) * scaling.factor(i, j);
          };
          add(point.gradient, -slopes->information[k] / size);
          for (Eigen::Index l = 0; l < L; ++l)
            if (pull(l, s) != 0) add(point.jacobian.row(l), -pull(l, s) * slopes->limited(l, k));
          if (model_.has_loops() && order == 0) add(point.jacobian.row(L), -pull(L, s) * slopes->mobility[i]);
        }
    }
  }

  void search() {
    const int starts = std::min<int>(options_.starts, static_cast<int>(random_series_.size()));
    for (int k = 0; k < starts && !is_out_of_time(1) && has_evaluations_left() && !should_stop(); ++k) {
      const Candidate& start = random_series_[static_cast<std::size_t>(k)];
      if (!std::isfinite(start.log_det)) break;
      search_from(start.coefficients, starts - k + 1);
      ++out_.local_searches;
    }
    if (is_improved_ && !is_out_of_time(1) && has_evaluations_left() && !should_stop()) {  // nearer to the limits
      search_times_ = times(refined_density);
      sharpness_ = final_sharpness;
      search_from(MatrixX(best_.coefficients), 1);
    }
    out_.is_time_exhausted = is_out_of_time(1) && has_evaluations_left();
  }

  void search_from(const MatrixX& start, int searches_left) {
    const Eigen::Index n = start.rows(), J = start.cols();
    Scaling scaling{model_.middle(), model_.half_range(), VectorX(n)};
    for (Eigen::Index i = 0; i < n; ++i)
      scaling.amplitude[i] = std::max(1e-3 * scaling.half[i], numerics::max_abs(VectorX(start.row(i).tail(J - 1))));
    Point point;
    VectorX best_u;
    double best_merit = std::numeric_limits<double>::infinity();
    // what exceeds its limits is shrunk into them, which costs about as much of the mean logarithm of the columns
    const auto consider = [&] {
      const double violation = std::max(0.0, -numerics::min_coefficient(point.margins));
      const double merit = point.objective + violation_cost * violation;
      if (!(violation <= max_violation) || !(merit < best_merit)) return;
      best_merit = merit, best_u = point.u;
    };
    design::NonlinearProgram program;
    program.size = static_cast<int>(n * J);
    program.bound = search_bound;
    program.inequality_count = static_cast<int>(margin_count());
    program.objective = [&](const VectorX& u, VectorX* gradient) {
      evaluate(scaling, u, gradient != nullptr, point);
      consider();
      if (gradient != nullptr) *gradient = point.gradient;
      return point.objective;
    };
    program.inequalities = [&](const VectorX& u, VectorX& values, MatrixX* jacobian) {
      evaluate(scaling, u, jacobian != nullptr, point);
      values = point.margins;
      if (jacobian != nullptr) *jacobian = point.jacobian;
    };
    design::StoppingCriteria stopping;
    stopping.relative_tolerance = search_tolerance;
    stopping.max_evaluations = options_.max_evaluations > 0
                                   ? std::max(1, (options_.max_evaluations - search_evaluations_) / searches_left)
                                   : 1'000'000;
    if (options_.max_time > 0) stopping.max_time = std::max(1e-3, (options_.max_time - elapsed()) / searches_left);
    stopping.stop = [this] { return should_stop(); };
    design::search_locally(search_method, program, scaling.variables(start), stopping);
    if (best_u.size() == 0) return;
    const auto found = shrink_to_limits(scale_to_own_limits(scaling.coefficients(best_u, J), final_times_, false),
                                        final_times_, final_resolution);
    if (!found) return;
    const auto motion = model_.sample(*found, final_times_, options_.rest_rate);
    if (!motion) return;
    Candidate candidate{*found, information_of(*motion, true)};
    candidate.log_det = log_det_of(of_base(candidate.information, base_));
    if (candidate.log_det > best_.log_det) best_ = std::move(candidate), is_improved_ = true;
  }
  static constexpr const char* search_method = "slsqp";

  // Report

  void report() {
    if (!is_improved_) {  // the best random series, on the fine grid
      const auto kept = shrink_to_limits(scale_to_own_limits(best_.coefficients, final_times_, false), final_times_,
                                         final_resolution);
      if (!kept) fail_without_motion();
      best_.coefficients = *kept;
    }
    const auto motion = model_.sample(best_.coefficients, final_times_, options_.rest_rate);
    if (!motion) throw ExcitationError("the motion that was found left the limits");
    best_.information = information_of(*motion, true);
    out_.motion = model_.motion();
    out_.periods = options_.periods;
    out_.coordinates = independent_;
    out_.coefficients = best_.coefficients;
    out_.has_loops = model_.has_loops();
    out_.random_series = static_cast<int>(random_series_.size());
    if (out_.has_loops) out_.min_mobility = numerics::min_coefficient(motion->mobility);
    base_ = base_for(best_.information);
    report_channels(*motion);
    report_limits(*motion);
    report_parameters();
    report_hidden();
  }

  void report_channels(const SampledMotion& motion) {
    const auto S = static_cast<double>(motion.columns.size());
    for (std::size_t c = 0; c < out_.channels.size(); ++c) {
      const VectorX measured = motion.measured.col(static_cast<Eigen::Index>(c));
      out_.channels[c].rms = measured.norm() / std::sqrt(S);
      out_.channels[c].peak = numerics::max_abs(measured);
      long moving = 0;
      for (Eigen::Index s = 0; s < motion.channel_rates.rows(); ++s)
        moving += model_.channels()[c].coordinate < 0 ||
                  std::abs(motion.channel_rates(s, static_cast<Eigen::Index>(c))) > options_.rest_rate;
      out_.channels[c].moving_share = static_cast<double>(moving) / S;
    }
  }

  void report_limits(const SampledMotion& motion) {
    for (std::size_t l = 0; l < model_.limits().size(); ++l) {
      const VectorX values = motion.limited.col(static_cast<Eigen::Index>(l));
      ExcitationLimitUse use{model_.limits()[l],
                             name_of(model_.limits()[l]),
                             unit_of(model_.limits()[l]),
                             numerics::min_coefficient(values),
                             numerics::max_coefficient(values),
                             model_.is_limit_given()[l]};
      use.is_active = use.used() > 1 - active_fraction;
      out_.limits.push_back(std::move(use));
    }
  }

  VectorX deviations(const MatrixX& information) const {
    VectorX scale;
    MatrixX inverse;
    if (!std::isfinite(log_det_of(of_base(information, base_), &scale, &inverse)))
      return VectorX::Constant(base_.rank(), std::numeric_limits<double>::quiet_NaN());
    return inverse.diagonal().cwiseMax(0).cwiseSqrt().cwiseProduct(scale);
  }

  void report_parameters() {
    const MatrixX information = of_base(best_.information, base_);
    out_.found = {log_det_of(information), condition_of(information)};
    std::vector<double> log_dets, conditions;
    for (const Candidate& candidate : random_series_) {
      log_dets.push_back(log_det_of(of_base(candidate.information, base_)));
      conditions.push_back(condition_of(of_base(candidate.information, base_for(candidate.information))));
    }
    out_.median_random = {median(log_dets), median(conditions)};
    out_.start = {log_dets.front(), conditions.front()};
    const Candidate& middle = random_series_[random_series_.size() / 2];
    const VectorX expected = deviations(best_.information), random = deviations(middle.information);
    // as estimate() decides what a motion shows
    const VectorX scale = information.diagonal().cwiseSqrt().cwiseInverse();
    const numerics::SymmetricEigenSolver eigen(MatrixX(scale.asDiagonal() * information * scale.asDiagonal()));
    const VectorX sigma = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
    Eigen::Index hidden = 0;
    while (hidden < sigma.size() && !(sigma[hidden] > excitation_threshold * numerics::max_abs(sigma))) ++hidden;
    const VectorX values = base_.evaluate(model_.spec_values());
    for (Eigen::Index k = 0; k < base_.rank(); ++k) {
      const UnknownParameter& unknown =
          model_.unknowns()[static_cast<std::size_t>(base_.base[static_cast<std::size_t>(k)])];
      ExcitedParameter one;
      one.parameter = {.name = unknown.name,
                       .unit = unknown.unit,
                       .value = values[k],
                       .deviation = expected[k],
                       .spec_value = values[k]};
      for (std::size_t j = 0; j < base_.rest.size(); ++j)
        if (const double factor = base_.factors(k, static_cast<Eigen::Index>(j)); factor != 0)
          one.parameter.others.emplace_back(base_.rest[j], factor);
      one.parameter.is_found = eigen.eigenvectors().row(k).head(hidden).squaredNorm() <= hidden_share_tolerance;
      one.random_deviation = random[k];
      out_.found_rank += one.parameter.is_found ? 1 : 0;
      out_.base.push_back(std::move(one));
    }
    out_.structural_rank = static_cast<int>(base_.rank());
    report_unknowns();
  }

  void report_unknowns() {
    for (std::size_t k = 0; k < model_.unknowns().size(); ++k) {
      UnknownReport report{model_.unknowns()[k]};
      const auto in_base = std::find(base_.base.begin(), base_.base.end(), static_cast<int>(k));
      if (in_base != base_.base.end()) {
        const BaseParameter& parameter = out_.base[static_cast<std::size_t>(in_base - base_.base.begin())].parameter;
        report.determination = !parameter.is_found        ? Determination::not_excited
                               : parameter.others.empty() ? Determination::determined
                                                          : Determination::combined;
      } else {
        const auto rest = std::find(base_.rest.begin(), base_.rest.end(), static_cast<int>(k)) - base_.rest.begin();
        report.determination = base_.factors.col(rest).isZero(0) ? Determination::nowhere : Determination::combined;
      }
      out_.unknowns.push_back(std::move(report));
    }
  }

  /// Combinations that shake the frame and that no effort shows, whatever the motion.
  void report_hidden() {
    const auto add = [&](const char* name, const char* unit, const MatrixX& rows) {
      DerivedFigure figure;
      figure.name = name, figure.unit = unit;
      const MatrixX combinations = find_missing_combinations(rows, base_, groups_);
      for (Eigen::Index k = 0; k < combinations.rows(); ++k) {
        std::vector<std::pair<int, double>> one;
        for (Eigen::Index p = 0; p < combinations.cols(); ++p)
          if (combinations(k, p) != 0) one.emplace_back(static_cast<int>(p), combinations(k, p));
        figure.missing.push_back(std::move(one));
      }
      out_.figures.push_back(std::move(figure));
    };
    add("shaking_force", "N", probes_.shaking_force);
    add("shaking_moment", "N m", probes_.shaking_moment);
  }

  const ExcitationOptions& options_;
  ExcitationModel model_;
  numerics::UniformRandom random_;
  double start_time_;
  VectorX search_times_;
  const VectorX random_times_, final_times_;
  double sharpness_ = search_sharpness;
  std::vector<CoordinateId> independent_;
  std::vector<int> groups_;
  VectorX rest_;
  double min_mobility_ = 0, dry_rate_ = 0;
  std::vector<Candidate> random_series_;
  ProbeRows probes_;
  BaseCombinations base_;
  Candidate best_;
  int search_evaluations_ = 0;
  bool is_interrupted_ = false, is_improved_ = false;
  Excitation out_;
};

void check(const ExcitationOptions& options) {
  if (options.periods < 1 || options.random_series < 1 || options.starts < 1 || !(options.sampling_rate > 0) ||
      !(options.min_mobility > 0) || !(options.rest_rate > 0) || !(options.relative_noise > 0) ||
      options.max_evaluations < 0 || !(options.max_time >= 0))
    throw std::invalid_argument("expected positive numbers");
  if (options.max_evaluations == 0 && options.max_time == 0)
    throw std::invalid_argument("expected a limit of time or evaluations");
  for (const ExcitationLimit& limit : options.limits)
    if (!(limit.lower < limit.upper) || !std::isfinite(limit.upper - limit.lower))
      throw std::invalid_argument("expected limits with lower < upper");
}

}  // namespace

Excitation find_excitation(const Mechanism& mechanism, const ExcitationOptions& options) {
  check(options);
  return ExcitationSearch(mechanism, options).run();
}

}  // namespace balance::identification
