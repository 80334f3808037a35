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

namespace balance::time_optimal {

using numerics::Panel;
using numerics::PiecewiseChebyshevSeries;

// Prescribed angular momentum of momentum tasks.

/// Components of the angular momentum as functions of time.
class PrescribedMomentum {
 public:
  /// @throws std::invalid_argument if the numbers of components and quantities differ, or if time matters and the law
  ///        is not known yet. The message is suitable for users.
  PrescribedMomentum(SpaceKind space, const Trajectory& trajectory);

  /// The components, in the order of the tasks: 0 x, 1 y, 2 z.
  const std::vector<int>& axes() const { return axes_; }
  /// Whether time matters: a component is not always zero, or there is a spline over time.
  bool is_time_dependent() const { return over_time_; }
  /// @return [N m s], one entry per component
  VectorX at(double time) const;
  /// Times at which a third derivative may jump [s].
  std::vector<double> knots() const;
  /// Why the values do not cover the whole motion; empty if they do. @param duration [s]
  std::string uncovered_interval(double duration) const;

 private:
  struct Component {
    double constant = 0;
    std::optional<numerics::CubicSpline> spline;
  };

  void add(const trajectory::MomentumTask& task);
  void check(SpaceKind space) const;

  std::vector<int> axes_;
  std::vector<Component> components_;
  bool over_time_ = false;
};

namespace {

constexpr int panel_terms = PiecewiseChebyshevSeries::coefficient_count;
constexpr int min_panels = 8;              // for the whole range of the parameter
constexpr double min_panel_length = 1e-7;  // of the parameter: if shorter panels are needed, the rate is unbounded
constexpr double min_resolved_panel_length =
    1e-5;  // on shorter panels series need not converge: a third derivative of the path jumps there
constexpr double coefficient_tolerance = 2e-14;  // of a panel's last coefficients, as a fraction of all
constexpr double min_relative_inertia =
    1e-10;  // of the total mass at the characteristic length: smaller inertias are round-off
constexpr int max_picard_iterations = 40;  // per panel

/// The motion, or its path at constant speed, with the unknown quantities at their start values.
Trajectory with_zero_tasks(const Trajectory& original, bool over_time) {
  Trajectory trajectory = over_time ? original : reparametrise_by_path(original);
  const PiecewiseChebyshevSeries zero({Panel{0, 1, Samples::Zero(panel_terms, 3)}});
  for (trajectory::SecondaryTask& task : trajectory.secondary_tasks)
    if (auto* momentum_task = std::get_if<trajectory::MomentumTask>(&task.kind)) momentum_task->solution = zero;
  return trajectory;
}

template <class S>
class MomentumTaskSolver {
 public:
  MomentumTaskSolver(const Mechanism& mechanism, const Trajectory& trajectory)
      : mechanism_(mechanism),
        prescribed_momentum_(mechanism.space, trajectory),
        trajectory_(with_zero_tasks(trajectory, prescribed_momentum_.is_time_dependent())),
        duration_(trajectory_.duration),
        tree_(kinematics::compile_tree<S>(mechanism, prescribed_coordinates(trajectory_))),
        plan_(compile_trajectory(mechanism, tree_, trajectory_)),
        system_(tree_, plan_.drive),
        scale_(column_scale(tree_)),
        state_(tree_.nodes.size()),
        wrenches_(tree_.nodes.size()),
        tau_(static_cast<std::size_t>(tree_.columns)) {}

  MotionOutcome run(Trajectory& trajectory) {
    if (plan_.outcome.status != MotionStatus::done) return plan_.outcome;
    if (const std::string uncovered = prescribed_momentum_.uncovered_interval(duration_);
        prescribed_momentum_.is_time_dependent() && !uncovered.empty())
      return {MotionStatus::mismatch, 0, uncovered, {}};
    list_components();
    y_ = plan_.start;
    value_ = VectorX::Zero(count());
    if (!solve_rates(0, trajectory::Side::after, value_, rate_)) return rank_loss_outcome(0);
    start_determinant_ = determinant_;
    double begin = 0;
    for (const double end : breakpoints()) {
      const int panel_count = std::max(1, static_cast<int>(std::ceil(min_panels * (end - begin) - 1e-9)));
      for (int k = 1; k <= panel_count; ++k)
        if (!extend_to(k == panel_count ? end : begin + (end - begin) * k / panel_count))
          return rank_loss_outcome(panels_.back().end);
      begin = end;
    }
    store_solution(trajectory);
    return {MotionStatus::done, 0, "", {}};
  }

 private:
  Eigen::Index count() const { return static_cast<Eigen::Index>(components_.size()); }

  void list_components() {
    trajectory::PrescribedMotion::Request request;
    request.from.value.setZero(plan_.drive.value_count());
    Trajectory momentum_trajectory = trajectory_;
    std::erase_if(momentum_trajectory.secondary_tasks, [](const trajectory::SecondaryTask& task) {
      return !std::holds_alternative<trajectory::MomentumTask>(task.kind);
    });
    add_secondary_tasks(momentum_trajectory, plan_.quantities, request);
    for (const trajectory::ComponentOffset& offset : request.component_offsets) components_.push_back(offset.component);
    panels_.push_back({0, 0, {}});
  }

  /// Parameters at which accelerations or their derivatives jump, and the end.
  std::vector<double> breakpoints() const {
    std::vector<double> times = plan_.prescribed_motion->segment_end_times();
    for (const auto& additional : {plan_.prescribed_motion->jump_times(), plan_.prescribed_motion->knot_times()})
      times.insert(times.end(), additional.begin(), additional.end());
    if (prescribed_momentum_.is_time_dependent())
      for (const double knot : prescribed_momentum_.knots()) times.push_back(knot);
    std::sort(times.begin(), times.end());
    std::vector<double> breakpoint_list;
    for (const double time : times)
      if (const double s = time / duration_;
          s - (breakpoint_list.empty() ? 0 : breakpoint_list.back()) > breakpoint_tolerance &&
          s < 1 - breakpoint_tolerance)
        breakpoint_list.push_back(s);
    breakpoint_list.push_back(1);
    return breakpoint_list;
  }

  /// Angular momentum about the trajectory's reference point for coordinate rates v at the current pose. Computed as
  /// the moment that gives the tree at rest these rates as accelerations.
  VectorX momentum(const VectorX& v) {
    const VectorX zero_velocity = VectorX::Zero(tree_.columns);
    compute_angular_velocities(tree_, zero_velocity.data(), state_);
    kinematics::compute_accelerations<S>(tree_, zero_velocity.data(), v.data(), S::Vector::Zero(), state_);
    std::fill(wrenches_.begin(), wrenches_.end(), dynamics::Wrench<S>());
    inverse_dynamics(tree_, state_, wrenches_, tau_.data());
    const typename S::Vector about = kinematics::to_vector<S>(trajectory_.about);
    const Vector3 h = kinematics::angular_to_3d(
        typename S::Angular(wrenches_[0].moment - kinematics::cross(about, wrenches_[0].force)));
    return h(prescribed_momentum_.axes());
  }

  /// Right-hand side of the scaled equations: zero for closures, the prescribed rates for the other rows.
  VectorX right_hand_side(const trajectory::DriveSample& sample) const {
    VectorX rows = VectorX::Zero(system_.rows());
    const auto length_count = static_cast<Eigen::Index>(plan_.drive.point.size() + plan_.drive.com.size());
    Eigen::Index row = system_.closure_rows();
    for (Eigen::Index k = 0; k < sample.rate.size(); ++k, ++row) {
      const bool is_length =
          k < length_count || plan_.drive.linear[static_cast<std::size_t>(k - length_count)].is_length;
      rows[row] = sample.rate[k] / (is_length ? tree_.characteristic_length : 1);
    }
    for (const int component : plan_.drive.rotation) rows[row++] = sample.angular_velocity[component];
    return rows;
  }

  /// φ' at a parameter at which the quantities differ from their start by φ. @return false if there is none
  bool solve_rates(double s, trajectory::Side side, const VectorX& phi, VectorX& rate) {
    trajectory::DriveSample sample;
    plan_.prescribed_motion->at(s * duration_, side, sample);
    for (Eigen::Index i = 0; i < count(); ++i) sample.value[components_[static_cast<std::size_t>(i)]] += phi[i];
    const kinematics::AssemblySolution assembly = solve_assembly(system_, y_, sample);
    if (!assembly.found || !assembly.y.allFinite()) return false;
    y_ = assembly.y;
    VectorX residual;
    MatrixX jacobian;
    system_.evaluate(y_, sample, residual, jacobian);
    const numerics::CompleteOrthogonalDecomposition solver(jacobian);
    state_ = system_.state();
    const VectorX drive_momentum = momentum(scale_.cwiseProduct(solver.solve(right_hand_side(sample))));
    MatrixX J(count(), count());
    for (Eigen::Index i = 0; i < count(); ++i) {
      sample.rate.setZero();
      sample.angular_velocity.setZero();
      sample.rate[components_[static_cast<std::size_t>(i)]] = 1;
      J.col(i) = momentum(scale_.cwiseProduct(solver.solve(right_hand_side(sample))));
    }
    determinant_ = J.determinant();
    rate = duration_ * J.fullPivLu().solve(prescribed_momentum_.at(s * duration_) - drive_momentum);
    const double min_inertia =
        min_relative_inertia * tree_.mass * tree_.characteristic_length * tree_.characteristic_length;
    return J.allFinite() && numerics::min_coefficient(numerics::singular_values(J)) > min_inertia && rate.allFinite() &&
           determinant_ * start_determinant_ >= 0;
  }

  /// Extends the solution to a parameter, in as many panels as needed.
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

  /// Picard iteration on the values at the Chebyshev points.
  bool add_panel(double begin, double end) {
    const VectorX y = y_;
    Samples rates = rate_.transpose().replicate(panel_terms, 1), previous;
    for (int iteration = 0; iteration < max_picard_iterations; ++iteration) {
      previous = rates;
      y_ = y;
      const Samples values = numerics::values_at_chebyshev_points(
          numerics::integrate({begin, end, PiecewiseChebyshevSeries::values_to_coefficients() * rates}));
      for (int k = 0; k < panel_terms; ++k) {
        const double s = (begin + end) / 2 + (end - begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k);
        if (!solve_rates(s, trajectory::Side::after, value_ + values.row(k).transpose(), new_rate_)) return restore(y);
        rates.row(k) = new_rate_.transpose();
      }
      const double change = numerics::max_abs(rates - previous), size = numerics::max_abs(rates);
      if (!(change < 1e6 * (1 + size))) return restore(y);
      if (change <= 1e-14 * size || (iteration > 4 && change <= 1e-12 * size))
        return accept_panel(begin, end, rates, y);
    }
    return restore(y);
  }

  bool restore(const VectorX& y) {
    y_ = y;
    return false;
  }

  bool accept_panel(double begin, double end, const Samples& rates, const VectorX& y) {
    const Samples rate = PiecewiseChebyshevSeries::values_to_coefficients() * rates;
    for (Eigen::Index c = 0; c < rate.cols() && end - begin > min_resolved_panel_length; ++c)
      if (numerics::max_abs(rate.col(c).tail(3)) > coefficient_tolerance * rate.col(c).cwiseAbs().sum() + 1e-15)
        return restore(y);
    Panel panel = numerics::integrate({begin, end, rate});
    panel.coefficients.row(0) += value_.transpose();
    VectorX end_value(count());
    PiecewiseChebyshevSeries({panel}).evaluate(0, end, end_value.data());
    // before anything is stored: a panel that is not accepted leaves nothing
    if (!solve_rates(end, trajectory::Side::before, end_value, new_rate_)) return restore(y);
    panels_.push_back(panel);
    rates_.push_back({begin, end, rate});
    value_ = end_value;
    rate_ = new_rate_;
    return true;
  }

  /// Stores value, rate and its derivative for each quantity. The rate is exactly the one that was integrated.
  void store_solution(Trajectory& trajectory) const {
    const PiecewiseChebyshevSeries second = PiecewiseChebyshevSeries(rates_).derivative();
    Eigen::Index column = 0;
    for (trajectory::SecondaryTask& task : trajectory.secondary_tasks) {
      auto* momentum_task = std::get_if<trajectory::MomentumTask>(&task.kind);
      if (momentum_task == nullptr) continue;
      std::vector<Panel> panels;
      for (std::size_t p = 0; p < rates_.size(); ++p) {
        Panel panel{rates_[p].begin, rates_[p].end, Samples(panel_terms, 3)};
        panel.coefficients << panels_[p + 1].coefficients.col(column), rates_[p].coefficients.col(column),
            second.panels()[p].coefficients.col(column);
        panels.push_back(std::move(panel));
      }
      momentum_task->solution = PiecewiseChebyshevSeries(std::move(panels));
      momentum_task->over_time = prescribed_momentum_.is_time_dependent();
      ++column;
    }
  }

  MotionOutcome rank_loss_outcome(double s) const {
    const double percent = 100 * plan_.prescribed_motion->path_progress(s * duration_, trajectory::Side::after).s;
    char where[96], text[320];
    if (prescribed_momentum_.is_time_dependent())
      std::snprintf(where, sizeof where, "at t = %.6g s, %.4g %% of the path,", s * duration_, percent);
    else
      std::snprintf(where, sizeof where, "at %.4g %% of the path", percent);
    std::snprintf(text, sizeof text,
                  "%s the angular momentum can no longer be kept at %s: the contribution of the remaining rate%s to it "
                  "loses its %s there "
                  "(%.6g %s at the start)",
                  where, prescribed_momentum_.is_time_dependent() ? "the stated value" : "zero",
                  count() == 1 ? "" : "s", count() == 1 ? "sign" : "rank", start_determinant_, unit());
    return {MotionStatus::drive_singularity, prescribed_momentum_.is_time_dependent() ? s * duration_ : 0, text, {}};
  }

  /// Unit of det J if all rates are those of angles.
  const char* unit() const { return count() == 1 ? "kg m^2" : count() == 2 ? "kg^2 m^4" : "kg^3 m^6"; }

  const Mechanism& mechanism_;
  PrescribedMomentum prescribed_momentum_;
  Trajectory trajectory_;
  double duration_;  ///< of the trajectory that is followed; 1 if the parameter is that of the path [s]
  kinematics::Tree<S> tree_;
  kinematics::CompiledTrajectory<S> plan_;
  kinematics::ConstraintSystem<S> system_;
  VectorX scale_;
  kinematics::TreeState<S> state_;
  std::vector<dynamics::Wrench<S>> wrenches_;
  std::vector<double> tau_;
  std::vector<Eigen::Index> components_;  ///< indices into the drive's values
  VectorX y_, value_, rate_, new_rate_;
  double determinant_ = 0;
  double start_determinant_ = 0;  ///< determinant of J at the start
  std::vector<Panel> panels_;     ///< values; the first one is empty and ends at 0
  std::vector<Panel> rates_;
};

}  // namespace

MotionOutcome solve_momentum_tasks(const Mechanism& mechanism, Trajectory& trajectory) {
  const auto is_unsolved = [](const trajectory::SecondaryTask& task) {
    const auto* momentum_task = std::get_if<trajectory::MomentumTask>(&task.kind);
    return momentum_task != nullptr && momentum_task->solution.panels().empty();
  };
  if (std::none_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(), is_unsolved))
    return {MotionStatus::done, 0, "", {}};
  return kinematics::dispatch_space(
      mechanism.space, [&]<class S>(S) { return MomentumTaskSolver<S>(mechanism, trajectory).run(trajectory); });
}

namespace {

constexpr double end_time_tolerance = 1e-9;  // of the duration: times closer than this coincide

/// Not-a-knot splines need at least four values.
numerics::SplineEnd choose_spline_end(std::size_t values) {
  return values < 4 ? numerics::SplineEnd::natural : numerics::SplineEnd::not_a_knot;
}

}  // namespace

PrescribedMomentum::PrescribedMomentum(SpaceKind space, const Trajectory& trajectory) {
  bool has_timed_splines = false;
  for (const trajectory::SecondaryTask& task : trajectory.secondary_tasks)
    if (const auto* momentum_task = std::get_if<trajectory::MomentumTask>(&task.kind))
      add(*momentum_task);
    else
      has_timed_splines = has_timed_splines || std::get<trajectory::SplineTask>(task.kind).over_time;
  check(space);
  over_time_ = over_time_ || has_timed_splines;
  if (over_time_ && is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument(
        "with a law that is searched for, the angular momentum can only be kept at zero: otherwise the law decides "
        "when it has which value");
}

void PrescribedMomentum::add(const trajectory::MomentumTask& task) {
  axes_.push_back(task.axis);
  const bool is_zero = std::all_of(task.value.begin(), task.value.end(), [](double value) { return value == 0; });
  over_time_ = over_time_ || !is_zero;
  Component component;
  if (task.time.empty()) {
    component.constant = task.value.empty() ? 0 : task.value.front();
  } else {
    const Samples values = Eigen::Map<const VectorX>(task.value.data(), static_cast<Eigen::Index>(task.value.size()));
    component.spline.emplace(task.time, values, choose_spline_end(task.time.size()));
  }
  components_.push_back(std::move(component));
}

void PrescribedMomentum::check(SpaceKind space) const {
  if (space == SpaceKind::planar && axes_.size() != 1)
    throw std::invalid_argument(
        "only one quantity can keep the angular momentum of a planar mechanism: it has one component");
  std::vector<int> sorted = axes_;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw std::invalid_argument("each quantity that keeps the angular momentum must keep a different component");
}

VectorX PrescribedMomentum::at(double time) const {
  VectorX momentum(static_cast<Eigen::Index>(components_.size())), value(1), first(1), second(1);
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& component = components_[i];
    if (component.spline) component.spline->at(time, value, first, second);
    momentum[static_cast<Eigen::Index>(i)] = component.spline ? value[0] : component.constant;
  }
  return momentum;
}

std::vector<double> PrescribedMomentum::knots() const {
  std::vector<double> knot_times;
  for (const Component& component : components_)
    if (component.spline)
      knot_times.insert(knot_times.end(), component.spline->knots().begin(), component.spline->knots().end());
  return knot_times;
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

}  // namespace balance::time_optimal
