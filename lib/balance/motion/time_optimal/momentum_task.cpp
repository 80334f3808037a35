#include "balance/motion/time_optimal/momentum_task.hpp"

#include "balance/foundation/numerics/cubic_spline.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/time_optimal/path_model.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

// What is stated of the angular momentum that remaining quantities keep.

/// Components of the angular momentum as functions of time.
class PrescribedMomentum {
 public:
  /// @throws std::invalid_argument if there are not as many components as quantities that could keep them, or if a quantity that
  ///         goes by time stands beside a law that is not known yet. The message is fit for a user.
  PrescribedMomentum(SpaceKind space, const Trajectory& trajectory);

  /// The components, in the order of the courses: 0 x, 1 y, 2 z.
  const std::vector<int>& axes() const { return axes_; }
  /// Whether time matters: a component is not always zero, or a spline that goes by time lies beside.
  bool is_time_dependent() const { return over_time_; }
  /// @return [N m s], one entry per component
  VectorX at(double time) const;
  /// Where a third derivative may jump [s].
  std::vector<double> knots() const;
  /// Empty, or why the values do not hold for the whole motion. @param duration [s]
  std::string uncovered_interval(double duration) const;

 private:
  struct Component {
    double constant = 0;
    std::optional<CubicSpline> spline;
  };

  void add(const MomentumTask& kept);
  void check(SpaceKind space) const;

  std::vector<int> axes_;
  std::vector<Component> components_;
  bool over_time_ = false;
};

namespace {

constexpr int panel_terms = PiecewiseChebyshevSeries::coefficient_count;
constexpr int min_panels = 8;              // of the whole parameter
constexpr double min_panel_length = 1e-7;  // of the parameter: where shorter ones would be needed the rate has no bound
constexpr double min_resolved_panel_length =
    1e-5;  // in shorter ones series need not end: a third derivative of the path jumps there
constexpr double coefficient_tolerance = 2e-14;  // of a panel's last terms, as a part of all
constexpr double min_relative_inertia =
    1e-10;  // of all masses' moment of inertia at the characteristic length: below it is round-off
constexpr int max_picard_iterations = 40;  // of one panel

/// The motion, or its path at constant speed, where the quantities sought stay at their start.
Trajectory with_zero_tasks(const Trajectory& stated, bool over_time) {
  Trajectory trajectory = over_time ? stated : reparametrise_by_path(stated);
  const PiecewiseChebyshevSeries nothing({Panel{0, 1, Samples::Zero(panel_terms, 3)}});
  for (SecondaryTask& course : trajectory.secondary_tasks)
    if (auto* kept = std::get_if<MomentumTask>(&course.kind)) kept->solution = nothing;
  return trajectory;
}

/// The function whose derivative has these terms on a panel, zero at its beginning.
Samples integrate_panel(double begin, double end, const Samples& terms_of) {
  return PiecewiseChebyshevSeries({Panel{begin, end, terms_of}}).integral().panels().front().coefficients;
}

template <class S>
class MomentumTaskSolver {
 public:
  MomentumTaskSolver(const Mechanism& mechanism, const Trajectory& trajectory)
      : mechanism_(mechanism),
        stated_(mechanism.space, trajectory),
        trajectory_(with_zero_tasks(trajectory, stated_.is_time_dependent())),
        duration_(trajectory_.duration),
        tree_(compile_tree<S>(mechanism, prescribed_coordinates(trajectory_))),
        plan_(compile_trajectory(mechanism, tree_, trajectory_)),
        system_(tree_, plan_.drive),
        scale_(column_scale(tree_)),
        state_(tree_.nodes.size()),
        wrenches_(tree_.nodes.size()),
        tau_(static_cast<std::size_t>(tree_.columns)) {}

  MotionOutcome run(Trajectory& trajectory) {
    if (plan_.outcome.status != MotionStatus::done) return plan_.outcome;
    if (const std::string gap = stated_.uncovered_interval(duration_); stated_.is_time_dependent() && !gap.empty())
      return {MotionStatus::mismatch, 0, gap, {}};
    list_components();
    y_ = plan_.start;
    value_ = VectorX::Zero(count());
    if (!solve_rates(0, Side::after, value_, rate_)) return rank_loss_outcome(0);
    sign_ = determinant_;
    double begin = 0;
    for (const double end : breakpoints()) {
      const int pieces = std::max(1, static_cast<int>(std::ceil(min_panels * (end - begin) - 1e-9)));
      for (int k = 1; k <= pieces; ++k)
        if (!extend_to(k == pieces ? end : begin + (end - begin) * k / pieces))
          return rank_loss_outcome(panels_.back().end);
      begin = end;
    }
    store_solution(trajectory);
    return {MotionStatus::done, 0, "", {}};
  }

 private:
  Eigen::Index count() const { return static_cast<Eigen::Index>(components_.size()); }

  void list_components() {
    PrescribedMotion::Request request;
    request.from.value.setZero(plan_.drive.value_count());
    Trajectory kept = trajectory_;
    std::erase_if(kept.secondary_tasks,
                  [](const SecondaryTask& c) { return !std::holds_alternative<MomentumTask>(c.kind); });
    add_secondary_tasks(kept, plan_.quantities, request);
    for (const ComponentOffset& course : request.component_offsets) components_.push_back(course.component);
    panels_.push_back({0, 0, {}});
  }

  /// Where accelerations or their derivatives jump, and the end, as parts of the parameter.
  std::vector<double> breakpoints() const {
    std::vector<double> times = plan_.prescribed_motion->segment_end_times();
    for (const auto& more : {plan_.prescribed_motion->jump_times(), plan_.prescribed_motion->knot_times()})
      times.insert(times.end(), more.begin(), more.end());
    if (stated_.is_time_dependent())
      for (const double knot : stated_.knots()) times.push_back(knot);
    std::sort(times.begin(), times.end());
    std::vector<double> ends;
    for (const double time : times)
      if (const double place = time / duration_;
          place - (ends.empty() ? 0 : ends.back()) > breakpoint_tolerance && place < 1 - breakpoint_tolerance)
        ends.push_back(place);
    ends.push_back(1);
    return ends;
  }

  /// Angular momentum about the trajectory's point for coordinate rates v at the present poses: what would give the resting tree these
  /// rates as accelerations.
  VectorX momentum(const VectorX& v) {
    const VectorX rest = VectorX::Zero(tree_.columns);
    compute_angular_velocities(tree_, rest.data(), state_);
    compute_accelerations<S>(tree_, rest.data(), v.data(), S::Vector::Zero(), state_);
    std::fill(wrenches_.begin(), wrenches_.end(), Wrench<S>());
    inverse_dynamics(tree_, state_, wrenches_, tau_.data());
    const typename S::Vector about = to_vector<S>(trajectory_.about);
    const Vector3 h = angular_to_3d(typename S::Angular(wrenches_[0].moment - cross(about, wrenches_[0].force)));
    return h(stated_.axes());
  }

  /// What the scaled rows ask for: nothing of the closures, the prescribed rates of the others.
  VectorX right_side(const DriveSample& sample) const {
    VectorX rows = VectorX::Zero(system_.rows());
    const auto lengths = static_cast<Eigen::Index>(plan_.drive.point.size() + plan_.drive.com.size());
    Eigen::Index row = system_.closure_rows();
    for (Eigen::Index k = 0; k < sample.rate.size(); ++k, ++row) {
      const bool length = k < lengths || plan_.drive.linear[static_cast<std::size_t>(k - lengths)].is_length;
      rows[row] = sample.rate[k] / (length ? tree_.characteristic_length : 1);
    }
    for (const int component : plan_.drive.rotation) rows[row++] = sample.angular_velocity[component];
    return rows;
  }

  /// φ' at a place of the parameter where the quantities are φ beyond their start. @return false if there is none
  bool solve_rates(double place, Side side, const VectorX& phi, VectorX& rate) {
    DriveSample sample;
    plan_.prescribed_motion->at(place * duration_, side, sample);
    for (Eigen::Index i = 0; i < count(); ++i) sample.value[components_[static_cast<std::size_t>(i)]] += phi[i];
    const AssemblySolution here = solve_assembly(system_, y_, sample);
    if (!here.found || !here.y.allFinite()) return false;
    y_ = here.y;
    VectorX residual;
    MatrixX jacobian;
    system_.evaluate(y_, sample, residual, jacobian);
    const CompleteOrthogonalDecomposition solver(jacobian);
    state_ = system_.state();
    const VectorX others = momentum(scale_.cwiseProduct(solver.solve(right_side(sample))));
    MatrixX J(count(), count());
    for (Eigen::Index i = 0; i < count(); ++i) {
      sample.rate.setZero();
      sample.angular_velocity.setZero();
      sample.rate[components_[static_cast<std::size_t>(i)]] = 1;
      J.col(i) = momentum(scale_.cwiseProduct(solver.solve(right_side(sample))));
    }
    determinant_ = J.determinant();
    rate = duration_ * J.fullPivLu().solve(stated_.at(place * duration_) - others);
    const double least = min_relative_inertia * tree_.mass * tree_.characteristic_length * tree_.characteristic_length;
    return J.allFinite() && min_coefficient(singular_values(J)) > least && rate.allFinite() &&
           determinant_ * sign_ >= 0;
  }

  /// Extends the courses to a place, in as many panels as it takes.
  bool extend_to(double end) {
    double next = end;
    while (panels_.back().end < end) {
      const double begin = panels_.back().end;
      if (add_panel(begin, next)) {
        next = end;
        continue;
      }
      next = begin + (next - begin) / 2;
      if (next - begin < min_panel_length) return false;
    }
    return true;
  }

  /// Picard's iteration on the values at the points.
  bool add_panel(double begin, double end) {
    const VectorX y = y_;
    Samples rates = rate_.transpose().replicate(panel_terms, 1), previous;
    for (int iteration = 0; iteration < max_picard_iterations; ++iteration) {
      previous = rates;
      y_ = y;
      const Samples values =
          values_at_points(integrate_panel(begin, end, PiecewiseChebyshevSeries::values_to_coefficients() * rates));
      for (int k = 0; k < panel_terms; ++k) {
        const double place = (begin + end) / 2 + (end - begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k);
        if (!solve_rates(place, Side::after, value_ + values.row(k).transpose(), rate_found_)) return restore(y);
        rates.row(k) = rate_found_.transpose();
      }
      const double change = max_abs(rates - previous), size = max_abs(rates);
      if (!(change < 1e6 * (1 + size))) return restore(y);
      if (change <= 1e-14 * size || (iteration > 4 && change <= 1e-12 * size))
        return accept_panel(begin, end, rates, y);
    }
    return restore(y);
  }

  static Samples values_at_points(const Samples& series) {
    const PiecewiseChebyshevSeries function({Panel{-1, 1, series}});
    Samples values(panel_terms, series.cols());
    for (int k = 0; k < panel_terms; ++k)
      function.evaluate(0, PiecewiseChebyshevSeries::chebyshev_point(k), &values(k, 0));
    return values;
  }

  bool restore(const VectorX& y) {
    y_ = y;
    return false;
  }

  bool accept_panel(double begin, double end, const Samples& rates, const VectorX& y) {
    const Samples rate = PiecewiseChebyshevSeries::values_to_coefficients() * rates;
    for (Eigen::Index c = 0; c < rate.cols() && end - begin > min_resolved_panel_length; ++c)
      if (max_abs(rate.col(c).tail(3)) > coefficient_tolerance * rate.col(c).cwiseAbs().sum() + 1e-15)
        return restore(y);
    Samples value = integrate_panel(begin, end, rate);
    value.row(0) += value_.transpose();
    panels_.push_back({begin, end, value});
    rates_.push_back({begin, end, rate});
    VectorX there(count());
    PiecewiseChebyshevSeries({panels_.back()}).evaluate(0, end, there.data());
    value_ = there;
    if (!solve_rates(end, Side::before, value_, rate_)) return restore(y);
    return true;
  }

  /// Value, rate and its derivative of each quantity, from the rate: what it was integrated from is kept to the last digit.
  void store_solution(Trajectory& trajectory) const {
    const PiecewiseChebyshevSeries second = PiecewiseChebyshevSeries(rates_).derivative();
    Eigen::Index found = 0;
    for (SecondaryTask& course : trajectory.secondary_tasks) {
      auto* kept = std::get_if<MomentumTask>(&course.kind);
      if (kept == nullptr) continue;
      std::vector<Panel> panels;
      for (std::size_t p = 0; p < rates_.size(); ++p) {
        Panel panel{rates_[p].begin, rates_[p].end, Samples(panel_terms, 3)};
        panel.coefficients << panels_[p + 1].coefficients.col(found), rates_[p].coefficients.col(found),
            second.panels()[p].coefficients.col(found);
        panels.push_back(std::move(panel));
      }
      kept->solution = PiecewiseChebyshevSeries(std::move(panels));
      kept->over_time = stated_.is_time_dependent();
      ++found;
    }
  }

  MotionOutcome rank_loss_outcome(double place) const {
    const double way = 100 * plan_.prescribed_motion->path_progress(place * duration_, Side::after).s;
    char where[96], text[320];
    if (stated_.is_time_dependent())
      std::snprintf(where, sizeof where, "at t = %.6g s, %.4g %% of the path,", place * duration_, way);
    else
      std::snprintf(where, sizeof where, "at %.4g %% of the path", way);
    std::snprintf(
        text, sizeof text,
        "%s the angular momentum can no longer be kept at %s: what the remaining rate%s to it loses its %s there "
        "(%.6g %s at the start)",
        where, stated_.is_time_dependent() ? "what is stated" : "zero", count() == 1 ? " adds" : "s add",
        count() == 1 ? "sign" : "rank", sign_, unit());
    return {MotionStatus::drive_singularity, stated_.is_time_dependent() ? place * duration_ : 0, text, {}};
  }

  /// Of the determinant of J where all rates are those of angles.
  const char* unit() const { return count() == 1 ? "kg m^2" : count() == 2 ? "kg^2 m^4" : "kg^3 m^6"; }

  const Mechanism& mechanism_;
  PrescribedMomentum stated_;
  Trajectory trajectory_;
  double duration_;  ///< of the trajectory followed: 1 where the parameter is the way [s]
  Tree<S> tree_;
  CompiledTrajectory<S> plan_;
  ConstraintSystem<S> system_;
  VectorX scale_;
  TreeState<S> state_;
  std::vector<Wrench<S>> wrenches_;
  std::vector<double> tau_;
  std::vector<Eigen::Index> components_;  ///< of the drive's values
  VectorX y_, value_, rate_, rate_found_;
  double determinant_ = 0;
  double sign_ = 0;            ///< determinant of J at the start
  std::vector<Panel> panels_;  ///< values; the first one is empty and ends at 0
  std::vector<Panel> rates_;
};

}  // namespace

MotionOutcome solve_momentum_tasks(const Mechanism& mechanism, Trajectory& trajectory) {
  const auto unknown = [](const SecondaryTask& course) {
    const auto* kept = std::get_if<MomentumTask>(&course.kind);
    return kept != nullptr && kept->solution.panels().empty();
  };
  if (std::none_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(), unknown))
    return {MotionStatus::done, 0, "", {}};
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return MomentumTaskSolver<S>(mechanism, trajectory).run(trajectory); });
}

namespace {

constexpr double end_time_tolerance = 1e-9;  // of the duration: times nearer than this are one

/// Few values are joined by the spline that they are enough for.
SplineEnd choose_spline_end(std::size_t values) { return values < 4 ? SplineEnd::natural : SplineEnd::not_a_knot; }

}  // namespace

PrescribedMomentum::PrescribedMomentum(SpaceKind space, const Trajectory& trajectory) {
  bool splines = false;
  for (const SecondaryTask& course : trajectory.secondary_tasks)
    if (const auto* kept = std::get_if<MomentumTask>(&course.kind))
      add(*kept);
    else
      splines = splines || std::get<SplineTask>(course.kind).over_time;
  check(space);
  over_time_ = over_time_ || splines;
  if (over_time_ && is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument(
        "beside a law that is searched for the angular momentum can be kept at zero alone: otherwise it is the law "
        "that decides "
        "when it has which value");
}

void PrescribedMomentum::add(const MomentumTask& kept) {
  axes_.push_back(kept.axis);
  const bool zero = std::all_of(kept.value.begin(), kept.value.end(), [](double value) { return value == 0; });
  over_time_ = over_time_ || !zero;
  Component component;
  if (kept.time.empty()) {
    component.constant = kept.value.empty() ? 0 : kept.value.front();
  } else {
    const Samples values = Eigen::Map<const VectorX>(kept.value.data(), static_cast<Eigen::Index>(kept.value.size()));
    component.spline.emplace(kept.time, values, choose_spline_end(kept.time.size()));
  }
  components_.push_back(std::move(component));
}

void PrescribedMomentum::check(SpaceKind space) const {
  if (space == SpaceKind::planar && axes_.size() != 1)
    throw std::invalid_argument(
        "one quantity keeps the angular momentum of a planar mechanism, which has one component");
  std::vector<int> sorted = axes_;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw std::invalid_argument("every quantity that keeps the angular momentum takes care of a component of its own");
}

VectorX PrescribedMomentum::at(double time) const {
  VectorX all(static_cast<Eigen::Index>(components_.size())), value(1), first(1), second(1);
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& component = components_[i];
    if (component.spline) component.spline->at(time, value, first, second);
    all[static_cast<Eigen::Index>(i)] = component.spline ? value[0] : component.constant;
  }
  return all;
}

std::vector<double> PrescribedMomentum::knots() const {
  std::vector<double> all;
  for (const Component& component : components_)
    if (component.spline) all.insert(all.end(), component.spline->knots().begin(), component.spline->knots().end());
  return all;
}

std::string PrescribedMomentum::uncovered_interval(double duration) const {
  for (const Component& component : components_) {
    if (!component.spline) continue;
    const double first = component.spline->knots().front(), last = component.spline->knots().back();
    if (first <= end_time_tolerance * duration && last >= (1 - end_time_tolerance) * duration) continue;
    char text[160];
    std::snprintf(text, sizeof text,
                  "the angular momentum is stated from %.6g s to %.6g s, but the motion lasts from 0 to %.6g s", first,
                  last, duration);
    return text;
  }
  return "";
}

}  // namespace balance
