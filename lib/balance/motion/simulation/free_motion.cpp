#include "balance/motion/simulation/free_motion.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/chebyshev_series.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/partly_driven_mechanism.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <unsupported/Eigen/MatrixFunctions>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
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
constexpr double min_newton_pivot =
    1e-8;                               // of a system for a start, in its units: below this it has no unique solution
constexpr int gradient_iterations = 8;  // after these the matrix of a periodic motion is found by further runs
constexpr double max_growth = 1e7;      // of deviations in a period of which the start can still be sought
constexpr double multiplier_tolerance =
    1e-4;                                  // of a period's largest multiplier: of a rigid motion, the root of round-off
constexpr double min_family_entry = 1e-3;  // of a direction in which nothing determines the start
constexpr double driven_tolerance = 1e-9;  // of what is driven at both ends, in units and units per duration
constexpr double max_plausible_step = 1e3;      // in units of the state: behind it nothing can be evaluated
constexpr double max_newton_step = 0.5;         // in units of the state: an equilibrium is approached in such steps
constexpr double periodicity_tolerance = 1e-7;  // of accelerations at both ends
constexpr double end_round_off_factor = 1e5;    // of these: what the start's accuracy adds

VectorX column_sizes(const Samples& samples) {
  VectorX sizes(samples.cols());
  for (Eigen::Index c = 0; c < samples.cols(); ++c) sizes[c] = numerics::max_abs(samples.col(c));
  return sizes;
}

class FreeMotionSolver {
 public:
  FreeMotionSolver(const Mechanism& mechanism, const Trajectory& trajectory)
      : system_(mechanism, trajectory),
        free_(system_.free_motion()),
        duration_(system_.duration()),
        count_(system_.count()),
        unit_(system_.unit()),
        solved_{system_.outcome(), system_.mechanism(), system_.trajectory()} {}

  SolvedFreeMotion solve() {
    if (is_failed()) return std::move(solved_);
    for (Eigen::Index k = 0; k < count_; ++k) is_cyclic_.push_back(is_cyclic(system_.free_motion().free[k]));
    VectorX position = system_.free_start(), rate = system_.free_rate() * duration_;
    if (free_.start == FreeStart::equilibrium && !find_equilibrium(position)) return std::move(solved_);
    if (free_.start == FreeStart::periodic ? !find_periodic_motion(position, rate) : !integrate_from(position, rate))
      return std::move(solved_);
    store_solution(position);
    return std::move(solved_);
  }

 private:
  using Driving = PartlyDrivenMechanism::Driving;

  bool is_failed() const { return solved_.outcome.status != MotionStatus::done; }

  bool fail(MotionStatus status, double time, const std::string& reason) {
    solved_.outcome = {status, time, reason, {}};
    return false;
  }

  bool stop(double time, const std::string& reason) { return system_.stop(time, reason); }

  bool fail_where_stopped() {
    solved_.outcome = system_.stop_outcome();
    return false;
  }

  /// A state is the free coordinates and their rates per duration, over the fraction s of the duration.
  bool find_accelerations(double s, Side side, const VectorX& position, const VectorX& rate, VectorX& acceleration,
                          Driving driving = Driving::moving) {
    if (!system_.set_state(s * duration_, side, position, rate / duration_, driving) ||
        !system_.find_accelerations(acceleration))
      return false;
    acceleration *= duration_ * duration_;
    return acceleration.allFinite() || stop(s * duration_, "its accelerations are not finite");
  }

  // Integration.

  /// Fractions of the duration at which accelerations or their derivatives jump, and the end.
  std::vector<double> list_breakpoints() const {
    std::vector<double> times = system_.driven_motion().segment_end_times();
    for (const auto& more : {system_.driven_motion().jump_times(), system_.driven_motion().knot_times()})
      times.insert(times.end(), more.begin(), more.end());
    for (const Load& load : solved_.mechanism.loads)
      if (load.is_over_time()) times.insert(times.end(), load.arguments.begin(), load.arguments.end());
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
    system_.restart_near(start_guess_);
    value_ = position, rate_ = rate;
    scale_ = round_off_ = VectorX::Zero(count_);
    const std::vector<double> breakpoints = list_breakpoints();
    for (std::size_t b = 0; b + 1 < breakpoints.size(); ++b) {
      if (!find_accelerations(breakpoints[b], Side::after, value_, rate_, acceleration_)) return fail_where_stopped();
      if (b == 0) start_acceleration_ = acceleration_, start_guess_ = system_.guess();
      if (!extend(breakpoints[b], breakpoints[b + 1])) return fail_where_stopped();
    }
    return true;
  }

  /// Raises round_off_ to what changes of the present state by units in the last place change of its accelerations.
  void measure_round_off(double s) {
    const VectorX guess = system_.guess();
    for (const double change : {0x1p-51, -0x1p-51, 0x3p-51}) {
      const VectorX value = value_ * (1 + change) + unit_ * change, rate = rate_ * (1 + change);
      if (find_accelerations(s, Side::after, value, rate, new_acceleration_))
        round_off_ = round_off_.cwiseMax((new_acceleration_ - acceleration_).cwiseAbs());
      system_.set_guess(guess);
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
      if (system_.stop_reason().empty()) stop(begin * duration_, "its steps became too short");
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
    system_.clear_stop_reason();
    truncation_ = 0;
    const VectorX guess = system_.guess();
    Samples accelerations = acceleration_.transpose().replicate(panel_terms, 1), previous;
    double last_change = INFINITY;
    for (int iteration = 0; iteration < max_picard_iterations; ++iteration) {
      previous = accelerations;
      system_.set_guess(guess);
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
    system_.restart_near(guess);
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

  /// What the start of a motion has to fulfil.
  struct StartProblem {
    VectorX units;     ///< of the state
    double max_step;   ///< of any entry of the state, in units
    std::string what;  ///< "equilibrium"
    /// From the state to as many entries in units; false if it cannot be evaluated.
    std::function<bool(const VectorX& state, VectorX& value)> residual;
    /// Its derivative, in units, at the state evaluated last; empty: by differences.
    std::function<bool(MatrixX& jacobian)> derivative;
  };

  bool find_difference_quotients(const StartProblem& problem, const VectorX& state, const VectorX& value,
                                 MatrixX& jacobian) {
    VectorX shifted_value(state.size());
    for (Eigen::Index k = 0; k < state.size(); ++k) {
      VectorX shifted = state;
      shifted[k] += difference_step * problem.units[k];
      if (!problem.residual(shifted, shifted_value)) return false;
      jacobian.col(k) = (shifted_value - value) / difference_step;
    }
    return true;
  }

  /// Newton's method in units of the state; where nothing determines some of it, with the shortest steps.
  /// @return the outcome is set if false
  bool solve_start(VectorX& state, const StartProblem& problem) {
    const Eigen::Index n = state.size();
    const std::string no_such = "no " + problem.what + " found";
    VectorX value(n);
    MatrixX jacobian(n, n);
    double last_step_size = INFINITY;
    bool is_slow = true;  // the matrix is kept while the steps become much shorter
    numerics::CompleteOrthogonalDecomposition solver;
    solver.setThreshold(min_newton_pivot);
    for (int iteration = 0; iteration < max_newton_iterations; ++iteration) {
      if (!problem.residual(state, value)) {
        if (std::isfinite(last_step_size) && last_step_size > max_plausible_step)
          return fail(MotionStatus::unreachable, 0,
                      no_such + ": the search leads out of all bounds, as at a resonance without damping");
        return fail_where_stopped();
      }
      if (is_slow) {
        const bool is_found = problem.derivative && iteration < gradient_iterations
                                  ? problem.derivative(jacobian)
                                  : find_difference_quotients(problem, state, value, jacobian);
        if (!is_found) return fail_where_stopped();
        if (const double growth = numerics::max_abs(jacobian); problem.derivative && !(growth < max_growth)) {
          char text[80];
          std::snprintf(text, sizeof text, ": deviations grow by a factor of %.2g within a period", growth);
          return fail(MotionStatus::unreachable, 0, no_such + text + ", too much for the search");
        }
        solver.compute(jacobian);
      }
      VectorX step = solver.solve(value);
      const double step_size = numerics::max_abs(step);
      is_slow = step_size > fast_convergence * last_step_size;
      const bool is_final =
          step_size <= newton_tolerance || (step_size <= accepted_newton_tolerance && step_size >= last_step_size / 2);
      if (solver.rank() < n && is_final) {
        family_ = name_undetermined(jacobian);
        // what is left cannot be removed
        if (numerics::max_abs(VectorX(value - jacobian * step)) > accepted_newton_tolerance)
          return fail(MotionStatus::unreachable, 0, no_such + ": nothing determines " + family_);
      }
      if (step_size > problem.max_step) step *= problem.max_step / step_size;
      state -= step.cwiseProduct(problem.units);
      if (is_final) return true;
      last_step_size = step_size;
    }
    return fail(MotionStatus::unreachable, 0, no_such + "; a start nearer to it (initial) may help");
  }

  /// Free coordinates of which changes of themselves or of their rates leave a residual as it is.
  std::string name_undetermined(const MatrixX& jacobian) const {
    const numerics::SingularValueDecomposition decomposition(jacobian, Eigen::ComputeFullV);
    const VectorX& values = decomposition.singularValues();
    std::string names;
    for (Eigen::Index k = 0; k < count_; ++k) {
      bool is_open = false;
      for (Eigen::Index j = 0; j < values.size(); ++j)
        for (Eigen::Index row = k; row < jacobian.rows(); row += count_)
          is_open = is_open || (values[j] <= min_newton_pivot * values[0] &&
                                std::abs(decomposition.matrixV()(row, j)) > min_family_entry);
      if (is_open) names += (names.empty() ? "" : ", ") + system_.coordinate(k).name;
    }
    return names;
  }

  bool find_equilibrium(VectorX& position) {
    const VectorX rest = VectorX::Zero(count_);
    const auto residual = [&](const VectorX& state, VectorX& value) {
      VectorX acceleration;
      if (!find_accelerations(0, Side::after, state, rest, acceleration, Driving::at_rest)) return false;
      value = acceleration.cwiseQuotient(unit_);
      start_guess_ = system_.guess();
      return true;
    };
    return solve_start(position, {unit_, max_newton_step, "equilibrium", residual, {}});
  }

  /// Whether whole turns of an angle change nothing: not where something rolls away.
  bool is_cyclic(CoordinateId id) const {
    const Coordinate& coordinate = system_.mechanism().coordinates[id];
    return coordinate.kind == CoordinateKind::angle && !is_rolling(system_.mechanism().joints[coordinate.joint].type);
  }

  /// The first prescribed coordinate that is not at the end as it is at the start; empty: all of them are.
  std::string find_driven_deviation() const {
    trajectory::DriveSample start, end;
    system_.driven_motion().at(0, Side::after, start);
    system_.driven_motion().at(duration_, Side::before, end);
    const double length = characteristic_length(system_.mechanism());
    for (std::size_t k = 0; k < system_.driven_coordinates().size(); ++k) {
      const CoordinateId id = system_.driven_coordinates()[k];
      const auto i = static_cast<Eigen::Index>(k);
      const Coordinate& coordinate = system_.mechanism().coordinates[id];
      double change = end.value[i] - start.value[i];
      if (is_cyclic(id)) change = std::remainder(change, 2 * std::numbers::pi);
      const double unit = coordinate.kind == CoordinateKind::length ? length : 1,
                   rate_change = (end.rate[i] - start.rate[i]) * duration_,
                   size = std::max(unit, std::abs(end.rate[i]) * duration_);
      if (std::abs(change) > driven_tolerance * size || std::abs(rate_change) > driven_tolerance * size)
        return coordinate.name;
    }
    return "";
  }

  /// ∂x(1)/∂x(0) of the motion found last, for x = (f, f′) in units: on every panel the exponential of Magnus' series of
  /// the fourth order, exact where the equations are linear with constant coefficients.
  bool find_monodromy(MatrixX& monodromy) {
    const Eigen::Index n = count_;
    monodromy.setIdentity(2 * n, 2 * n);
    system_.restart_near(start_guess_);
    for (const SolutionPanel& panel : panels_) {
      const double begin = panel.value.begin, length = panel.value.end - begin, offset = std::sqrt(3.0) / 6;
      MatrixX first, second;
      if (!find_state_matrix(panel, begin + (0.5 - offset) * length, first) ||
          !find_state_matrix(panel, begin + (0.5 + offset) * length, second))
        return false;
      const MatrixX exponent =
          length / 2 * (first + second) + length * length * offset / 2 * (second * first - first * second);
      monodromy = MatrixX(exponent.exp()) * monodromy;
    }
    return monodromy.allFinite() || stop(0, "it grows beyond all bounds");
  }

  /// x′ = A x for small deviations, in units.
  bool find_state_matrix(const SolutionPanel& panel, double s, MatrixX& matrix) {
    const Eigen::Index n = count_;
    VectorX position(n), rate(n), base, shifted;
    PiecewiseChebyshevSeries({panel.value}).evaluate(0, s, position.data());
    PiecewiseChebyshevSeries({panel.rate}).evaluate(0, s, rate.data());
    if (!find_accelerations(s, Side::after, position, rate, base)) return false;
    const VectorX guess = system_.guess();
    matrix.setZero(2 * n, 2 * n);
    matrix.topRightCorner(n, n).setIdentity();
    for (Eigen::Index k = 0; k < 2 * n; ++k) {
      VectorX& moved = k < n ? position : rate;
      const double value = moved[k % n], change = difference_step * unit_[k % n];
      moved[k % n] += change;
      system_.set_guess(guess);
      if (!find_accelerations(s, Side::after, position, rate, shifted)) return false;
      matrix.col(k).tail(n) = (shifted - base).cwiseQuotient(unit_) / difference_step;
      moved[k % n] = value;
    }
    system_.set_guess(guess);
    return true;
  }

  bool find_periodic_motion(VectorX& position, VectorX& rate) {
    VectorX state(2 * count_), units(2 * count_);
    state << position, rate;
    units << unit_, unit_;
    const auto residual = [&](const VectorX& start, VectorX& value) {
      if (!integrate_from(start.head(count_), start.tail(count_))) return false;
      value << value_ - start.head(count_), rate_ - start.tail(count_);
      for (Eigen::Index k = 0; k < count_; ++k)
        if (is_cyclic_[static_cast<std::size_t>(k)]) value[k] = std::remainder(value[k], 2 * std::numbers::pi);
      value = value.cwiseQuotient(units);
      return true;
    };
    const auto derivative = [&](MatrixX& jacobian) {
      if (!find_monodromy(jacobian)) return false;
      jacobian.diagonal().array() -= 1;
      return true;
    };
    if (!solve_start(state, {units, INFINITY, "periodic motion", residual, derivative})) return false;
    position = state.head(count_), rate = state.tail(count_);
    if (!integrate_from(position, rate)) return false;
    if (relative_size((acceleration_ - start_acceleration_).transpose(), start_acceleration_.transpose(),
                      end_round_off_factor) > periodicity_tolerance) {
      const std::string deviating = find_driven_deviation();
      return fail(MotionStatus::unreachable, 0,
                  "no periodic motion found: " + (deviating.empty() ? "a load" : deviating + ", which is driven,") +
                      " is not at the end as it is at the start");
    }
    return find_stability();
  }

  /// Floquet: by what deviations from the periodic motion found last are multiplied in every period.
  bool find_stability() {
    MatrixX monodromy;
    if (!find_monodromy(monodromy)) return fail_where_stopped();
    const VectorX multipliers = Eigen::EigenSolver<MatrixX>(monodromy, false).eigenvalues().cwiseAbs();
    const double largest = numerics::max_coefficient(multipliers);
    char text[160];
    std::snprintf(text, sizeof text, "deviations from it are multiplied by %s%.4g in every period",
                  largest < 1 ? "at most " : "up to ", largest);
    stability_ =
        std::abs(largest - 1) <= multiplier_tolerance
            ? "the periodic motion is neither stable nor unstable to first order: deviations stay"
            : std::string(largest < 1 ? "the periodic motion is stable: " : "the periodic motion is unstable: ") + text;
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
    if (!system_.note().empty()) solved_.outcome.notes.push_back(system_.note());
    if (!stability_.empty()) solved_.outcome.notes.push_back(stability_);
    if (!family_.empty())
      solved_.outcome.notes.push_back(
          std::string(free_.start == FreeStart::equilibrium ? "the equilibrium" : "the periodic motion") +
          " is one of many, because nothing determines " + family_ + ": the one nearest to the stated start was taken");
  }

  PartlyDrivenMechanism system_;
  const trajectory::FreeMotion& free_;
  double duration_;
  Eigen::Index count_;
  const VectorX& unit_;  ///< per free coordinate: the characteristic length or 1
  SolvedFreeMotion solved_;
  VectorX start_guess_;          ///< per coordinate of the mechanism, at the start
  std::string stability_;        ///< of a periodic motion, as a note; empty: not found
  std::vector<bool> is_cyclic_;  ///< per free coordinate
  std::string family_;           ///< free coordinates that the start leaves open

  std::vector<SolutionPanel> panels_;
  double last_length_ = 1;  ///< of a panel
  double truncation_ = 0;   ///< last coefficients of the latest panel, relative to the accelerations; 0: round-off
  VectorX value_, rate_, acceleration_, new_acceleration_, start_acceleration_;  ///< per free coordinate
  VectorX scale_;                                                                ///< the largest accelerations so far
  VectorX round_off_;                                                            ///< of accelerations
};

}  // namespace

SolvedFreeMotion solve_free_motion(const Mechanism& mechanism, const Trajectory& trajectory) {
  return FreeMotionSolver(mechanism, trajectory).solve();
}

}  // namespace balance::simulation
