#include "balance/motion/vibration/forced_response.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/motion/simulation/partly_driven_mechanism.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/vibration/central_differences.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace balance::vibration {

using results::QuantityOrders;
using results::UniformTurning;
using simulation::PartlyDrivenMechanism;
using trajectory::Side;
using Complex = std::complex<double>;
using ComplexMatrix = Eigen::MatrixXcd;

namespace {

constexpr double whole_turns_tolerance = 1e-9, uniform_speed_tolerance = 1e-9;
constexpr int samples_per_harmonic = 8, min_samples = 128;  // of the reference's force
constexpr int coupled_orders = 12;                          // beyond those asked for, where the coefficients vary
constexpr double direction_step = 0.02;  // of differences along the response, in units: quantities are smooth functions
constexpr double round_off_share = 1e-13;
constexpr double shooting_accuracy = 1e-12;  // of an order: smaller differences are round-off
constexpr double still_share = 1e-11;        // of a unit: ten times the accuracy of shooting
constexpr double unexcited_share = 1e-11;    // of all harmonics of the force: smaller ones are round-off

/// f_k = (1/N) Σ f_j e^{−2πi jk/N}, for k from 0 to `highest`; one row each.
ComplexMatrix fourier_coefficients(const Samples& samples, int highest) {
  const Eigen::Index count = samples.rows();
  ComplexMatrix result = ComplexMatrix::Zero(highest + 1, samples.cols());
  for (Eigen::Index j = 0; j < count; ++j)
    for (int k = 0; k <= highest; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(j * k % count) / static_cast<double>(count);
      result.row(k) += Complex(elementary::cos(angle), -elementary::sin(angle)) / static_cast<double>(count) *
                       samples.row(j).cast<Complex>();
    }
  return result;
}

/// One matrix at all times, or its Fourier coefficients.
class PeriodicMatrix {
 public:
  PeriodicMatrix(const LinearMotion& motion, MatrixX LinearCoefficients::*member, int highest)
      : mean_(motion.coefficients.*member) {
    if (motion.samples.empty()) return;
    Samples entries(static_cast<Eigen::Index>(motion.samples.size()), mean_.size());
    for (std::size_t j = 0; j < motion.samples.size(); ++j)
      entries.row(static_cast<Eigen::Index>(j)) = (motion.samples[j].*member).reshaped().transpose();
    highest_ = std::min(highest, static_cast<int>(motion.samples.size()) / 2 - 1);
    harmonics_ = fourier_coefficients(entries, highest_);
  }

  /// Of harmonic k, of either sign.
  ComplexMatrix at(int k) const {
    if (k == 0) return mean_.cast<Complex>();
    if (std::abs(k) > highest_) return ComplexMatrix::Zero(mean_.rows(), mean_.cols());
    ComplexMatrix matrix = harmonics_.row(std::abs(k)).reshaped(mean_.rows(), mean_.cols());
    return k > 0 ? matrix : matrix.conjugate();
  }

 private:
  MatrixX mean_;
  int highest_ = 0;
  ComplexMatrix harmonics_;
};

/// X_k for k from 0 to `highest`, one row each, in units. At an undamped resonance that nothing excites the vibration of
/// no amplitude is chosen.
/// @return what an undamped resonance is excited by: a harmonic, or the highest one if they are coupled; none: solved
std::optional<int> solve_harmonic_balance(const LinearMotion& motion, const ComplexMatrix& force, double omega,
                                          int highest, ComplexMatrix& response) {
  const Eigen::Index n = motion.free_count;
  const PeriodicMatrix mass(motion, &LinearCoefficients::mass, 2 * highest),
      damping(motion, &LinearCoefficients::damping, 2 * highest),
      stiffness(motion, &LinearCoefficients::stiffness, 2 * highest);
  const auto block = [&](int j, int k) -> ComplexMatrix {
    const double rate = k * omega;
    return motion.unit.asDiagonal() *
           ComplexMatrix(stiffness.at(j - k) + Complex(0, rate) * damping.at(j - k) - rate * rate * mass.at(j - k)) *
           motion.unit.asDiagonal();
  };
  response.setZero(highest + 1, n);
  if (motion.samples.empty()) {
    const double unexcited = unexcited_share * (motion.unit.asDiagonal() * force.transpose()).norm();
    for (int k = 0; k <= highest; ++k) {
      const ComplexMatrix dynamic_stiffness = block(k, k);
      const Eigen::FullPivLU<ComplexMatrix> solver(dynamic_stiffness);
      const Eigen::VectorXcd right = -(motion.unit.asDiagonal() * force.row(k).transpose()),
                             solution = solver.solve(right);
      if (solver.isInvertible() || (dynamic_stiffness * solution - right).norm() <= unexcited)
        response.row(k) = solution.transpose();
      else if (k > 0)
        return k;
    }
    return {};
  }
  const int count = 2 * highest + 1;
  ComplexMatrix system(n * count, n * count);
  Eigen::VectorXcd right(n * count);
  for (int j = -highest; j <= highest; ++j) {
    const Eigen::VectorXcd row = motion.unit.asDiagonal() * force.row(std::abs(j)).transpose();
    right.segment(n * (j + highest), n) = j >= 0 ? Eigen::VectorXcd(-row) : Eigen::VectorXcd(-row.conjugate());
    for (int k = -highest; k <= highest; ++k) system.block(n * (j + highest), n * (k + highest), n, n) = block(j, k);
  }
  const Eigen::FullPivLU<ComplexMatrix> solver(system);
  if (!solver.isInvertible()) return highest;
  const Eigen::VectorXcd all = solver.solve(right);
  for (int k = 0; k <= highest; ++k) response.row(k) = all.segment(n * (k + highest), n).transpose();
  return {};
}

/// Σ X_k (ikω)^derivative e^{ikωt} with both signs of k, at evenly spaced times.
Samples evaluate_series(const ComplexMatrix& harmonics, double omega, int derivative, int count) {
  Samples samples = Samples::Zero(count, harmonics.cols());
  for (int j = 0; j < count; ++j)
    for (int k = 0; k < harmonics.rows(); ++k) {
      const double angle = 2 * std::numbers::pi * (static_cast<long>(j) * k % count) / count;
      Complex factor(elementary::cos(angle), elementary::sin(angle));
      for (int d = 0; d < derivative; ++d) factor *= Complex(0, k * omega);
      samples.row(j) += (k == 0 ? 1 : 2) * (factor * harmonics.row(k)).real();
    }
  return samples;
}

/// What the response consists of, one column per number.
class ResponseQuantities {
 public:
  ResponseQuantities(const Mechanism& mechanism, std::size_t actuators) : actuators_(actuators), mechanism_(mechanism) {
    is_planar_ = mechanism.space == SpaceKind::planar;
  }

  Eigen::Index size() const { return force_count() + moment_count() + static_cast<Eigen::Index>(actuators_); }
  Eigen::Index force_count() const { return is_planar_ ? 2 : 3; }
  Eigen::Index moment_count() const { return is_planar_ ? 1 : 3; }

  VectorX read(const Sample& sample) const {
    VectorX numbers(size());
    numbers << sample.ground_force.head(force_count()),
        (is_planar_ ? VectorX(sample.ground_moment.tail(1)) : VectorX(sample.ground_moment)),
        sample.effort.head(static_cast<Eigen::Index>(actuators_));
    return numbers;
  }

  /// Without any numbers: names, units and which columns they have.
  struct Entry {
    QuantityOrders orders;
    Eigen::Index first, count;
  };
  std::vector<Entry> list() const {
    std::vector<std::string> axes{"x", "y", "z"};
    std::vector<Entry> entries;
    const std::vector<std::string> force_axes(axes.begin(), axes.begin() + force_count());
    entries.push_back({named("ground_force", "N", force_axes), 0, force_count()});
    entries.push_back(
        {named("ground_moment", "N m", is_planar_ ? std::vector<std::string>{} : axes), force_count(), moment_count()});
    for (std::size_t a = 0; a < actuators_; ++a) {
      const Coordinate& coordinate = mechanism_.coordinates[mechanism_.actuators[a]];
      entries.push_back(
          {named("torque[" + coordinate.name + "]", coordinate.kind == CoordinateKind::length ? "N" : "N m", {}),
           force_count() + moment_count() + static_cast<Eigen::Index>(a), 1});
    }
    return entries;
  }

  static QuantityOrders named(const std::string& name, const std::string& unit, std::vector<std::string> components) {
    QuantityOrders orders;
    orders.quantity = name, orders.unit = unit, orders.components = std::move(components);
    return orders;
  }

 private:
  std::size_t actuators_;
  const Mechanism& mechanism_;
  bool is_planar_;
};

/// Evaluates forces and torques with all coordinates prescribed.
class PrescribedStates {
 public:
  PrescribedStates(const PartlyDrivenMechanism& system, const Trajectory& trajectory)
      : system_(system), mechanism_(system.mechanism()) {
    for (const CoordinateId coordinate : system.free_motion().free) mechanism_.actuators.push_back(coordinate);
    dynamics::InverseOptions options;
    options.about = trajectory.about;
    options.time_scale = system.duration();
    for (const CoordinateId coordinate : system.driven_coordinates())
      options.independent.push_back(mechanism_.coordinates[coordinate].name);
    inverse_.emplace(mechanism_, options);
    std::vector<dynamics::CoordinateGuess> near;
    for (Eigen::Index c = 0; c < system.start().size(); ++c)
      near.push_back({mechanism_.coordinates[static_cast<std::size_t>(c)].name, system.start()[c]});
    set_driven(0);
    require(inverse_->assemble(value_, near).outcome);
  }

  VectorX evaluate(double time, const VectorX& position, const VectorX& rate, const VectorX& acceleration,
                   const ResponseQuantities& quantities) {
    set_driven(time);
    const std::vector<CoordinateId>& free = system_.free_motion().free;
    for (std::size_t k = 0; k < system_.driven_coordinates().size(); ++k) {
      const auto place = std::find(free.begin(), free.end(), system_.driven_coordinates()[k]);
      if (place == free.end()) continue;
      const auto f = place - free.begin(), i = static_cast<std::ptrdiff_t>(k);
      value_[i] = position[f], rate_[i] = rate[f], acceleration_[i] = acceleration[f];
    }
    const Expected<Sample> found = inverse_->at(value_, rate_, acceleration_, time);
    require(found.outcome);
    return quantities.read(found.value);
  }

 private:
  void set_driven(double time) {
    system_.driven_motion().at(time, Side::after, sample_);
    value_ = sample_.value, rate_ = sample_.rate, acceleration_ = sample_.acceleration;
    const std::vector<CoordinateId>& free = system_.free_motion().free;
    const VectorX start = system_.free_start();
    for (std::size_t k = 0; k < system_.driven_coordinates().size(); ++k)
      if (const auto place = std::find(free.begin(), free.end(), system_.driven_coordinates()[k]); place != free.end())
        value_[static_cast<Eigen::Index>(k)] = start[place - free.begin()];
  }
  static void require(const MotionOutcome& outcome) {
    if (outcome.status != MotionStatus::done) throw std::invalid_argument(outcome.reason);
  }

  const PartlyDrivenMechanism& system_;
  Mechanism mechanism_;
  std::optional<InverseDynamics> inverse_;
  trajectory::DriveSample sample_;
  VectorX value_, rate_, acceleration_;
};

/// Orders over the angle θ = θ₀ ± turns ω t.
class OrderFit {
 public:
  OrderFit(const UniformTurning& turning, double start, std::size_t orders)
      : turning_(turning), start_(start), orders_(static_cast<Eigen::Index>(orders)) {}

  void fit(const ComplexMatrix& harmonics, QuantityOrders& result) const {
    result.mean = harmonics.row(0).real().transpose();
    result.cosine.setZero(orders_, harmonics.cols()), result.sine = result.cosine;
    result.variance = 0;
    for (Eigen::Index k = 1; k < harmonics.rows(); ++k) result.variance += 2 * harmonics.row(k).squaredNorm();
    for (Eigen::Index k = 1; k <= orders_; ++k) {
      // 2 Re(X e^{ikωt}) with kωt = ± n (θ − θ₀)
      const double order = static_cast<double>(k) / turning_.turns, angle = order * start_;
      for (Eigen::Index c = 0; c < harmonics.cols(); ++c) {
        const Complex harmonic = turning_.speed > 0 ? harmonics(k, c) : std::conj(harmonics(k, c));
        const Complex amplitude = 2.0 * harmonic * Complex(elementary::cos(angle), -elementary::sin(angle));
        result.cosine(k - 1, c) = amplitude.real(), result.sine(k - 1, c) = -amplitude.imag();
      }
    }
  }

 private:
  UniformTurning turning_;
  double start_;
  Eigen::Index orders_;
};

void suppress_round_off(QuantityOrders& quantity) {
  for (Eigen::Index k = 0; k < quantity.cosine.rows(); ++k)
    if (quantity.peak(k) <= quantity.round_off) quantity.cosine.row(k).setZero(), quantity.sine.row(k).setZero();
}

const QuantityOrders* find_quantity(const std::vector<QuantityOrders>& list, const std::string& name) {
  const auto match =
      std::find_if(list.begin(), list.end(), [&](const QuantityOrders& one) { return one.quantity == name; });
  return match == list.end() ? nullptr : &*match;
}

/// Whether a free coordinate moves by no more than the accuracy of a start that is found by shooting. Such a motion need
/// not repeat itself.
bool is_still(const RunResult& run, const QuantityOrders& linear) {
  for (std::size_t c = 0; c < run.coordinate_names.size(); ++c) {
    if (linear.quantity != "joint_position[" + run.coordinate_names[c] + "]") continue;
    const auto column = run.joint_position.col(static_cast<Eigen::Index>(c));
    return numerics::max_coefficient(column) - numerics::min_coefficient(column) <=
           still_share / round_off_share * linear.round_off;
  }
  return false;
}

void find_exact_response(const Mechanism& mechanism, Trajectory trajectory, int samples, const ResponseOptions& options,
                         ForcedResponse& response) {
  trajectory.free_motion->start = trajectory::FreeStart::periodic;
  trajectory.samples = samples + 1;
  try {
    const RunResult run = simulation::simulate(mechanism, trajectory);
    response.exact_outcome = run.outcome;
    if (run.outcome.status != MotionStatus::done) return;
    const results::OrderAnalysis analysis = results::analyse_orders(run, options.highest_order);
    for (const QuantityOrders& linear : response.linear) {
      if (is_still(run, linear)) {
        QuantityOrders& still = response.exact.emplace_back(linear);
        still.cosine.setZero(), still.sine.setZero();
      } else if (const QuantityOrders* exact = find_quantity(analysis.quantities, linear.quantity)) {
        suppress_round_off(response.exact.emplace_back(*exact));
      } else {
        response.exact.clear();
        response.exact_outcome = {MotionStatus::unreachable, 0, linear.quantity + " does not repeat", {}};
        return;
      }
    }
  } catch (const std::invalid_argument& error) {
    response.exact.clear();
    response.exact_outcome = {MotionStatus::mismatch, 0, error.what(), {}};
  }
}

}  // namespace

double ForcedResponse::transmissibility(Eigen::Index order) const {
  const double exciting = excitation.peak(order);
  const QuantityOrders* force = find_quantity(linear, "ground_force");
  if (force == nullptr || !(exciting > excitation.round_off)) return std::numeric_limits<double>::quiet_NaN();
  return force->peak(order) / exciting;
}

double ForcedResponse::difference(Eigen::Index quantity, Eigen::Index order) const {
  const QuantityOrders &approximate = linear[static_cast<std::size_t>(quantity)],
                       &true_orders = exact[static_cast<std::size_t>(quantity)];
  double largest = 0;
  for (Eigen::Index k = 0; k < true_orders.cosine.rows(); ++k) largest = std::max(largest, true_orders.peak(k));
  if (largest > 0) {
    const double share = std::abs(approximate.peak(order) - true_orders.peak(order)) / largest;
    return share > shooting_accuracy ? share : 0;
  }
  return approximate.peak(order) > 0 ? std::numeric_limits<double>::quiet_NaN() : 0;
}

std::optional<UniformTurning> find_driven_turning(const Mechanism& mechanism, const Trajectory& trajectory) {
  const PartlyDrivenMechanism system(mechanism, trajectory, simulation::RateConstraints::accepted);
  if (system.outcome().status != MotionStatus::done) return {};
  trajectory::DriveSample start, end;
  system.driven_motion().at(0, Side::after, start);
  system.driven_motion().at(system.duration(), Side::before, end);
  std::vector<CoordinateId> candidates = mechanism.actuators;
  for (const CoordinateId coordinate : system.driven_coordinates()) candidates.push_back(coordinate);
  for (const CoordinateId candidate : candidates) {
    const std::vector<CoordinateId>& driven = system.driven_coordinates();
    const auto place = std::find(driven.begin(), driven.end(), candidate);
    if (place == driven.end() || mechanism.coordinates[candidate].kind != CoordinateKind::angle) continue;
    const auto k = place - driven.begin();
    const double speed = start.rate[k], turns = speed * system.duration() / (2 * std::numbers::pi);
    if (speed == 0 || std::abs(end.rate[k] - speed) > uniform_speed_tolerance * std::abs(speed)) continue;
    const double whole = std::round(std::abs(turns));
    if (whole >= 1 && std::abs(std::abs(turns) - whole) <= whole_turns_tolerance * whole)
      return UniformTurning{mechanism.coordinates[candidate].name, speed, static_cast<int>(whole)};
  }
  return {};
}

namespace {

ForcedResponse respond(const Mechanism& mechanism, const Trajectory& trajectory, const LinearMotion& motion,
                       const UniformTurning& turning, const ResponseOptions& options) {
  ForcedResponse response;
  response.turning = turning;
  response.outcome = {MotionStatus::done, 0, "", {}};
  const int orders = options.highest_order * turning.turns;
  for (int k = 1; k <= orders; ++k) response.orders.push_back(static_cast<double>(k) / turning.turns);
  const int harmonics = motion.samples.empty() ? orders : orders + coupled_orders * turning.turns;
  const int count = std::max(min_samples, samples_per_harmonic * harmonics);
  const double omega = 2 * std::numbers::pi / motion.period;

  const PartlyDrivenMechanism system(mechanism, trajectory);
  const ComplexMatrix force =
      fourier_coefficients(sample_reference_force(mechanism, trajectory, motion, count), harmonics);
  ComplexMatrix free;
  if (const std::optional<int> resonant = solve_harmonic_balance(motion, force, omega, harmonics, free)) {
    const std::string reason = "an undamped vibration in resonance grows without bounds";
    response.outcome = {MotionStatus::unreachable,
                        0,
                        motion.samples.empty()
                            ? reason + ": order " +
                                  results::format_order(static_cast<double>(*resonant) / turning.turns) + " of " +
                                  turning.coordinate + " excites it"
                            : reason,
                        {}};
    return response;
  }
  // quantities along the response, linear in it
  const Samples deviation = evaluate_series(free, omega, 0, count), rate = evaluate_series(free, omega, 1, count),
                acceleration = evaluate_series(free, omega, 2, count);
  double size = 0;
  for (Eigen::Index k = 0; k < motion.free_count; ++k) size = std::max(size, numerics::max_abs(deviation.col(k)));
  const double step = size > 0 ? direction_step / size : 0;
  const ResponseQuantities quantities(system.mechanism(), mechanism.actuators.size());
  PrescribedStates states(system, trajectory);
  Samples held(count, quantities.size()), linear(count, quantities.size());
  for (int j = 0; j < count; ++j) {
    const double time = motion.period * j / count;
    const auto at = [&](double factor) {
      const auto part = [&](const Samples& series) {
        return VectorX(factor * series.row(j).transpose().cwiseProduct(motion.unit));
      };
      return states.evaluate(time, motion.position + part(deviation), part(rate), part(acceleration), quantities);
    };
    held.row(j) = at(0).transpose();
    linear.row(j) = held.row(j);
    if (step > 0) linear.row(j) += differentiate_centrally(at, step).transpose();
  }
  const CoordinateId base = static_cast<CoordinateId>(
      std::find_if(mechanism.coordinates.begin(), mechanism.coordinates.end(),
                   [&](const Coordinate& coordinate) { return coordinate.name == turning.coordinate; }) -
      mechanism.coordinates.begin());
  const OrderFit fit(turning, system.start()[base], response.orders.size());
  for (Eigen::Index k = 0; k < motion.free_count; ++k) {
    const Coordinate& coordinate = system.coordinate(k);
    QuantityOrders of = ResponseQuantities::named("joint_position[" + coordinate.name + "]",
                                                  coordinate.kind == CoordinateKind::length ? "m" : "rad", {});
    fit.fit(free.col(k) * motion.unit[k], of);
    of.mean[0] += motion.position[k];
    of.round_off = round_off_share * motion.unit[k];
    suppress_round_off(of);
    response.linear.push_back(std::move(of));
  }
  const ComplexMatrix linear_harmonics = fourier_coefficients(linear, harmonics),
                      held_harmonics = fourier_coefficients(held, harmonics);
  // forces, and moments by the mechanism's length, whose terms may cancel
  const double length = characteristic_length(system.mechanism());
  double largest_force = 0;
  for (const ResponseQuantities::Entry& entry : quantities.list())
    largest_force = std::max(largest_force, numerics::max_abs(held.middleCols(entry.first, entry.count)) /
                                                (entry.orders.unit == "N" ? 1 : length));
  for (ResponseQuantities::Entry& entry : quantities.list()) {
    const double scale = largest_force * (entry.orders.unit == "N" ? 1 : length);
    entry.orders.round_off =
        round_off_share *
        std::max(scale, static_cast<double>(count) * numerics::max_abs(held.middleCols(entry.first, entry.count)));
    if (entry.orders.quantity == "ground_force") {
      response.excitation = entry.orders;
      fit.fit(held_harmonics.middleCols(entry.first, entry.count), response.excitation);
      suppress_round_off(response.excitation);
    }
    fit.fit(linear_harmonics.middleCols(entry.first, entry.count), entry.orders);
    suppress_round_off(entry.orders);
    response.linear.push_back(std::move(entry.orders));
  }
  if (options.is_exact) find_exact_response(mechanism, trajectory, count, options, response);
  return response;
}

}  // namespace

std::optional<ForcedResponse> find_forced_response(const Mechanism& mechanism, const Trajectory* trajectory,
                                                   const LinearMotion& motion, const ResponseOptions& options) {
  if (trajectory == nullptr || !trajectory->free_motion || motion.outcome.status != MotionStatus::done ||
      motion.reference != Reference::steady || has_velocity_constraints(mechanism))
    return {};
  const std::optional<UniformTurning> turning = find_driven_turning(mechanism, *trajectory);
  if (!turning) return {};
  return respond(mechanism, *trajectory, motion, *turning, options);
}

}  // namespace balance::vibration
