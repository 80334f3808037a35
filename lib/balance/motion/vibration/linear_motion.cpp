#include "balance/motion/vibration/linear_motion.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/motion/simulation/partly_driven_mechanism.hpp"
#include "balance/motion/vibration/central_differences.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::vibration {

using simulation::FreeEquation;
using simulation::PartlyDrivenMechanism;
using trajectory::Side;

namespace {

constexpr double position_step = 0.02;   // in units: the truncation is about the step's eighth power
constexpr double rate_step = 0.1;        // of the rate unit: forces are quadratic in the rates but for friction
constexpr double newton_step = 1e-5;     // of differences for an equilibrium, in units
constexpr int polishing_iterations = 2;  // of a configuration that is found to 1e-12
constexpr int max_newton_iterations = 50;
constexpr double max_newton_move = 0.5;    // in units: an equilibrium is approached in such steps
constexpr double converged_force = 1e-13;  // of the force scale
constexpr double accepted_force = 1e-9;    // of the force scale: where round-off keeps Newton's method from converging
constexpr double singular_stiffness = 1e-8;      // smallest pivot of a stiffness that determines an equilibrium
constexpr double min_family_entry = 1e-3;        // of a direction in which nothing determines the reference
constexpr double constant_tolerance = 1e-8;      // of coefficients in units: smaller changes are round-off
constexpr double steady_force_tolerance = 1e-8;  // of the force scale: a motion at constant rates is one
constexpr double dependence_tolerance = 1e-9;    // of coefficients in units: smaller ones are round-off
constexpr double coefficient_round_off = 1e-13;  // of the forces that cancel in a stiffness or damping of zero
constexpr double max_followed_step = 0.1;        // of driven joints from state to state, in units
constexpr int samples_per_turn = 64;             // of coefficients that vary
constexpr std::array<double, 4> probed_fractions{0, 0.137, 0.411, 0.769};  // of a period, for what is constant

/// Configurations by coordinates that determine them: independent rates are not enough where something rolls.
class ConfigurationChart {
 public:
  virtual ~ConfigurationChart() = default;
  virtual const std::vector<CoordinateId>& further_coordinates() const = 0;
  /// All coordinates of the mechanism; false if the loops do not close.
  virtual bool solve(const VectorX& independent, const VectorX& further, VectorX& position) = 0;
};

template <class S>
class ConfigurationChartOf final : public ConfigurationChart {
 public:
  ConfigurationChartOf(const Mechanism& mechanism, const std::vector<CoordinateId>& independent, const VectorX& start)
      : mechanism_(mechanism), tree_(kinematics::compile_tree<S>(mechanism, independent)) {
    VectorX rates;
    to_tree_coordinates(mechanism, tree_, start, VectorX::Zero(start.size()), start_, rates);
    kinematics::Drive<S> drive;
    for (const CoordinateId coordinate : independent) drive.linear.push_back(tree_.coordinate_expressions[coordinate]);
    for (const int column : find_further_columns(drive)) {
      const CoordinateId coordinate = find_column_coordinates(tree_)[column];
      if (coordinate < 0) throw std::invalid_argument("modes of a mechanism in which a sphere rolls are not supported");
      further_.push_back(coordinate);
      drive.linear.push_back({{{column, 1.0}}, 0, tree_.is_length_column[column] != 0});
    }
    system_.emplace(tree_, drive);
  }

  const std::vector<CoordinateId>& further_coordinates() const override { return further_; }

  bool solve(const VectorX& independent, const VectorX& further, VectorX& position) override {
    trajectory::DriveSample target;
    target.value.resize(independent.size() + further.size());
    target.value << independent, further;
    kinematics::AssemblySolution solution = solve_assembly(*system_, start_, target);
    if (!solution.found) return false;
    for (int iteration = 0; iteration < polishing_iterations; ++iteration) polish(target, solution.y);
    const std::vector<double> all = compute_coordinates(mechanism_, tree_, solution.y);
    position = Eigen::Map<const VectorX>(all.data(), static_cast<Eigen::Index>(all.size()));
    return true;
  }

 private:
  /// An iteration of Newton's method: differences need configurations to the last digit.
  void polish(const trajectory::DriveSample& target, VectorX& y) {
    VectorX residual;
    MatrixX jacobian;
    system_->evaluate(y, target, residual, jacobian);
    const numerics::CompleteOrthogonalDecomposition solver(jacobian);
    y -= column_scale(tree_).cwiseProduct(VectorX(solver.solve(residual)));
  }

  /// Columns that closures and independent coordinates leave open.
  std::vector<int> find_further_columns(const kinematics::Drive<S>& drive) {
    kinematics::ConstraintSystem<S> system(tree_, drive);
    VectorX residual;
    MatrixX jacobian;
    trajectory::DriveSample target;
    target.value.setZero(drive.value_count());
    system.evaluate(start_, target, residual, jacobian);
    numerics::ColumnPivotingQr qr;
    qr.setThreshold(singular_stiffness);
    qr.compute(jacobian);
    std::vector<int> columns;
    for (Eigen::Index k = qr.rank(); k < jacobian.cols(); ++k) columns.push_back(qr.colsPermutation().indices()[k]);
    std::sort(columns.begin(), columns.end());
    return columns;
  }

  const Mechanism& mechanism_;
  kinematics::Tree<S> tree_;
  VectorX start_;
  std::optional<kinematics::ConstraintSystem<S>> system_;
  std::vector<CoordinateId> further_;
};

class Linearisation {
 public:
  Linearisation(const Mechanism& mechanism, const Trajectory* trajectory) {
    if (trajectory != nullptr && trajectory->free_motion)
      system_ = std::make_unique<PartlyDrivenMechanism>(mechanism, *trajectory, simulation::RateConstraints::accepted);
    else
      system_ = std::make_unique<PartlyDrivenMechanism>(mechanism, trajectory, simulation::AllFree{});
    result_.outcome = system_->outcome();
    result_.note = system_->note();
  }

  LinearMotion solve() {
    if (result_.outcome.status != MotionStatus::done) return std::move(result_);
    begin();
    if (!find_reference()) return std::move(result_);
    linearise();
    return std::move(result_);
  }

  Samples sample_force(const LinearMotion& motion, int samples) {
    if (result_.outcome.status != MotionStatus::done) throw std::invalid_argument(result_.outcome.reason);
    begin();
    result_.reference = motion.reference;
    position_ = motion.position;
    rate_ = motion.rate;
    Samples force(samples, n_);
    for (int k = 0; k < samples; ++k) {
      if (!evaluate(result_.period * k / samples, VectorX::Zero(position_.size()), VectorX::Zero(n_)))
        throw std::invalid_argument(system_->stop_reason());
      force.row(k) = equation_.force.transpose();
    }
    return force;
  }

 private:
  bool fail(MotionStatus status, const std::string& reason) {
    result_.outcome = {status, 0, reason, {}};
    return false;
  }
  bool fail_where_stopped() {
    result_.outcome = system_->stop_outcome();
    return false;
  }

  void begin() {
    n_ = system_->count();
    const Mechanism& mechanism = system_->mechanism();
    result_.period = system_->duration();
    result_.free_count = n_;
    result_.coordinates = system_->free_motion().free;
    if (has_velocity_constraints(mechanism))
      kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
        chart_ = std::make_unique<ConfigurationChartOf<S>>(mechanism, system_->driven_coordinates(), system_->start());
      });
    if (chart_)
      result_.coordinates.insert(result_.coordinates.end(), chart_->further_coordinates().begin(),
                                 chart_->further_coordinates().end());
    const auto size = static_cast<Eigen::Index>(result_.coordinates.size());
    position_.resize(size), unit_.resize(size);
    length_ = characteristic_length(mechanism);
    weight_ = 0;
    for (const Body& body : mechanism.bodies) weight_ += body.mass * mechanism.gravity.norm() * length_;
    force_scale_ = weight_;
    for (Eigen::Index k = 0; k < size; ++k) {
      const CoordinateId id = result_.coordinates[static_cast<std::size_t>(k)];
      position_[k] = system_->start()[id];
      unit_[k] = mechanism.coordinates[id].kind == CoordinateKind::length ? length_ : 1;
    }
    result_.unit = unit_;
    rate_ = VectorX::Zero(n_);
  }

  // States near the reference.

  /// Sets equation_ and following_rate_ at a deviation from the reference.
  bool evaluate(double time, const VectorX& deviation, const VectorX& rate_deviation) {
    return follow_to(time) && evaluate_near(time, deviation, rate_deviation);
  }

  /// Moves along the reference in steps that keep loops in their assembly mode.
  bool follow_to(double time) {
    if (result_.reference == Reference::rest || !system_->has_driven_motion() || chart_) return true;
    const double distance = time - time_, begin = time_;
    const int steps = static_cast<int>(std::ceil(std::abs(distance) * find_rate_scale() / max_followed_step));
    for (int k = 1; k < steps; ++k)
      if (!evaluate_near(begin + distance * k / steps, VectorX::Zero(position_.size()), VectorX::Zero(n_)))
        return false;
    return true;
  }

  bool evaluate_near(double time, const VectorX& deviation, const VectorX& rate_deviation) {
    time_ = time;
    const bool is_steady = result_.reference == Reference::steady;
    VectorX position = position_ + deviation;
    if (is_steady) position.head(n_) += time * rate_;
    const VectorX rate = rate_deviation + rate_;
    const double moment = is_steady && system_->has_driven_motion() ? time : 0;
    if (chart_ && !place_near(moment, position)) return false;
    if (!system_->set_state(
            moment, Side::after, position.head(n_), rate,
            is_steady ? PartlyDrivenMechanism::Driving::moving : PartlyDrivenMechanism::Driving::at_rest) ||
        !system_->find_equation(equation_))
      return false;
    following_rate_.resize(position.size() - n_);
    for (Eigen::Index k = n_; k < position.size(); ++k)
      following_rate_[k - n_] = system_->dynamics().velocity()[result_.coordinates[static_cast<std::size_t>(k)]];
    return true;
  }

  /// The guess of the next state.
  bool place_near(double time, const VectorX& position) {
    const std::vector<CoordinateId>& independent = system_->driven_coordinates();
    VectorX values(static_cast<Eigen::Index>(independent.size()));
    trajectory::DriveSample sample;
    if (system_->has_driven_motion()) system_->driven_motion().at(time, Side::after, sample);
    const std::vector<CoordinateId>& free = system_->free_motion().free;
    for (std::size_t k = 0; k < independent.size(); ++k) {
      const auto place = std::find(free.begin(), free.end(), independent[k]);
      values[static_cast<Eigen::Index>(k)] =
          place != free.end() ? position[place - free.begin()] : sample.value[static_cast<Eigen::Index>(k)];
    }
    VectorX all;
    if (!chart_->solve(values, position.tail(position.size() - n_), all))
      return system_->stop(time, "the loops do not close near the reference");
    system_->restart_near(all);
    return true;
  }

  VectorX zero_deviation() const { return VectorX::Zero(position_.size()); }
  VectorX scaled_force() const { return equation_.force.cwiseProduct(unit_.head(n_)); }

  // The reference.

  bool find_reference() {
    result_.reference = Reference::steady;
    rate_ = system_->free_rate();
    if (is_driven_uniformly()) {
      if (!rate_.isZero(0) && !is_motion_steady()) rate_.setZero();
      if (find_equilibrium(has_constant_force() ? 1 : samples_per_turn / 2)) return true;
      if (system_->has_driven_motion()) return false;  // the driven joints do turn
    } else if (!rate_.isZero(0)) {
      if (is_motion_steady() || (!system_->has_driven_motion() && find_equilibrium(1) && is_motion_steady()))
        return true;
      for (Eigen::Index k = 0; k < position_.size(); ++k)
        position_[k] = system_->start()[result_.coordinates[static_cast<std::size_t>(k)]];
    }
    result_.reference = Reference::rest;
    result_.outcome = system_->outcome();
    rate_.setZero();
    system_->restart_near({});
    time_ = 0;
    return find_equilibrium(1);
  }

  /// Whether driven joints move, at constant rates.
  bool is_driven_uniformly() const {
    if (!system_->has_driven_motion()) return false;
    trajectory::DriveSample start, later;
    system_->driven_motion().at(0, Side::after, start);
    bool is_moving = false;
    for (const double fraction : probed_fractions) {
      system_->driven_motion().at(fraction * system_->duration(), Side::after, later);
      const double size = numerics::max_abs(start.rate);
      is_moving = size > 0;
      if (numerics::max_abs(later.rate - start.rate) > steady_force_tolerance * size ||
          numerics::max_abs(later.acceleration) * system_->duration() > steady_force_tolerance * size)
        return false;
    }
    return is_moving;
  }

  /// Largest of the present rates, those of driven joints included.
  double find_rate_scale() {
    double scale = numerics::max_abs(rate_.cwiseQuotient(unit_.head(n_)));
    if (result_.reference == Reference::rest || !system_->has_driven_motion()) return scale;
    trajectory::DriveSample sample;
    system_->driven_motion().at(0, Side::after, sample);
    for (std::size_t k = 0; k < system_->driven_coordinates().size(); ++k) {
      const Coordinate& coordinate = system_->mechanism().coordinates[system_->driven_coordinates()[k]];
      const double unit = coordinate.kind == CoordinateKind::length ? length_ : 1;
      scale = std::max(scale, std::abs(sample.rate[static_cast<Eigen::Index>(k)]) / unit);
    }
    return scale;
  }

  /// Of the forces at the present rates, in units.
  double find_inertia_scale() {
    const double rate = find_rate_scale();
    return numerics::max_abs(in_units(equation_.mass)) * rate * rate;
  }

  /// Whether nothing accelerates the free coordinates at their rates.
  bool is_motion_steady() {
    for (const double fraction : probed_fractions) {
      if (!evaluate(fraction * result_.period, zero_deviation(), VectorX::Zero(n_))) return false;
      if (numerics::max_abs(scaled_force()) > steady_force_tolerance * std::max(force_scale_, find_inertia_scale()))
        return false;
    }
    return true;
  }

  bool has_constant_force() {
    VectorX first;
    for (const double fraction : probed_fractions) {
      if (!evaluate(fraction * result_.period, zero_deviation(), VectorX::Zero(n_))) return false;
      if (first.size() == 0) first = scaled_force();
      force_scale_ = std::max({force_scale_, numerics::max_abs(scaled_force()), find_inertia_scale()});
      if (numerics::max_abs(scaled_force() - first) > constant_tolerance * force_scale_) return false;
    }
    return true;
  }

  /// R in units, averaged over evenly spaced times.
  bool average_force(int times, const VectorX& deviation, VectorX& force) {
    force.setZero(n_);
    for (int k = 0; k < times; ++k) {
      if (!evaluate(result_.period * k / times, deviation, VectorX::Zero(n_))) return fail_where_stopped();
      force += scaled_force() / times;
    }
    return true;
  }

  /// Newton's method on the average of R; of several solutions, or where a rigid motion is possible, the nearest one.
  bool find_equilibrium(int times) {
    VectorX force, shifted;
    for (int iteration = 0; iteration < max_newton_iterations; ++iteration) {
      if (!average_force(times, zero_deviation(), force)) return false;
      MatrixX stiffness(n_, n_);
      for (Eigen::Index k = 0; k < n_; ++k) {
        VectorX deviation = zero_deviation();
        deviation[k] = newton_step * unit_[k];
        if (!average_force(times, deviation, shifted)) return false;
        stiffness.col(k) = (shifted - force) / newton_step;
      }
      force_scale_ =
          std::max({force_scale_, numerics::max_abs(force), numerics::max_abs(stiffness), find_inertia_scale()});
      name_family(stiffness);
      if (numerics::max_abs(force) <= converged_force * force_scale_) return true;
      numerics::CompleteOrthogonalDecomposition solver;
      solver.setThreshold(singular_stiffness);
      solver.compute(stiffness);
      VectorX step = solver.solve(force);
      const double size = numerics::max_abs(step);
      const bool is_final = size <= 1e-14 || iteration + 1 == max_newton_iterations;
      if (is_final || !(size > 0)) break;
      if (size > max_newton_move) step *= max_newton_move / size;
      position_.head(n_) -= step.cwiseProduct(unit_.head(n_));
    }
    if (numerics::max_abs(force) <= accepted_force * force_scale_) return true;
    return fail(
        MotionStatus::unreachable,
        "no equilibrium found: where the free coordinates are, something accelerates them; a start nearer to an "
        "equilibrium ('from', 'initial') may help");
  }

  /// Notes which coordinates could be anywhere: the reference is then one of many.
  void name_family(const MatrixX& stiffness) {
    result_.note = system_->note();
    if (n_ == 0) return;
    const numerics::SingularValueDecomposition decomposition(stiffness, Eigen::ComputeFullV);
    const double smallest = singular_stiffness * decomposition.singularValues()[0];
    std::string names;
    for (Eigen::Index k = 0; k < n_; ++k)
      for (Eigen::Index j = 0; j < n_; ++j)
        if (decomposition.singularValues()[j] <= smallest &&
            std::abs(decomposition.matrixV()(k, j)) > min_family_entry) {
          names += (names.empty() ? "" : ", ") + system_->coordinate(k).name;
          break;
        }
    if (names.empty()) return;
    result_.note += result_.note.empty() ? "" : "; ";
    result_.note += std::string(result_.reference == Reference::steady ? "the steady motion" : "the equilibrium") +
                    " is one of many, because nothing determines " + names +
                    ": the one nearest to the stated start was taken";
  }

  // Coefficients.

  void linearise() {
    if (!evaluate(0, zero_deviation(), VectorX::Zero(n_))) return void(fail_where_stopped());
    choose_rate_unit();
    std::vector<LinearCoefficients> probes;
    for (const double fraction : probed_fractions) {
      LinearCoefficients at;
      if (!find_coefficients(fraction * result_.period, at)) return void(fail_where_stopped());
      probes.push_back(std::move(at));
      if (result_.reference == Reference::rest) break;
    }
    result_.position = position_;
    result_.rate = rate_;
    drop_ignored_coordinates(probes);
    result_.coefficients = probes.front();
    if (find_variation(probes) > constant_tolerance) average_over_period();
    clear_round_off(result_.coefficients);
    for (LinearCoefficients& at : result_.samples) clear_round_off(at);
  }

  /// A stiffness that cancels leaves round-off of the forces that cancel: weight, and inertia at the rates.
  void clear_round_off(LinearCoefficients& at) const {
    if (!at.stiffness.allFinite() || !at.damping.allFinite()) return;
    const double smallest = coefficient_round_off * std::max(find_size(at), weight_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      for (Eigen::Index k = 0; k < at.stiffness.cols(); ++k)
        if (std::abs(at.stiffness(i, k)) * unit_[i] * unit_[k] <= smallest) at.stiffness(i, k) = 0;
      for (Eigen::Index k = 0; k < n_; ++k)
        if (std::abs(at.damping(i, k)) * unit_[i] * unit_[k] * rate_unit_ <= smallest) at.damping(i, k) = 0;
    }
  }

  void choose_rate_unit() {
    rate_unit_ = find_rate_scale();
    if (rate_unit_ > 0) return;
    double stiffness = 0;
    const VectorX at_rest = scaled_force();
    for (Eigen::Index k = 0; k < n_; ++k) {
      VectorX deviation = zero_deviation();
      deviation[k] = position_step * unit_[k];
      if (evaluate(0, deviation, VectorX::Zero(n_)))
        stiffness = std::max(stiffness, numerics::max_abs(scaled_force() - at_rest) / position_step);
    }
    const double inertia = numerics::max_abs(in_units(equation_.mass));
    rate_unit_ = inertia > 0 && stiffness > 0 ? std::sqrt(stiffness / inertia) : 1;
  }

  bool find_coefficients(double time, LinearCoefficients& at) {
    const Eigen::Index size = position_.size(), m = size - n_;
    if (!evaluate(time, zero_deviation(), VectorX::Zero(n_))) return false;
    at.mass = equation_.mass;
    at.force = equation_.force;
    at.stiffness.resize(n_, size), at.damping.resize(n_, n_);
    at.following_stiffness.resize(m, size), at.following_damping.resize(m, n_);
    bool is_found = true;
    const auto rates_at = [&](const VectorX& deviation, const VectorX& rate_deviation) {
      is_found = is_found && evaluate(time, deviation, rate_deviation);
      VectorX all = VectorX::Zero(size);
      if (is_found) all << equation_.force, following_rate_;
      return all;
    };
    for (Eigen::Index k = 0; k < size; ++k) {
      const VectorX direction = unit_[k] * VectorX::Unit(size, k);
      const VectorX column =
          differentiate_centrally([&](double step) { return rates_at(step * direction, VectorX::Zero(n_)); },
                                  position_step) /
          unit_[k];
      at.stiffness.col(k) = column.head(n_), at.following_stiffness.col(k) = column.tail(m);
    }
    for (Eigen::Index k = 0; k < n_; ++k) {
      const double unit = unit_[k] * rate_unit_;
      const VectorX column =
          differentiate_centrally(
              [&](double step) { return rates_at(zero_deviation(), step * unit * VectorX::Unit(n_, k)); }, rate_step) /
          unit;
      at.damping.col(k) = column.head(n_), at.following_damping.col(k) = column.tail(m);
    }
    return is_found && at.stiffness.allFinite() && at.damping.allFinite();
  }

  MatrixX in_units(const MatrixX& matrix) const {
    return unit_.head(matrix.rows()).asDiagonal() * matrix * unit_.head(matrix.cols()).asDiagonal();
  }

  /// Largest entry of mass, damping and stiffness, as forces at the rate unit.
  double find_size(const LinearCoefficients& at) const {
    return std::max({numerics::max_abs(in_units(at.mass)) * rate_unit_ * rate_unit_,
                     numerics::max_abs(in_units(at.damping)) * rate_unit_, numerics::max_abs(in_units(at.stiffness))});
  }

  double find_variation(const std::vector<LinearCoefficients>& all) const {
    double change = 0, size = 0;
    for (const LinearCoefficients& at : all) {
      const LinearCoefficients& first = all.front();
      size = std::max(size, find_size(at));
      change = std::max(
          change,
          find_size({at.mass - first.mass, at.damping - first.damping, at.stiffness - first.stiffness, {}, {}, {}}));
    }
    return size > 0 ? change / size : 0;
  }

  /// Leaves out following coordinates on which, at all times, nothing depends, one after the other.
  void drop_ignored_coordinates(std::vector<LinearCoefficients>& all) {
    const auto depends_on = [&](Eigen::Index k) {
      return std::any_of(all.begin(), all.end(), [&](const LinearCoefficients& at) {
        const double force = numerics::max_abs(at.stiffness.col(k).cwiseProduct(unit_.head(n_))) * unit_[k],
                     rate =
                         numerics::max_abs(at.following_stiffness.col(k).cwiseQuotient(unit_.tail(unit_.size() - n_))) *
                         unit_[k];
        return force > dependence_tolerance * find_size(at) || rate > dependence_tolerance * rate_unit_;
      });
    };
    for (Eigen::Index k = n_; k < unit_.size();) {
      if (depends_on(k)) {
        ++k;
        continue;
      }
      result_.ignored.push_back(result_.coordinates[static_cast<std::size_t>(k)]);
      result_.coordinates.erase(result_.coordinates.begin() + k);
      for (LinearCoefficients& at : all) {
        remove_column(at.stiffness, k), remove_column(at.following_stiffness, k);
        remove_row(at.following_stiffness, k - n_), remove_row(at.following_damping, k - n_);
      }
      for (VectorX* vector : {&unit_, &result_.position}) *vector = without_entry(*vector, k);
      k = n_;
    }
    result_.unit = unit_;
  }

  static VectorX without_entry(const VectorX& vector, Eigen::Index k) {
    VectorX rest(vector.size() - 1);
    rest << vector.head(k), vector.tail(vector.size() - k - 1);
    return rest;
  }
  static void remove_column(MatrixX& matrix, Eigen::Index k) {
    MatrixX rest(matrix.rows(), matrix.cols() - 1);
    rest << matrix.leftCols(k), matrix.rightCols(matrix.cols() - k - 1);
    matrix = std::move(rest);
  }
  static void remove_row(MatrixX& matrix, Eigen::Index k) {
    MatrixX rest(matrix.rows() - 1, matrix.cols());
    rest << matrix.topRows(k), matrix.bottomRows(matrix.rows() - k - 1);
    matrix = std::move(rest);
  }

  void average_over_period() {
    if (chart_) {
      fail(MotionStatus::mismatch,
           "the linearised equations change during the motion: of rolling mechanisms, modes are those of motions that "
           "look the same at all times");
      return;
    }
    const auto turns =
        static_cast<int>(std::clamp(std::round(rate_unit_ * result_.period / (2 * std::numbers::pi)), 1.0, 16.0));
    const int count = samples_per_turn * turns;
    LinearCoefficients& mean = result_.coefficients;
    mean = {MatrixX::Zero(n_, n_), MatrixX::Zero(n_, n_), MatrixX::Zero(n_, n_), VectorX::Zero(n_), {}, {}};
    mean.following_damping.resize(0, n_), mean.following_stiffness.resize(0, n_);
    for (int k = 0; k < count; ++k) {
      LinearCoefficients at;
      if (!find_coefficients(result_.period * k / count, at)) return void(fail_where_stopped());
      mean.mass += at.mass / count, mean.damping += at.damping / count, mean.stiffness += at.stiffness / count;
      mean.force += at.force / count;
      result_.samples.push_back(std::move(at));
    }
    result_.variation = find_variation(result_.samples);
  }

  std::unique_ptr<PartlyDrivenMechanism> system_;
  std::unique_ptr<ConfigurationChart> chart_;  ///< nullptr: the free coordinates are enough
  LinearMotion result_;
  Eigen::Index n_ = 0;
  VectorX position_, unit_;  ///< per coordinate
  VectorX rate_;             ///< per free coordinate
  double length_ = 1;        ///< the mechanism's [m]
  double weight_ = 0;        ///< times its length [N m]
  double force_scale_ = 0, rate_unit_ = 1;
  double time_ = 0;  ///< of the latest state
  FreeEquation equation_;
  VectorX following_rate_;
};

}  // namespace

LinearMotion linearise_motion(const Mechanism& mechanism, const Trajectory* trajectory) {
  return Linearisation(mechanism, trajectory).solve();
}

Samples sample_reference_force(const Mechanism& mechanism, const Trajectory& trajectory, const LinearMotion& motion,
                               int samples) {
  return Linearisation(mechanism, &trajectory).sample_force(motion, samples);
}

}  // namespace balance::vibration
