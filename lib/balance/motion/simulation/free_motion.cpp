#include "balance/motion/simulation/free_motion.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace balance::simulation {

using numerics::Panel;
using numerics::PiecewiseChebyshevSeries;
using trajectory::FreeStart;
using trajectory::Side;

namespace {

constexpr int panel_terms = PiecewiseChebyshevSeries::coefficient_count;
constexpr int max_picard_iterations = 40;             // per panel
constexpr double picard_tolerance = 1e-14;            // of the accelerations
constexpr double coefficient_tolerance = 1e-13;       // of a panel's last coefficients, relative to the accelerations
constexpr double min_panel_fraction = 1e-9;           // of the duration: shorter panels mean that the motion breaks off
constexpr double min_resolved_panel_fraction = 1e-7;  // shorter panels need not converge
constexpr double round_off_factor = 32;  // of the accelerations' measured round-off: differences below count as zero
constexpr std::size_t max_panels = 20'000, min_judged_panels = 200;
constexpr double breakpoint_tolerance = 1e-12;  // of the duration
constexpr int max_newton_iterations = 30;
constexpr double newton_tolerance = 1e-12, accepted_newton_tolerance = 1e-9;  // relative to the units of the state
constexpr double fast_convergence = 0.01;                                     // ratio of steps with the same matrix
constexpr double difference_step = 1e-5;                                      // in units of the state
constexpr double linearisation_step = 2e-3;                                   // in units of the state
constexpr double min_newton_pivot =
    1e-8;                                // of a system for a start, in its units: below this it has no unique solution
constexpr double max_newton_step = 0.5;  // in units of the state: an equilibrium is approached in such steps
constexpr double periodicity_tolerance = 1e-7;  // of accelerations at both ends
constexpr double end_round_off_factor = 1e5;    // of these: what the start's accuracy adds

bool contains(const std::vector<CoordinateId>& list, CoordinateId coordinate) {
  return std::find(list.begin(), list.end(), coordinate) != list.end();
}

std::string list_names(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::string list;
  for (const CoordinateId coordinate : coordinates)
    list += (list.empty() ? "" : ", ") + mechanism.coordinates[static_cast<std::size_t>(coordinate)].name;
  return list;
}

VectorX column_sizes(const Samples& samples) {
  VectorX sizes(samples.cols());
  for (Eigen::Index c = 0; c < samples.cols(); ++c) sizes[c] = numerics::max_abs(samples.col(c));
  return sizes;
}

/// The trajectory with the free and held coordinates at rest at their start.
Trajectory hold_undriven_coordinates(const Trajectory& original) {
  Trajectory trajectory = original;
  const trajectory::FreeMotion free = *std::exchange(trajectory.free_motion, std::nullopt);
  for (const auto* list : {&free.held, &free.free})
    for (const CoordinateId coordinate : *list) {
      const auto start = std::find_if(trajectory.from.joints.begin(), trajectory.from.joints.end(),
                                      [&](const CoordinateValue& value) { return value.coordinate == coordinate; });
      if (start == trajectory.from.joints.end())
        throw std::invalid_argument("the trajectory '" + trajectory.name + "' has no start values of free coordinates");
      trajectory.to.joints.push_back(*start);
      trajectory.courses.push_back({coordinate, {}});
    }
  return trajectory;
}

/// What is prescribed, and a configuration of all coordinates at the start.
struct DrivenMotion {
  MotionOutcome outcome;
  std::optional<trajectory::PrescribedMotion> motion;
  std::vector<CoordinateId> coordinates;  ///< that the components of the motion are
  VectorX start;
};

DrivenMotion compile_driven_motion(const Mechanism& mechanism, const Trajectory& trajectory) {
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    kinematics::CompiledMotion<S> compiled(mechanism, trajectory);
    DrivenMotion driven{compiled.plan.outcome, {}, {}, {}};
    if (driven.outcome.status != MotionStatus::done) return driven;
    driven.motion = std::move(compiled.plan.prescribed_motion);
    driven.coordinates = compiled.plan.quantities.coordinates;
    const std::vector<double> start = compute_coordinates(mechanism, compiled.tree, compiled.plan.start);
    driven.start = Eigen::Map<const VectorX>(start.data(), static_cast<Eigen::Index>(start.size()));
    return driven;
  });
}

void require_supported(const Mechanism& mechanism, const Trajectory& trajectory, const trajectory::FreeMotion& free) {
  const auto refuse = [&](const std::string& reason) {
    throw std::invalid_argument("the trajectory '" + trajectory.name + "' cannot leave coordinates free: " + reason);
  };
  if (trajectory.drive != DriveKind::joints) refuse("its drive is not 'joints'");
  for (const CoordinateId coordinate : free.free)
    if (contains(mechanism.actuators, coordinate)) refuse(list_names(mechanism, {coordinate}) + " has an actuator");
  if (is_mechanism_dependent(trajectory)) refuse("its law is found for the mechanism");
  if (has_velocity_constraints(mechanism)) refuse("the mechanism has constraints on speeds");
  if (model::PayloadIntervals(mechanism, find_trajectory_duration(trajectory)).count() > 1)
    refuse("payloads are taken up or set down on the way");
}

class FreeMotionSolver {
 public:
  FreeMotionSolver(const Mechanism& mechanism, const Trajectory& trajectory)
      : free_(*trajectory.free_motion),
        solved_{{}, mechanism, hold_undriven_coordinates(trajectory)},
        driven_(compile_driven_motion(mechanism, solved_.trajectory)),
        duration_(find_trajectory_duration(trajectory)),
        count_(static_cast<Eigen::Index>(free_.free.size())) {}

  SolvedFreeMotion solve() {
    VectorX position, rate;
    if (!begin(position, rate)) return std::move(solved_);
    if (free_.start == FreeStart::equilibrium && !find_equilibrium(position)) return std::move(solved_);
    if (free_.start == FreeStart::periodic ? !find_periodic_motion(position, rate) : !integrate_from(position, rate))
      return std::move(solved_);
    store_solution(position);
    return std::move(solved_);
  }

  LinearisedFreeMotion linearise() {
    LinearisedFreeMotion result;
    VectorX rate;
    const bool is_found = begin(result.position, rate) && find_nearby_equilibrium(result.position);
    result.outcome = solved_.outcome;
    if (!is_found) return result;
    const VectorX rest = VectorX::Zero(count_);
    result.unit = unit_;
    result.stiffness.resize(count_, count_);
    result.damping.resize(count_, count_);
    for (Eigen::Index k = 0; k < count_; ++k) {
      const VectorX direction = unit_[k] * VectorX::Unit(count_, k);
      const auto along_position = [&](double step) {
        return accelerations_at_rest(result.position + step * direction, rest);
      };
      const auto along_rate = [&](double step) { return accelerations_at_rest(result.position, step * direction); };
      result.stiffness.col(k) = differentiate(along_position) / unit_[k];
      result.damping.col(k) = differentiate(along_rate) / unit_[k];
    }
    result.stiffness /= duration_ * duration_;
    result.damping /= duration_;
    if (!result.stiffness.allFinite() || !result.damping.allFinite())
      result.outcome = {MotionStatus::unreachable, 0, "the motion about the equilibrium cannot be linearised", {}};
    return result;
  }

 private:
  const Coordinate& coordinate(Eigen::Index k) const {
    return solved_.mechanism.coordinates[static_cast<std::size_t>(free_.free[static_cast<std::size_t>(k)])];
  }
  bool is_failed() const { return solved_.outcome.status != MotionStatus::done; }

  bool fail(MotionStatus status, double time, const std::string& reason) {
    solved_.outcome = {status, time, reason, {}};
    return false;
  }

  /// Says which coordinates the trajectory has forgotten, if there are any.
  void name_undriven_coordinates() {
    const Mechanism& mechanism = solved_.mechanism;
    dynamics::ForwardOptions options;
    VectorX position = VectorX::Zero(static_cast<Eigen::Index>(mechanism.coordinates.size()));
    for (const CoordinateValue& value : mechanism.assembly) position[value.coordinate] = value.value;
    for (const CoordinateValue& value : solved_.trajectory.from.joints) {
      position[value.coordinate] = value.value;
      options.preferred.push_back(value.coordinate);
    }
    dynamics::ForwardDynamics dynamics(mechanism, options);
    if (dynamics.set_state(0, position, VectorX::Zero(position.size())).status != MotionStatus::done) return;
    // coordinates in the order of the spec that determine what the listed ones leave open
    const MatrixX rates = dynamics.transformation().matrix;
    std::vector<CoordinateId> chosen = options.preferred, missing;
    const auto rank_of = [&](const std::vector<CoordinateId>& coordinates) {
      MatrixX rows(static_cast<Eigen::Index>(coordinates.size()), rates.cols());
      for (std::size_t k = 0; k < coordinates.size(); ++k)
        rows.row(static_cast<Eigen::Index>(k)) = rates.row(coordinates[k]);
      Eigen::FullPivLU<MatrixX> solver(rows);
      solver.setThreshold(min_newton_pivot);
      return solver.rank();
    };
    Eigen::Index rank = rank_of(chosen);
    for (std::size_t c = 0; c < mechanism.coordinates.size() && rank < rates.cols(); ++c) {
      chosen.push_back(static_cast<int>(c));
      if (rank_of(chosen) > rank) {
        missing.push_back(static_cast<int>(c));
        ++rank;
      } else {
        chosen.pop_back();
      }
    }
    if (!missing.empty())
      solved_.outcome.reason = "coordinates are neither driven, held nor free: " + list_names(mechanism, missing);
  }

  /// Joints that are not prescribed might stick.
  bool check_friction() {
    for (const Friction& friction : solved_.mechanism.friction)
      if ((friction.dry_friction(1) > 0 || friction.dry_friction(-1) > 0 || friction.static_limit(1) > 0 ||
           friction.static_limit(-1) > 0) &&
          (contains(free_.free, friction.coordinate) || !contains(driven_.coordinates, friction.coordinate)))
        return fail(MotionStatus::mismatch, 0,
                    "the dry friction of " + list_names(solved_.mechanism, {friction.coordinate}) +
                        ", which is not driven, might make it stick: free coordinates go with dry friction of driven "
                        "and held ones only ('control' has joints that stick)");
    return true;
  }

  /// Prescribed coordinates without an actuator get one, held ones first, until there are as many actuators as
  /// prescribed coordinates.
  bool choose_actuators() {
    Mechanism& mechanism = solved_.mechanism;
    std::vector<CoordinateId> candidates = free_.held, added;
    for (const CoordinateId driven : driven_.coordinates)
      if (!contains(free_.free, driven) && !contains(candidates, driven)) candidates.push_back(driven);
    const std::size_t prescribed = candidates.size();
    if (mechanism.actuators.size() > prescribed)
      return fail(MotionStatus::mismatch, 0,
                  std::to_string(mechanism.actuators.size()) + " actuators and " + std::to_string(prescribed) +
                      " coordinates that are driven or held: the efforts of a partly driven mechanism are determined "
                      "only if the actuators are not more");
    for (const CoordinateId candidate : candidates)
      if (mechanism.actuators.size() < prescribed && !contains(mechanism.actuators, candidate)) {
        mechanism.actuators.push_back(candidate);
        added.push_back(candidate);
      }
    mechanism.torque_distribution.reset();
    if (!added.empty()) note_ = "without an actuator, driven or held by a guide: " + list_names(mechanism, added);
    return true;
  }

  /// @param position, rate of the free coordinates at the start
  bool begin(VectorX& position, VectorX& rate) {
    solved_.outcome = driven_.outcome;
    if (solved_.outcome.status == MotionStatus::mismatch) name_undriven_coordinates();
    if (is_failed() || !check_friction() || !choose_actuators()) return false;
    dynamics::ForwardOptions options;
    options.preferred = driven_.coordinates;
    dynamics_.emplace(solved_.mechanism, options);
    const double length = characteristic_length(solved_.mechanism);
    unit_.resize(count_), position.resize(count_), rate.setZero(count_);
    for (Eigen::Index k = 0; k < count_; ++k) {
      unit_[k] = coordinate(k).kind == CoordinateKind::length ? length : 1;
      const CoordinateId id = free_.free[static_cast<std::size_t>(k)];
      position[k] = driven_.start[id];
      for (const CoordinateValue& value : free_.rate)
        if (value.coordinate == id) rate[k] = value.value * duration_;
    }
    return true;
  }

  // Small motion.

  /// NaN if there are none.
  VectorX accelerations_at_rest(const VectorX& position, const VectorX& rate) {
    VectorX acceleration;
    if (!find_accelerations(0, Side::after, position, rate, acceleration, true))
      return VectorX::Constant(count_, std::numeric_limits<double>::quiet_NaN());
    return acceleration;
  }

  /// The derivative at zero.
  template <class Function>
  static VectorX differentiate(const Function& function) {
    const auto difference = [&](double step) { return VectorX((function(step) - function(-step)) / (2 * step)); };
    return (4 * difference(linearisation_step / 2) - difference(linearisation_step)) / 3;
  }

  bool find_nearby_equilibrium(VectorX& position) {
    round_off_ = VectorX::Zero(count_);
    value_ = position, rate_ = VectorX::Zero(count_);
    acceleration_ = accelerations_at_rest(position, rate_);
    if (!acceleration_.allFinite()) return fail_where_stopped();
    measure_round_off(0, true);
    if ((acceleration_.cwiseAbs().array() <= end_round_off_factor * round_off_.array()).all()) return true;
    return find_equilibrium(position);
  }

  // Accelerations. A state is the free coordinates and their rates per duration, over the fraction s of the duration.

  /// @param is_at_rest the prescribed coordinates are at rest where they are at s
  bool find_accelerations(double s, Side side, const VectorX& position, const VectorX& rate, VectorX& acceleration,
                          bool is_at_rest = false) {
    const double time = s * duration_;
    driven_.motion->at(time, side, sample_);
    position_.resize(driven_.start.size());
    position_ = guess_.size() > 0 ? guess_ : driven_.start;
    velocity_.setZero(position_.size());
    prescribed_.setZero(position_.size());
    for (std::size_t k = 0; k < driven_.coordinates.size(); ++k) {
      const auto c = static_cast<Eigen::Index>(driven_.coordinates[k]);
      const auto i = static_cast<Eigen::Index>(k);
      position_[c] = sample_.value[i];
      if (is_at_rest) continue;
      velocity_[c] = sample_.rate[i];
      prescribed_[c] = sample_.acceleration[i];
    }
    for (Eigen::Index k = 0; k < count_; ++k) {
      const auto c = static_cast<Eigen::Index>(free_.free[static_cast<std::size_t>(k)]);
      position_[c] = position[k];
      velocity_[c] = rate[k] / duration_;
      prescribed_[c] = 0;
    }
    if (!position_.allFinite() || !velocity_.allFinite()) return stop(time, "it grows beyond all bounds");
    if (!move_near(time) && !set_state(time)) return false;
    guess_ = dynamics_->position();
    return solve_equation(time, acceleration);
  }

  /// From the latest state, unless the guess is elsewhere.
  bool move_near(double time) {
    if (!is_set_) return false;
    const std::vector<CoordinateId>& independent = dynamics_->independent();
    VectorX position(static_cast<Eigen::Index>(independent.size())), rate(position.size());
    for (Eigen::Index k = 0; k < position.size(); ++k) {
      const CoordinateId c = independent[static_cast<std::size_t>(k)];
      position[k] = position_[c], rate[k] = velocity_[c];
    }
    return dynamics_->move_to(time, position, rate);
  }

  bool set_state(double time) {
    const MotionOutcome outcome = dynamics_->set_state(time, position_, velocity_);
    if (outcome.status != MotionStatus::done) {
      is_set_ = false;
      return stop(time, outcome.reason);
    }
    is_set_ = check_independent(time);
    return is_set_;
  }

  bool solve_equation(double time, VectorX& acceleration) {
    const dynamics::EquationOfMotion equation = dynamics_->equation();
    const auto size = static_cast<Eigen::Index>(dynamics_->independent().size());
    VectorX known = -equation.bias;
    MatrixX matrix(size, size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const CoordinateId independent = dynamics_->independent()[static_cast<std::size_t>(j)];
      known -= equation.mass.col(j) * prescribed_[independent];
      for (Eigen::Index k = 0; k < count_; ++k)
        if (free_.free[static_cast<std::size_t>(k)] == independent) matrix.col(k) = equation.mass.col(j);
    }
    matrix.rightCols(size - count_) = -equation.input;
    const Eigen::FullPivLU<MatrixX> solver(matrix);
    if (!solver.isInvertible())
      return stop(time, "the actuators do not hold the prescribed coordinates, whatever the free ones do");
    acceleration = solver.solve(known).head(count_) * (duration_ * duration_);
    return acceleration.allFinite() || stop(time, "its accelerations are not finite");
  }

  /// Whether exactly the prescribed and free coordinates are independent.
  bool check_independent(double time) {
    std::vector<CoordinateId> dependent;
    for (const CoordinateId listed : driven_.coordinates)
      if (!contains(dynamics_->independent(), listed)) dependent.push_back(listed);
    if (dependent.empty()) return true;
    is_mismatch_ = true;
    return stop(time, list_names(solved_.mechanism, dependent) +
                          " cannot be chosen independently of the other driven, held and free coordinates");
  }

  /// Why the latest state has no accelerations.
  bool stop(double time, const std::string& reason) {
    stop_time_ = time;
    stop_reason_ = reason;
    return false;
  }

  bool fail_where_stopped() {
    if (is_mismatch_) return fail(MotionStatus::mismatch, stop_time_, stop_reason_);
    return fail(MotionStatus::unreachable, stop_time_,
                trajectory::format_time_prefix(stop_time_) +
                    "the motion of the free coordinates cannot be followed: " + stop_reason_);
  }

  // Integration.

  /// Fractions of the duration at which accelerations or their derivatives jump, and the end.
  std::vector<double> list_breakpoints() const {
    std::vector<double> times = driven_.motion->segment_end_times();
    for (const auto& more : {driven_.motion->jump_times(), driven_.motion->knot_times()})
      times.insert(times.end(), more.begin(), more.end());
    for (const Load& load : solved_.mechanism.loads) times.insert(times.end(), load.time.begin(), load.time.end());
    std::sort(times.begin(), times.end());
    std::vector<double> breakpoints(1, 0.0);
    for (const double time : times)
      if (const double s = time / duration_;
          s > breakpoints.back() + breakpoint_tolerance && s < 1 - breakpoint_tolerance)
        breakpoints.push_back(s);
    breakpoints.push_back(1);
    return breakpoints;
  }

  /// @param rate per duration
  bool integrate_from(const VectorX& position, const VectorX& rate) {
    panels_.clear();
    last_length_ = 1;
    guess_ = start_guess_;
    is_set_ = false;
    value_ = position, rate_ = rate;
    scale_ = round_off_ = VectorX::Zero(count_);
    const std::vector<double> breakpoints = list_breakpoints();
    for (std::size_t b = 0; b + 1 < breakpoints.size(); ++b) {
      if (!find_accelerations(breakpoints[b], Side::after, value_, rate_, acceleration_)) return fail_where_stopped();
      if (b == 0) start_acceleration_ = acceleration_, start_guess_ = guess_;
      if (!extend(breakpoints[b], breakpoints[b + 1])) return fail_where_stopped();
    }
    return true;
  }

  /// Raises round_off_ to what changes of the present state by units in the last place change of its accelerations.
  void measure_round_off(double s, bool is_at_rest = false) {
    const VectorX guess = guess_;
    for (const double change : {0x1p-51, -0x1p-51, 0x3p-51}) {
      const VectorX value = value_ * (1 + change) + unit_ * change, rate = rate_ * (1 + change);
      if (find_accelerations(s, Side::after, value, rate, new_acceleration_, is_at_rest))
        round_off_ = round_off_.cwiseMax((new_acceleration_ - acceleration_).cwiseAbs());
      guess_ = guess;
    }
  }

  bool extend(double begin, double end) {
    double length = std::min(end - begin, last_length_), limit = end - begin;
    while (begin < end) {
      length = std::min(length, end - begin);
      const double next = end - begin - length < min_panel_fraction ? end : begin + length;
      measure_round_off(begin);
      const auto done = static_cast<double>(panels_.size());
      if (panels_.size() >= min_judged_panels && done > begin * static_cast<double>(max_panels))
        return stop(begin * duration_, "it is too fast for the length of the run (stiff springs)");
      if (add_panel(begin, next)) {
        begin = next;
        last_length_ = length;
        limit *= 1.05;
        length = std::min(limit, length * std::clamp(find_length_ratio(), 1.0, 1.5));
        continue;
      }
      if (truncation_ > 0) {
        length *= std::clamp(find_length_ratio(), 0.3, 0.9);
      } else {  // the iteration does not converge
        length /= 2;
        limit = length;
      }
      if (length >= min_panel_fraction) continue;
      if (stop_reason_.empty()) stop(begin * duration_, "its steps became too short");
      return false;
    }
    return true;
  }

  /// By which the length of a panel can change for its series to be as accurate as required.
  double find_length_ratio() const {
    if (truncation_ == 0) return 1.2;
    return 0.9 * elementary::pow(coefficient_tolerance / truncation_, 1.0 / (panel_terms - 2));
  }

  struct SolutionPanel {
    Panel value, rate, acceleration;
  };

  /// Value and rate from the accelerations at the points of a panel, whose start the present state is.
  SolutionPanel integrate_panel(double begin, double end, const Samples& accelerations) const {
    SolutionPanel panel;
    panel.acceleration = {begin, end, PiecewiseChebyshevSeries::values_to_coefficients() * accelerations};
    panel.rate = integrate(panel.acceleration);
    panel.rate.coefficients.row(0) += rate_.transpose();
    panel.value = integrate(panel.rate);
    panel.value.coefficients.row(0) += value_.transpose();
    return panel;
  }

  /// Picard iteration on the accelerations at the Chebyshev points.
  bool add_panel(double begin, double end) {
    stop_reason_.clear();
    truncation_ = 0;
    const VectorX guess = guess_;
    Samples accelerations = acceleration_.transpose().replicate(panel_terms, 1), previous;
    double last_change = INFINITY;
    for (int iteration = 0; iteration < max_picard_iterations; ++iteration) {
      previous = accelerations;
      guess_ = guess;
      const SolutionPanel panel = integrate_panel(begin, end, accelerations);
      const Samples values = values_at_chebyshev_points(panel.value), rates = values_at_chebyshev_points(panel.rate);
      for (int k = 0; k < panel_terms; ++k) {
        const double s = (begin + end) / 2 + (end - begin) / 2 * PiecewiseChebyshevSeries::chebyshev_point(k);
        if (!find_accelerations(s, Side::after, values.row(k), rates.row(k), new_acceleration_)) return restore(guess);
        accelerations.row(k) = new_acceleration_.transpose();
      }
      const double change = relative_size(accelerations - previous, accelerations);
      if (!(change < 1e6)) return restore(guess);
      if (change <= picard_tolerance ||
          (iteration > 4 && change <= 100 * picard_tolerance && change >= last_change / 2))
        return accept_panel(begin, end, accelerations, guess);
      if (iteration > 8 && change > last_change) return restore(guess);
      last_change = change;
    }
    return restore(guess);
  }

  /// The largest entry of a difference above round-off, as a fraction of the accelerations of its coordinate so far, or
  /// of a small fraction of all accelerations.
  double relative_size(const Samples& difference, const Samples& accelerations,
                       double factor = round_off_factor) const {
    const VectorX sizes = column_sizes(accelerations).cwiseMax(scale_);
    const double floor = 1e-3 * numerics::max_coefficient(sizes.cwiseQuotient(unit_));
    double result = 0;
    for (Eigen::Index c = 0; c < count_; ++c) {
      const double size = std::max(sizes[c], floor * unit_[c]);
      const double entry = numerics::max_abs(difference.col(c));
      if (!std::isfinite(entry)) return INFINITY;
      if (entry > factor * round_off_[c]) result = std::max(result, entry / size);
    }
    return result;
  }

  bool restore(const VectorX& guess) {
    guess_ = guess;
    is_set_ = false;
    return false;
  }

  bool accept_panel(double begin, double end, const Samples& accelerations, const VectorX& guess) {
    SolutionPanel panel = integrate_panel(begin, end, accelerations);
    truncation_ = relative_size(panel.acceleration.coefficients.bottomRows(3), accelerations);
    if (end - begin > min_resolved_panel_fraction && truncation_ > coefficient_tolerance) return restore(guess);
    const auto end_of = [](const Panel& p) { return VectorX(p.coefficients.colwise().sum().transpose()); };
    const VectorX value = end_of(panel.value), rate = end_of(panel.rate);
    if (!find_accelerations(end, Side::before, value, rate, new_acceleration_)) return restore(guess);
    value_ = value, rate_ = rate, acceleration_ = new_acceleration_;
    scale_ = scale_.cwiseMax(column_sizes(accelerations));
    panels_.push_back(std::move(panel));
    return true;
  }

  // The start.

  /// Newton's method with finite differences in units of the state.
  /// @param residual from the state to as many entries in units; false if it cannot be evaluated
  /// @param max_step of any entry, in units
  /// @return the outcome is set if false
  template <class Residual>
  bool solve_start(VectorX& state, const VectorX& units, double max_step, const Residual& residual,
                   const std::string& what) {
    const Eigen::Index n = state.size();
    VectorX value(n), shifted_value(n);
    double last_step_size = INFINITY;
    bool is_slow = true;  // the matrix is kept while the steps become much shorter
    Eigen::FullPivLU<MatrixX> solver;
    for (int iteration = 0; iteration < max_newton_iterations; ++iteration) {
      if (!residual(state, value)) return fail_where_stopped();
      if (is_slow) {
        MatrixX jacobian(n, n);
        for (Eigen::Index k = 0; k < n; ++k) {
          VectorX shifted = state;
          shifted[k] += difference_step * units[k];
          if (!residual(shifted, shifted_value)) return fail_where_stopped();
          jacobian.col(k) = (shifted_value - value) / difference_step;
        }
        solver.setThreshold(min_newton_pivot).compute(jacobian);
        if (!solver.isInvertible())
          return fail(MotionStatus::unreachable, 0, what + " found: nothing determines the free coordinates");
      }
      VectorX step = solver.solve(value);
      const double step_size = numerics::max_abs(step);
      is_slow = step_size > fast_convergence * last_step_size;
      if (step_size > max_step) step *= max_step / step_size;
      state -= step.cwiseProduct(units);
      if (step_size <= newton_tolerance || (step_size <= accepted_newton_tolerance && step_size >= last_step_size / 2))
        return true;
      last_step_size = step_size;
    }
    return fail(MotionStatus::unreachable, 0, what + " found; a start nearer to it (initial) may help");
  }

  bool find_equilibrium(VectorX& position) {
    const VectorX rest = VectorX::Zero(count_);
    return solve_start(
        position, unit_, max_newton_step,
        [&](const VectorX& state, VectorX& value) {
          VectorX acceleration;
          if (!find_accelerations(0, Side::after, state, rest, acceleration, true)) return false;
          value = acceleration.cwiseQuotient(unit_);
          start_guess_ = guess_;
          return true;
        },
        "no equilibrium");
  }

  bool find_periodic_motion(VectorX& position, VectorX& rate) {
    VectorX state(2 * count_), units(2 * count_);
    state << position, rate;
    units << unit_, unit_;
    const bool is_found = solve_start(
        state, units, INFINITY,
        [&](const VectorX& start, VectorX& value) {
          if (!integrate_from(start.head(count_), start.tail(count_))) return false;
          value << value_ - start.head(count_), rate_ - start.tail(count_);
          for (Eigen::Index k = 0; k < count_; ++k)
            if (coordinate(k).kind == CoordinateKind::angle) value[k] = std::remainder(value[k], 2 * std::numbers::pi);
          value = value.cwiseQuotient(units);
          return true;
        },
        "no periodic motion");
    if (!is_found) return false;
    position = state.head(count_), rate = state.tail(count_);
    if (!integrate_from(position, rate)) return false;
    if (relative_size((acceleration_ - start_acceleration_).transpose(), start_acceleration_.transpose(),
                      end_round_off_factor) > periodicity_tolerance)
      return fail(MotionStatus::unreachable, 0,
                  "no periodic motion found: what is driven, or a load, is not at the end as it is at the start");
    return true;
  }

  void store_solution(const VectorX& start) {
    Trajectory& trajectory = solved_.trajectory;
    for (Eigen::Index k = 0; k < count_; ++k) {
      const CoordinateId id = free_.free[static_cast<std::size_t>(k)];
      std::vector<Panel> panels;
      for (const SolutionPanel& source : panels_) {
        Panel panel{source.value.begin, source.value.end, Samples(panel_terms, 3)};
        panel.coefficients << source.value.coefficients.col(k), source.rate.coefficients.col(k),
            source.acceleration.coefficients.col(k);
        panel.coefficients(0, 0) -= start[k];
        panels.push_back(std::move(panel));
      }
      for (trajectory::CoordinateCourse& course : trajectory.courses)
        if (course.coordinate == id) course.solution = PiecewiseChebyshevSeries(panels);
      for (trajectory::PoseTarget* pose : {&trajectory.from, &trajectory.to})
        for (CoordinateValue& value : pose->joints)
          if (value.coordinate == id) value.value = start[k];
      solved_.mechanism.actuators.push_back(id);
    }
    solved_.mechanism.assembly.clear();  // in the assembly mode of the solution
    for (Eigen::Index c = 0; c < start_guess_.size(); ++c)
      solved_.mechanism.assembly.push_back({static_cast<int>(c), start_guess_[c]});
    solved_.outcome = {MotionStatus::done, duration_, "", {}};
    if (!note_.empty()) solved_.outcome.notes.push_back(note_);
  }

  const trajectory::FreeMotion free_;
  SolvedFreeMotion solved_;
  DrivenMotion driven_;
  double duration_;
  Eigen::Index count_;
  std::optional<dynamics::ForwardDynamics> dynamics_;
  bool is_set_ = false;  ///< dynamics_ has a state near the guess
  std::string note_;
  VectorX unit_;  ///< per free coordinate: the characteristic length or 1

  trajectory::DriveSample sample_;
  // per coordinate of the mechanism
  VectorX guess_;        ///< at the latest state; empty: none yet
  VectorX start_guess_;  ///< at the start
  VectorX position_, velocity_, prescribed_;
  bool is_mismatch_ = false;
  double stop_time_ = 0;
  std::string stop_reason_;

  std::vector<SolutionPanel> panels_;
  double last_length_ = 1;  ///< of a panel
  double truncation_ = 0;   ///< last coefficients of the latest panel, relative to the accelerations; 0: round-off
  VectorX value_, rate_, acceleration_, new_acceleration_, start_acceleration_;  ///< per free coordinate
  VectorX scale_;                                                                ///< the largest accelerations so far
  VectorX round_off_;                                                            ///< of accelerations
};

}  // namespace

SolvedFreeMotion solve_free_motion(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (!trajectory.free_motion) throw std::invalid_argument("the trajectory has no free coordinates");
  require_supported(mechanism, trajectory, *trajectory.free_motion);
  return FreeMotionSolver(mechanism, trajectory).solve();
}

LinearisedFreeMotion linearise_free_motion(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (!trajectory.free_motion) throw std::invalid_argument("the trajectory has no free coordinates");
  require_supported(mechanism, trajectory, *trajectory.free_motion);
  return FreeMotionSolver(mechanism, trajectory).linearise();
}

}  // namespace balance::simulation
