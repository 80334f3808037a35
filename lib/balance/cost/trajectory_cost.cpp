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
  virtual std::optional<CostFunction> figure(Figure figure, const std::string& name) const = 0;
  virtual std::optional<std::vector<PlaceRows>> rows(const std::string& name) const = 0;
};

template <class S>
class FixedMotion : public FigureSource {
 public:
  FixedMotion(const Mechanism& mechanism, const Trajectory& trajectory, const LooseSprings& loose)
      : mechanism_(mechanism),
        trajectory_(trajectory),
        loose_(loose),
        tree_(compile<S>(mechanism_, prescribed_coordinates(trajectory_))),
        plan_(make_plan(mechanism_, tree_, trajectory_)) {
    outcome = plan_.outcome;
    if (outcome.status != MotionStatus::done) return;
    outcome = Rerun<S>(mechanism_, trajectory_, tree_, plan_).run(Detail::forces, [&](auto&) { ++places_; });
    if (outcome.status == MotionStatus::done) set_units();
  }

  std::optional<CostFunction> figure(Figure figure, const std::string& name) const override {
    const std::optional<CostQuantity> quantity = find_cost_quantity(mechanism_, name);
    if (outcome.status != MotionStatus::done || !quantity) return std::nullopt;
    std::vector<Series> series;
    for (RowTriangle& triangle : triangles(*quantity))
      series.push_back({RowSpace(triangle.finish(), units_), std::nullopt});
    if (figure != Figure::rms) keep_samples(*quantity, series);
    return worst_of(figure, std::move(series), units_.size.size() - 1);
  }

  std::optional<std::vector<PlaceRows>> rows(const std::string& name) const override {
    const std::optional<CostQuantity> quantity = find_cost_quantity(mechanism_, name);
    if (outcome.status != MotionStatus::done || !quantity) return std::nullopt;
    std::vector<PlaceRows> series(series_of(*quantity));
    Eigen::Index place = 0;
    collect(*quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(series.size());
      for (std::size_t s = 0; s < series.size(); ++s) {
        PlaceRows& one = series[s];
        if (place == 0) one = {MatrixX(places_ * each, rows.cols()), each, VectorX(places_)};
        one.rows.middleRows(place * each, each) = rows.middleRows(static_cast<Eigen::Index>(s) * each, each);
        one.share[place] = weight;
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
    units_.size.setOnes(count + 1);
    for (Eigen::Index p = 0; p < count; ++p)
      units_.size[p] = elementary::pow(tree_.length, parameters[static_cast<std::size_t>(p)].length_power);
    const Eigen::Index inertial = S::parameters * static_cast<Eigen::Index>(tree_.elements.size());
    units_.families = {0, inertial, count};
  }

  /// Along the whole motion.
  /// @param add called with the quantity's rows and their share of the average, place by place
  template <class Add>
  void collect(const CostQuantity& quantity, Add add) const {
    Rerun<S> rerun(mechanism_, trajectory_, tree_, plan_);
    ForceMatrices<S> forces(mechanism_, rerun.tree(), plan_.freedoms, trajectory_.about, loose_);
    const double duration = plan_.schedule->duration();
    Trapezoids trapezoids([&](const MatrixX& rows, double weight) { add(rows, weight / duration); });
    const bool moving = quantity.kind == CostQuantity::Kind::kinetic_energy;  // asks for the velocities of all origins
    MatrixX rows;
    rerun.run(moving ? Detail::everything : Detail::forces, [&](Stepper<S>& stepper) {
      forces.at(stepper, quantity, rows);
      leave_out_absent(rerun.loads(), rows);
      trapezoids.see(stepper.time(), rows);
    });
    trapezoids.finish();
  }

  /// Payloads do nothing while they are not there.
  void leave_out_absent(const TreeLoads<S>& loads, MatrixX& rows) const {
    for (std::size_t e = 0; e < tree_.elements.size(); ++e)
      if (!loads.is_there(e, loads.now()))
        rows.middleCols(S::parameters * static_cast<Eigen::Index>(e), S::parameters).setZero();
  }

  std::size_t series_of(const CostQuantity& quantity) const {
    const bool each = quantity.of_actuators() && !quantity.actuator && !quantity.together;
    return each ? mechanism_.actuators.size() : 1;
  }

  std::vector<RowTriangle> triangles(const CostQuantity& quantity) const {
    std::vector<RowTriangle> all(series_of(quantity), RowTriangle(units_.size.size()));
    collect(quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(all.size());
      for (std::size_t s = 0; s < all.size(); ++s)
        all[s].add(rows.middleRows(static_cast<Eigen::Index>(s) * each, each), weight);
    });
    return all;
  }

  /// A second time along the motion: what all samples would take in all parameters is too much to keep.
  void keep_samples(const CostQuantity& quantity, std::vector<Series>& series) const {
    Eigen::Index place = 0;
    collect(quantity, [&](const MatrixX& rows, double weight) {
      const Eigen::Index each = rows.rows() / static_cast<Eigen::Index>(series.size());
      for (std::size_t s = 0; s < series.size(); ++s) {
        Series& one = series[s];
        if (!one.samples) one.samples.emplace(places_, each, one.space.rank());
        one.samples->set(place, one.space.in_coordinates(rows.middleRows(static_cast<Eigen::Index>(s) * each, each)),
                         weight);
      }
      ++place;
    });
  }

  Mechanism mechanism_;
  Trajectory trajectory_;
  LooseSprings loose_;
  Tree<S> tree_;
  Plan<S> plan_;
  Eigen::Index places_ = 0;
  ColumnUnits units_;
};

}  // namespace

struct TrajectoryCost::Implementation {
  std::unique_ptr<const FigureSource> source;
};

TrajectoryCost::TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory, const LooseSprings& loose) {
  if (trajectory.samples < 2) throw std::invalid_argument("a trajectory needs at least two samples");
  std::unique_ptr<const FigureSource> source;
  in_space(mechanism.space,
           [&]<class S>(S) { source = std::make_unique<FixedMotion<S>>(mechanism, trajectory, loose); });
  implementation_ = std::make_shared<const Implementation>(Implementation{std::move(source)});
}

TrajectoryCost::~TrajectoryCost() = default;
TrajectoryCost::TrajectoryCost(TrajectoryCost&&) noexcept = default;
TrajectoryCost& TrajectoryCost::operator=(TrajectoryCost&&) noexcept = default;

const MotionOutcome& TrajectoryCost::outcome() const { return implementation_->source->outcome; }

std::optional<CostFunction> TrajectoryCost::figure(Figure figure, const std::string& quantity) const {
  return implementation_->source->figure(figure, quantity);
}

std::optional<std::vector<PlaceRows>> TrajectoryCost::rows(const std::string& quantity) const {
  return implementation_->source->rows(quantity);
}

bool is_linear_quantity(const Mechanism& mechanism, const std::string& quantity) {
  return find_cost_quantity(mechanism, quantity).has_value();
}

bool depends_on_masses(const Trajectory& trajectory) {
  return trajectory.drive == DriveKind::com || trajectory.from.com || trajectory.to.com;
}

}  // namespace balance
