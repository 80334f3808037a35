#include "balance/cost/trajectory_cost.hpp"

#include "balance/base/elementary.hpp"
#include "balance/cost/force_matrices.hpp"
#include "balance/cost/rerun.hpp"
#include "balance/cost/series.hpp"
#include "balance/cost/trapezoids.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

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
