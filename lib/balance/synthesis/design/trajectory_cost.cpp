#include "balance/synthesis/design/trajectory_cost.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/tree_payloads.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/synthesis/design/force_regressor.hpp"
#include "balance/synthesis/design/row_space.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace balance {

/// One motion as often as it is wanted, place by place in the order of time.
template <class S>
class MotionReplay {
 public:
  /// @param tree as compiled; the run works on a copy
  /// @param plan done
  MotionReplay(const Mechanism& mechanism, const Trajectory& trajectory, const Tree<S>& tree,
               const CompiledTrajectory<S>& plan)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        plan_(plan),
        tree_(tree),
        observer_(mechanism, tree_, plan.freedoms, to_vector<S>(trajectory.about)),
        stepper_(mechanism, tree_, plan),
        loads_(mechanism, tree, plan.prescribed_motion->duration()) {
    stepper_.set_regularity_monitor(observer_.regularity_monitor());
  }
  MotionReplay(const MotionReplay&) = delete;
  MotionReplay& operator=(const MotionReplay&) = delete;

  const Tree<S>& tree() const { return tree_; }
  /// What is there at the place that was seen last.
  const TreePayloads<S>& loads() const { return loads_; }

  /// Calls see(stepper) once for every place of the walk and every side of a jump that no other place holds: the places that
  /// averages are taken over. The stepper's state is that of the place.
  template <class See>
  MotionOutcome run(Detail detail, See&& see) {
    const Actuation<S>& actuation = observer_.actuation();
    if (!actuation.mismatch().empty()) return {MotionStatus::mismatch, 0, actuation.mismatch(), {}};
    bool holds = true;
    loads_.apply(0, tree_);
    const bool done =
        visit_time_grid(stepper_, *plan_.prescribed_motion, trajectory_.samples, [&](const TimeGridPoint& stop) {
          if (stop.kind == TimeGridPoint::Kind::after_jump) loads_.apply(stepper_.time(), tree_);
          if (stop.kind == TimeGridPoint::Kind::after_jump && stop.has_coincident_next) return true;
          holds = observer_.evaluate(stepper_, detail);
          if (holds) see(stepper_);
          return holds;
        });
    if (!holds)
      return make_actuation_singularity_outcome(stepper_.time(), format_configuration(mechanism_, tree_, stepper_.y()));
    if (!done) return stepper_.outcome();
    return {MotionStatus::done, plan_.prescribed_motion->duration(), "", actuation.notes()};
  }

 private:
  const Mechanism& mechanism_;
  const Trajectory& trajectory_;
  const CompiledTrajectory<S>& plan_;
  Tree<S> tree_;
  SampleEvaluator<S> observer_;
  MotionStepper<S> stepper_;
  TreePayloads<S> loads_;
};

/// Peak, mean and range of a quantity over the samples, as functions of few coordinates.
class SampledFigures {
 public:
  /// @param components of the quantity: 1 for scalars, whose range is that of the signed value
  SampledFigures(Eigen::Index places, Eigen::Index components, Eigen::Index coordinates);

  /// @param matrix components × coordinates: the quantity at this place per unit of each
  /// @param weight share of the time average
  void set_sample(Eigen::Index place, const MatrixX& matrix, double weight);

  /// @param z coordinates
  /// @param gradient with respect to z, if not null; where the figure has a corner, that of one side
  double peak(const VectorX& z, VectorX* gradient) const;
  double mean(const VectorX& z, VectorX* gradient) const;
  double range(const VectorX& z, VectorX* gradient) const;

 private:
  MatrixX values(const VectorX& z) const;
  void add_gradient(Eigen::Index place, const MatrixX& values, double factor, VectorX& gradient) const;

  Eigen::Index places_, components_;
  MatrixX matrices_;  ///< component by component, the places one after another
  VectorX weights_;
};

/// Figures of one scalar or vector along a trajectory, and of the worst of several.
struct CostSeries {
  RowSpace space;                         ///< of the parameters and a one behind them
  std::optional<SampledFigures> samples;  ///< needed for figures other than rms

  /// @param gradient with respect to the parameters, if not null; it has their size
  double figure(Statistic figure, const VectorX& parameters, VectorX* gradient) const;

 private:
  VectorX coordinates(const VectorX& parameters) const;
};

/// The largest figure of several series, with the gradient of that one.
/// @param series at least one
CostFunction make_max_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index parameters);

// Time averages by the trapezoidal rule, of what comes place by place.

/// Hands every place's rows on with their weight, the time that they stand for [s], which is known one place later.
template <class Add>
class TrapezoidalAverage {
 public:
  /// @param add called with rows and weight, in order
  explicit TrapezoidalAverage(Add add) : add_(std::move(add)) {}

  /// @param rows taken over, and given other memory in exchange
  void add_sample(double time, MatrixX& rows) {
    if (any_) {
      add_(rows_, (step_ + time - time_) / 2);
      step_ = time - time_;
    }
    any_ = true;
    time_ = time;
    rows_.swap(rows);
  }

  /// The last place's.
  void finish() { add_(rows_, step_ / 2); }

 private:
  Add add_;
  bool any_ = false;
  double time_ = 0, step_ = 0;
  MatrixX rows_;
};

double AffineFigure::operator()(const VectorX& parameters) const {
  if (coefficients.size() > 0) return coefficients.dot(parameters.head(coefficients.size()));
  double worst = 0;
  for (const AffineSeries& one : series) {
    const VectorX values = one.rows * parameters;
    const auto sizes = values.reshaped(one.components, one.time_weights.size()).colwise().norm();
    worst = std::max(worst, figure == Statistic::peak ? max_abs(sizes)
                                                      : std::sqrt(sizes.cwiseAbs2().dot(one.time_weights.transpose())));
  }
  return worst;
}

SampledFigures::SampledFigures(Eigen::Index places, Eigen::Index components, Eigen::Index coordinates)
    : places_(places), components_(components), matrices_(places * components, coordinates), weights_(places) {}

void SampledFigures::set_sample(Eigen::Index place, const MatrixX& matrix, double weight) {
  for (Eigen::Index c = 0; c < components_; ++c) matrices_.row(c * places_ + place) = matrix.row(c);
  weights_[place] = weight;
}

/// places × components.
MatrixX SampledFigures::values(const VectorX& z) const {
  MatrixX out(places_, components_);
  Eigen::Map<VectorX>(out.data(), out.size()).noalias() = matrices_ * z;
  return out;
}

/// Adds factor times the gradient of the magnitude at a place.
void SampledFigures::add_gradient(Eigen::Index place, const MatrixX& values, double factor, VectorX& gradient) const {
  const double magnitude = values.row(place).norm();
  if (magnitude == 0) return;
  for (Eigen::Index c = 0; c < components_; ++c)
    gradient += factor * values(place, c) / magnitude * matrices_.row(c * places_ + place).transpose();
}

double SampledFigures::peak(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const Eigen::Index place = max_index(all.rowwise().squaredNorm());
  const double peak = all.row(place).norm();
  if (gradient) {
    gradient->setZero(z.size());
    add_gradient(place, all, 1, *gradient);
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
      *gradient += matrices_.middleRows(c * places_, places_).transpose() * factor.cwiseProduct(all.col(c));
  }
  return weights_.dot(magnitude);
}

double SampledFigures::range(const VectorX& z, VectorX* gradient) const {
  const MatrixX all = values(z);
  const bool scalar = components_ == 1;
  const VectorX value = scalar ? VectorX(all.col(0)) : VectorX(all.rowwise().norm());
  const Eigen::Index low = min_index(value), high = max_index(value);
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

CostFunction make_max_cost(Statistic figure, std::vector<CostSeries> series, Eigen::Index count) {
  const auto shared = std::make_shared<const std::vector<CostSeries>>(std::move(series));
  return [shared, figure, count](const VectorX& parameters, VectorX* gradient) {
    if (parameters.size() != count) throw std::invalid_argument("not as many values as there are parameters");
    double worst = shared->front().figure(figure, parameters, gradient);
    VectorX other;
    for (std::size_t s = 1; s < shared->size(); ++s) {
      const double value = (*shared)[s].figure(figure, parameters, gradient ? &other : nullptr);
      if (value <= worst) continue;
      worst = value;
      if (gradient) gradient->swap(other);
    }
    return worst;
  };
}

namespace {

/// Where figures come from, in plane or space.
struct FigureSource {
  MotionOutcome outcome;

  virtual ~FigureSource() = default;
  virtual std::optional<CostFunction> figure(Statistic figure, const std::string& name) const = 0;
  virtual std::optional<std::vector<AffineSeries>> rows(const std::string& name) const = 0;
};

template <class S>
class FixedMotion : public FigureSource {
 public:
  FixedMotion(const Mechanism& mechanism, const Trajectory& trajectory, const FreeSprings& loose)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        loose_(loose),
        tree_(compile_tree<S>(mechanism_, prescribed_coordinates(trajectory_))),
        plan_(compile_trajectory(mechanism_, tree_, trajectory_)) {
    outcome = plan_.outcome;
    if (outcome.status != MotionStatus::done) return;
    outcome = MotionReplay<S>(mechanism_, trajectory_, tree_, plan_).run(Detail::forces, [&](auto&) { ++places_; });
    if (outcome.status == MotionStatus::done) set_units();
  }

  std::optional<CostFunction> figure(Statistic figure, const std::string& name) const override {
    const std::optional<CostQuantity> quantity = find_cost_quantity(mechanism_, name);
    if (outcome.status != MotionStatus::done || !quantity) return std::nullopt;
    std::vector<CostSeries> series;
    for (SequentialQr& triangle : triangles(*quantity))
      series.push_back({RowSpace(triangle.triangle(), units_), std::nullopt});
    if (figure != Statistic::rms) store_samples(*quantity, series);
    return make_max_cost(figure, std::move(series), units_.scale.size() - 1);
  }

  std::optional<std::vector<AffineSeries>> rows(const std::string& name) const override {
    const std::optional<CostQuantity> quantity = find_cost_quantity(mechanism_, name);
    if (outcome.status != MotionStatus::done || !quantity) return std::nullopt;
    std::vector<AffineSeries> series(series_count(*quantity));
    Eigen::Index place = 0;
    collect(*quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(series.size());
      for (std::size_t s = 0; s < series.size(); ++s) {
        AffineSeries& one = series[s];
        if (place == 0) one = {MatrixX(places_ * each, rows.cols()), each, VectorX(places_)};
        one.rows.middleRows(place * each, each) = rows.middleRows(static_cast<Eigen::Index>(s) * each, each);
        one.time_weights[place] = weight;
      }
      ++place;
    });
    return series;
  }

 private:
  /// Inertial parameters in kilograms, those of springs in newtons per metre, the one as it is.
  void set_units() {
    const std::vector<Parameter> parameters = list_parameters(mechanism_, loose_);
    const auto count = static_cast<Eigen::Index>(parameters.size());
    units_.scale.setOnes(count + 1);
    for (Eigen::Index p = 0; p < count; ++p)
      units_.scale[p] =
          elementary::pow(tree_.characteristic_length, parameters[static_cast<std::size_t>(p)].length_power);
    const Eigen::Index inertial = S::inertial_parameter_count * static_cast<Eigen::Index>(tree_.mass_elements.size());
    units_.families = {0, inertial, count};
  }

  /// Along the whole motion.
  /// @param add called with the quantity's rows and their share of the average, place by place
  template <class Add>
  void collect(const CostQuantity& quantity, Add add) const {
    MotionReplay<S> rerun(mechanism_, trajectory_, tree_, plan_);
    ForceRegressor<S> forces(mechanism_, rerun.tree(), plan_.freedoms, trajectory_.about, loose_);
    const double duration = plan_.prescribed_motion->duration();
    TrapezoidalAverage trapezoids([&](const MatrixX& rows, double weight) { add(rows, weight / duration); });
    const bool moving = quantity.kind == CostQuantity::Kind::kinetic_energy;  // asks for the velocities of all origins
    MatrixX rows;
    rerun.run(moving ? Detail::all : Detail::forces, [&](MotionStepper<S>& stepper) {
      forces.evaluate(stepper, quantity, rows);
      zero_absent_payloads(rerun.loads(), rows);
      trapezoids.add_sample(stepper.time(), rows);
    });
    trapezoids.finish();
  }

  /// Payloads do nothing while they are not there.
  void zero_absent_payloads(const TreePayloads<S>& loads, MatrixX& rows) const {
    for (std::size_t e = 0; e < tree_.mass_elements.size(); ++e)
      if (!loads.is_attached(e, loads.current_interval()))
        rows.middleCols(S::inertial_parameter_count * static_cast<Eigen::Index>(e), S::inertial_parameter_count)
            .setZero();
  }

  std::size_t series_count(const CostQuantity& quantity) const {
    const bool each = quantity.of_actuators() && !quantity.actuator && !quantity.is_combined;
    return each ? mechanism_.actuators.size() : 1;
  }

  std::vector<SequentialQr> triangles(const CostQuantity& quantity) const {
    std::vector<SequentialQr> all(series_count(quantity), SequentialQr(units_.scale.size()));
    collect(quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(all.size());
      for (std::size_t s = 0; s < all.size(); ++s)
        all[s].add(rows.middleRows(static_cast<Eigen::Index>(s) * each, each), weight);
    });
    return all;
  }

  /// A second time along the motion: what all samples would take in all parameters is too much to keep.
  void store_samples(const CostQuantity& quantity, std::vector<CostSeries>& series) const {
    Eigen::Index place = 0;
    collect(quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(series.size());
      for (std::size_t s = 0; s < series.size(); ++s) {
        CostSeries& one = series[s];
        if (!one.samples) one.samples.emplace(places_, each, one.space.rank());
        one.samples->set_sample(
            place, one.space.to_coordinates(rows.middleRows(static_cast<Eigen::Index>(s) * each, each)), weight);
      }
      ++place;
    });
  }

  Mechanism mechanism_;
  Trajectory trajectory_;
  FreeSprings loose_;
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  Eigen::Index places_ = 0;
  ColumnScales units_;
};

}  // namespace

struct TrajectoryCost::Implementation {
  std::unique_ptr<const FigureSource> source;
};

TrajectoryCost::TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory, const FreeSprings& loose) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  std::unique_ptr<const FigureSource> source;
  dispatch_space(mechanism.space,
                 [&]<class S>(S) { source = std::make_unique<FixedMotion<S>>(mechanism, trajectory, loose); });
  implementation_ = std::make_shared<const Implementation>(Implementation{std::move(source)});
}

TrajectoryCost::~TrajectoryCost() = default;
TrajectoryCost::TrajectoryCost(TrajectoryCost&&) noexcept = default;
TrajectoryCost& TrajectoryCost::operator=(TrajectoryCost&&) noexcept = default;

const MotionOutcome& TrajectoryCost::outcome() const { return implementation_->source->outcome; }

std::optional<CostFunction> TrajectoryCost::figure(Statistic figure, const std::string& quantity) const {
  return implementation_->source->figure(figure, quantity);
}

std::optional<std::vector<AffineSeries>> TrajectoryCost::rows(const std::string& quantity) const {
  return implementation_->source->rows(quantity);
}

bool is_linear_quantity(const Mechanism& mechanism, const std::string& quantity) {
  return find_cost_quantity(mechanism, quantity).has_value();
}

bool is_mass_dependent(const Trajectory& trajectory) {
  return trajectory.drive == DriveKind::com || trajectory.from.com || trajectory.to.com;
}

}  // namespace balance
