#include "balance/synthesis/design/trajectory_cost.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/force_regressor.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/synthesis/design/row_space.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace balance::design {

/// Peak, mean and range of a quantity over the samples, as functions of a few coordinates.
class SampledFigures {
 public:
  /// @param components of the quantity: 1 for scalars, whose range refers to the signed value
  SampledFigures(Eigen::Index sample_count, Eigen::Index components, Eigen::Index coordinates);

  /// @param matrix components × coordinates: the quantity at this sample per unit of each coordinate
  /// @param weight in the time average
  void set_sample(Eigen::Index sample, const MatrixX& matrix, double weight);

  /// @param z coordinates
  /// @param gradient with respect to z, if not null; at a kink, a one-sided one
  double peak(const VectorX& z, VectorX* gradient) const;
  double mean(const VectorX& z, VectorX* gradient) const;
  double range(const VectorX& z, VectorX* gradient) const;
  /// The largest signed value or magnitude, or the smallest.
  double extreme(const VectorX& z, bool is_maximum, VectorX* gradient) const;

 private:
  MatrixX values(const VectorX& z) const;
  void add_gradient(Eigen::Index sample, const MatrixX& values, double factor, VectorX& gradient) const;

  Eigen::Index sample_count_, components_;
  MatrixX matrices_;  ///< by component, then by sample
  VectorX weights_;
};

/// Figures of one scalar or vector along a trajectory.
struct CostSeries {
  RowSpace space;                         ///< of the parameters followed by a 1
  std::optional<SampledFigures> samples;  ///< needed for figures other than rms

  /// @param gradient with respect to the parameters, if not null; must have their size
  double figure(Statistic figure, const VectorX& parameters, VectorX* gradient) const;

 private:
  VectorX coordinates(const VectorX& parameters) const;
};

/// The maximum of a figure over several series (of minima the minimum), with the gradient of that one.
/// @param series at least one
CostFunction make_worst_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index parameters);

// Time averages by the trapezoidal rule, computed sample by sample.

/// Passes on the rows of each sample with their weight: the time that the sample represents [s], known one sample
/// later.
template <class Add>
class TrapezoidalAverage {
 public:
  /// @param add called with rows and weight, in order
  explicit TrapezoidalAverage(Add add) : add_(std::move(add)) {}

  /// @param rows swapped with the internal storage
  void add_sample(double time, MatrixX& rows) {
    if (has_sample_) {
      add_(rows_, (step_ + time - time_) / 2);
      step_ = time - time_;
    }
    has_sample_ = true;
    time_ = time;
    rows_.swap(rows);
  }

  /// Passes on the last sample.
  void finish() { add_(rows_, step_ / 2); }

 private:
  Add add_;
  bool has_sample_ = false;
  double time_ = 0, step_ = 0;
  MatrixX rows_;
};

double AffineFigure::operator()(const VectorX& parameters) const {
  if (coefficients.size() > 0) return coefficients.dot(parameters.head(coefficients.size()));
  double worst = figure == Statistic::maximum ? -std::numeric_limits<double>::infinity() : 0;
  for (const AffineSeries& one : series) {
    const VectorX values = one.rows * parameters;
    if (figure == Statistic::maximum) {
      worst = std::max(worst, numerics::max_coefficient(values));
      continue;
    }
    const auto sizes = values.reshaped(one.components, one.time_weights.size()).colwise().norm();
    worst = std::max(worst, figure == Statistic::peak ? numerics::max_abs(sizes)
                                                      : std::sqrt(sizes.cwiseAbs2().dot(one.time_weights.transpose())));
  }
  return worst;
}

SampledFigures::SampledFigures(Eigen::Index sample_count, Eigen::Index components, Eigen::Index coordinates)
    : sample_count_(sample_count),
      components_(components),
      matrices_(sample_count * components, coordinates),
      weights_(sample_count) {}

void SampledFigures::set_sample(Eigen::Index sample, const MatrixX& matrix, double weight) {
  for (Eigen::Index c = 0; c < components_; ++c) matrices_.row(c * sample_count_ + sample) = matrix.row(c);
  weights_[sample] = weight;
}

/// samples × components.
MatrixX SampledFigures::values(const VectorX& z) const {
  MatrixX out(sample_count_, components_);
  Eigen::Map<VectorX>(out.data(), out.size()).noalias() = matrices_ * z;
  return out;
}

/// Adds factor times the gradient of the magnitude at a sample.
void SampledFigures::add_gradient(Eigen::Index sample, const MatrixX& values, double factor, VectorX& gradient) const {
  const double magnitude = values.row(sample).norm();
  if (magnitude == 0) return;
  for (Eigen::Index c = 0; c < components_; ++c)
    gradient += factor * values(sample, c) / magnitude * matrices_.row(c * sample_count_ + sample).transpose();
}

double SampledFigures::peak(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const Eigen::Index sample = numerics::max_index(all.rowwise().squaredNorm());
  const double peak = all.row(sample).norm();
  if (gradient) {
    gradient->setZero(z.size());
    add_gradient(sample, all, 1, *gradient);
  }
  return peak;
}

double SampledFigures::mean(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const VectorX magnitude = all.rowwise().norm();
  if (gradient) {
    const VectorX factor = (magnitude.array() > 0).select(weights_.array() / magnitude.array().max(1e-300), 0).matrix();
    gradient->setZero(z.size());
    for (Eigen::Index c = 0; c < components_; ++c)
      *gradient += matrices_.middleRows(c * sample_count_, sample_count_).transpose() * factor.cwiseProduct(all.col(c));
  }
  return weights_.dot(magnitude);
}

double SampledFigures::range(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const bool scalar = components_ == 1;
  const VectorX value = scalar ? VectorX(all.col(0)) : VectorX(all.rowwise().norm());
  const Eigen::Index low = numerics::min_index(value), high = numerics::max_index(value);
  const double range = value[high] - value[low];
  if (gradient) {
    gradient->setZero(z.size());
    if (scalar) {
      *gradient = (matrices_.row(high) - matrices_.row(low)).transpose();
    } else {
      add_gradient(high, all, 1, *gradient);
      add_gradient(low, all, -1, *gradient);
    }
  }
  return range;
}

double SampledFigures::extreme(const VectorX& z, bool is_maximum, VectorX* gradient) const {
  const MatrixX all = values(z);
  const VectorX value = components_ == 1 ? VectorX(all.col(0)) : VectorX(all.rowwise().norm());
  const Eigen::Index sample = is_maximum ? numerics::max_index(value) : numerics::min_index(value);
  if (gradient && components_ == 1) *gradient = matrices_.row(sample).transpose();
  if (gradient && components_ > 1) {
    gradient->setZero(z.size());
    add_gradient(sample, all, 1, *gradient);
  }
  return value[sample];
}

/// L (parameters, 1).
VectorX CostSeries::coordinates(const VectorX& parameters) const {
  const std::vector<Eigen::Index>& active = space.active();
  VectorX x(static_cast<Eigen::Index>(active.size()));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const Eigen::Index column = active[static_cast<std::size_t>(k)];
    x[k] = column < parameters.size() ? parameters[column] : 1;
  }
  return space.coordinates() * x;
}

namespace {

double rms(const VectorX& z, VectorX* slope) {
  const double rms = z.norm();
  if (slope) *slope = rms > 0 ? VectorX(z / rms) : VectorX(VectorX::Zero(z.size()));
  return rms;
}

double figure_of_coordinates(const CostSeries& series, Statistic figure, const VectorX& z, VectorX* slope) {
  switch (figure) {
    case Statistic::peak: return series.samples->peak(z, slope);
    case Statistic::mean: return series.samples->mean(z, slope);
    case Statistic::range: return series.samples->range(z, slope);
    case Statistic::maximum: return series.samples->extreme(z, true, slope);
    case Statistic::minimum: return series.samples->extreme(z, false, slope);
    case Statistic::rms: break;
  }
  return rms(z, slope);
}

}  // namespace

double CostSeries::figure(Statistic figure, const VectorX& parameters, VectorX* gradient) const {
  VectorX slope;
  const double value = figure_of_coordinates(*this, figure, coordinates(parameters), gradient ? &slope : nullptr);
  if (!gradient) return value;
  const VectorX active = space.coordinates().transpose() * slope;
  gradient->setZero(parameters.size());
  for (Eigen::Index k = 0; k < active.size(); ++k) {
    const Eigen::Index column = space.active()[static_cast<std::size_t>(k)];
    if (column < gradient->size()) (*gradient)[column] = active[k];
  }
  return value;
}

CostFunction make_worst_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index count) {
  const auto shared_series = std::make_shared<const std::vector<CostSeries>>(std::move(series));
  return [shared_series, figure, count](const VectorX& parameters, VectorX* gradient) {
    if (parameters.size() != count) throw std::invalid_argument("not as many values as there are parameters");
    double worst = shared_series->front().figure(figure, parameters, gradient);
    VectorX series_gradient;
    for (std::size_t s = 1; s < shared_series->size(); ++s) {
      const double value = (*shared_series)[s].figure(figure, parameters, gradient ? &series_gradient : nullptr);
      if (figure == Statistic::minimum ? value >= worst : value <= worst) continue;
      worst = value;
      if (gradient) gradient->swap(series_gradient);
    }
    return worst;
  };
}

namespace {

/// Interface to figures of planar and spatial mechanisms.
struct FigureSource {
  virtual ~FigureSource() = default;
  virtual const MotionOutcome& outcome() = 0;
  virtual std::optional<CostFunction> figure(Statistic figure, const std::string& name) = 0;
  virtual std::vector<std::optional<std::vector<AffineSeries>>> rows(const std::vector<std::string>& names) = 0;
};

template <class S>
class FixedMotion : public FigureSource {
 public:
  FixedMotion(const Mechanism& mechanism, const Trajectory& trajectory, const dynamics::FreeSprings& loose)
      : mechanism_(mechanism), trajectory_(trajectory), loose_(loose), motion_(mechanism_, trajectory_) {
    set_units();
  }

  const MotionOutcome& outcome() override {
    if (!is_traversed_) collect({}, [](std::size_t, const MatrixX&, double) {});
    return outcome_;
  }

  std::optional<CostFunction> figure(Statistic figure, const std::string& name) override {
    const std::optional<dynamics::AffineQuantity> quantity = dynamics::find_affine_quantity(mechanism_, name);
    if (!quantity || is_impossible()) return std::nullopt;
    std::vector<CostSeries> series;
    std::vector<SequentialQr> factors = triangles(*quantity);
    if (is_impossible()) return std::nullopt;
    for (SequentialQr& qr : factors) series.push_back({RowSpace(qr.triangle(), units_), std::nullopt});
    if (figure != Statistic::rms) store_samples(*quantity, series);
    return make_worst_cost(figure, std::move(series), units_.scale.size() - 1);
  }

  std::vector<std::optional<std::vector<AffineSeries>>> rows(const std::vector<std::string>& names) override {
    std::vector<std::optional<std::vector<AffineSeries>>> all(names.size());
    std::vector<dynamics::AffineQuantity> quantities;
    std::vector<std::size_t> position;  // of each of them among the names
    for (std::size_t q = 0; q < names.size(); ++q)
      if (const std::optional<dynamics::AffineQuantity> quantity =
              dynamics::find_affine_quantity(mechanism_, names[q])) {
        quantities.push_back(*quantity);
        position.push_back(q);
        all[q].emplace(series_count(*quantity));
      }
    if (is_impossible()) return std::vector<std::optional<std::vector<AffineSeries>>>(names.size());
    std::vector<Eigen::Index> samples(quantities.size(), 0);
    collect(quantities, [&](std::size_t q, const MatrixX& rows, double weight) {
      append_sample(rows, weight, samples[q]++, *all[position[q]]);
    });
    if (is_impossible()) return std::vector<std::optional<std::vector<AffineSeries>>>(names.size());
    for (const std::size_t q : position)
      for (AffineSeries& one : *all[q]) {
        one.rows.conservativeResize(sample_count_ * one.components, Eigen::NoChange);
        one.time_weights.conservativeResize(sample_count_);
      }
    return all;
  }

 private:
  /// Units: kilograms for inertial parameters, newtons per metre for springs, 1 for the constant.
  void set_units() {
    const std::vector<dynamics::Parameter> parameters = dynamics::list_parameters(mechanism_, loose_);
    const auto count = static_cast<Eigen::Index>(parameters.size());
    units_.scale.setOnes(count + 1);
    for (Eigen::Index p = 0; p < count; ++p)
      units_.scale[p] =
          elementary::pow(motion_.tree.characteristic_length, parameters[static_cast<std::size_t>(p)].length_power);
    const Eigen::Index inertial =
        S::inertial_parameter_count * static_cast<Eigen::Index>(motion_.tree.mass_elements.size());
    units_.families = {0, inertial, count};
  }

  /// Calls visit() for every sample and for every side of a jump without a coincident sample: the points of the time
  /// averages, evaluated.
  /// @return false if the motion ends early
  template <class Visit>
  bool visit_samples(dynamics::TreeMotionSource<S>& source, Visit&& visit) const {
    return source.outcome().status == MotionStatus::done &&
           visit_time_grid(source, trajectory_.samples, [&](const trajectory::TimeGridPoint& point) {
             if (point.kind == trajectory::TimeGridPoint::Kind::after_jump && point.has_coincident_next) return true;
             if (!source.evaluate()) return false;
             visit();
             return true;
           });
  }

  /// Whether it is known that the mechanism cannot follow the trajectory.
  bool is_impossible() const { return is_traversed_ && outcome_.status != MotionStatus::done; }

  /// Evaluates quantities along the whole motion, and determines its outcome.
  /// @param add called for each sample and quantity with the number of the quantity, its rows and their weight in the
  /// average
  template <class Add>
  void collect(const std::vector<dynamics::AffineQuantity>& quantities, Add add) {
    const bool needs_velocities =
        std::any_of(quantities.begin(), quantities.end(), [](const dynamics::AffineQuantity& quantity) {
          return quantity.kind == dynamics::AffineQuantity::Kind::kinetic_energy;  // of all origins
        });
    dynamics::TreeMotionSource<S> source(mechanism_, motion_, trajectory_.about,
                                         needs_velocities ? dynamics::Detail::all : dynamics::Detail::forces);
    Eigen::Index sample_count = 0;
    bool is_complete = false;
    if (source.outcome().status == MotionStatus::done) {
      dynamics::ForceRegressor<S> forces(mechanism_, source.tree(), motion_.plan.freedoms, trajectory_.about, loose_);
      const double duration = source.prescribed_motion().duration();
      const auto make_average = [&](std::size_t q) {
        return [&add, q, duration](const MatrixX& rows, double weight) { add(q, rows, weight / duration); };
      };
      std::vector<TrapezoidalAverage<decltype(make_average(0))>> averages;
      for (std::size_t q = 0; q < quantities.size(); ++q) averages.emplace_back(make_average(q));
      std::vector<MatrixX> rows(quantities.size());
      is_complete = visit_samples(source, [&] {
        ++sample_count;
        for (std::size_t q = 0; q < quantities.size(); ++q) {
          forces.evaluate(source.stepper(), quantities[q], rows[q]);
          zero_absent_payloads(source.payloads(), rows[q]);
          averages[q].add_sample(source.time(), rows[q]);
        }
      });
      if (is_complete)
        for (auto& average : averages) average.finish();
    }
    if (is_traversed_) return;
    is_traversed_ = true;
    sample_count_ = sample_count;
    outcome_ = is_complete ? source.completed_outcome() : source.outcome();
  }

  /// @param sample its number, from 0
  /// @param series storage grows as needed
  void append_sample(const MatrixX& rows, double weight, Eigen::Index sample, std::vector<AffineSeries>& series) const {
    const Eigen::Index rows_per_series = rows.rows() / static_cast<Eigen::Index>(series.size());
    for (std::size_t s = 0; s < series.size(); ++s) {
      AffineSeries& one = series[s];
      one.components = rows_per_series;
      if (sample == one.time_weights.size()) {
        const Eigen::Index capacity =
            std::max<Eigen::Index>({trajectory_.samples, trajectory::min_time_steps + 1, 2 * sample});
        one.rows.conservativeResize(capacity * rows_per_series, rows.cols());
        one.time_weights.conservativeResize(capacity);
      }
      one.rows.middleRows(sample * rows_per_series, rows_per_series) =
          rows.middleRows(static_cast<Eigen::Index>(s) * rows_per_series, rows_per_series);
      one.time_weights[sample] = weight;
    }
  }

  /// Zeroes the columns of payloads that are not attached.
  void zero_absent_payloads(const kinematics::TreePayloads<S>& loads, MatrixX& rows) const {
    for (std::size_t e = 0; e < motion_.tree.mass_elements.size(); ++e)
      if (!loads.is_attached(e, loads.current_interval()))
        rows.middleCols(S::inertial_parameter_count * static_cast<Eigen::Index>(e), S::inertial_parameter_count)
            .setZero();
  }

  std::size_t series_count(const dynamics::AffineQuantity& quantity) const {
    return dynamics::count_parts(mechanism_, quantity, motion_.plan.freedoms);
  }

  std::vector<SequentialQr> triangles(const dynamics::AffineQuantity& quantity) {
    std::vector<SequentialQr> factors(series_count(quantity), SequentialQr(units_.scale.size()));
    collect({quantity}, [&](std::size_t, const MatrixX& rows, double weight) {
      const Eigen::Index rows_per_series = rows.rows() / static_cast<Eigen::Index>(factors.size());
      for (std::size_t s = 0; s < factors.size(); ++s)
        factors[s].add(rows.middleRows(static_cast<Eigen::Index>(s) * rows_per_series, rows_per_series), weight);
    });
    return factors;
  }

  /// Second pass along the motion, because all samples of all parameters would take too much memory.
  void store_samples(const dynamics::AffineQuantity& quantity, std::vector<CostSeries>& series) {
    Eigen::Index sample = 0;
    collect({quantity}, [&](std::size_t, const MatrixX& rows, double weight) {
      const Eigen::Index rows_per_series = rows.rows() / static_cast<Eigen::Index>(series.size());
      for (std::size_t s = 0; s < series.size(); ++s) {
        CostSeries& one = series[s];
        if (!one.samples) one.samples.emplace(sample_count_, rows_per_series, one.space.rank());
        one.samples->set_sample(
            sample,
            one.space.to_coordinates(rows.middleRows(static_cast<Eigen::Index>(s) * rows_per_series, rows_per_series)),
            weight);
      }
      ++sample;
    });
  }

  Mechanism mechanism_;
  Trajectory trajectory_;
  dynamics::FreeSprings loose_;
  kinematics::CompiledMotion<S> motion_;
  ColumnScales units_;
  // determined by the first pass along the motion
  bool is_traversed_ = false;
  MotionOutcome outcome_;
  Eigen::Index sample_count_ = 0;
};

}  // namespace

struct TrajectoryCost::Implementation {
  std::unique_ptr<FigureSource> source;
};

TrajectoryCost::TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory,
                               const dynamics::FreeSprings& loose) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  std::unique_ptr<FigureSource> source;
  kinematics::dispatch_space(
      mechanism.space, [&]<class S>(S) { source = std::make_unique<FixedMotion<S>>(mechanism, trajectory, loose); });
  implementation_ = std::make_shared<const Implementation>(Implementation{std::move(source)});
}

TrajectoryCost::~TrajectoryCost() = default;
TrajectoryCost::TrajectoryCost(TrajectoryCost&&) noexcept = default;
TrajectoryCost& TrajectoryCost::operator=(TrajectoryCost&&) noexcept = default;

const MotionOutcome& TrajectoryCost::outcome() const { return implementation_->source->outcome(); }

std::optional<CostFunction> TrajectoryCost::figure(Statistic figure, const std::string& quantity) const {
  return implementation_->source->figure(figure, quantity);
}

std::vector<std::optional<std::vector<AffineSeries>>> TrajectoryCost::rows(
    const std::vector<std::string>& quantities) const {
  return implementation_->source->rows(quantities);
}

bool is_linear_quantity(const Mechanism& mechanism, const std::string& quantity) {
  return dynamics::find_affine_quantity(mechanism, quantity).has_value();
}

bool is_mass_dependent(const Trajectory& trajectory) {
  return trajectory.drive == DriveKind::com || trajectory.from.com || trajectory.to.com;
}

}  // namespace balance::design
