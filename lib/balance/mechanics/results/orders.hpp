#pragma once
/// Orders of a run at constant speed: f(θ) = a₀ + Σ aₙ cos nθ + bₙ sin nθ over the angle θ of a coordinate that turns
/// uniformly. An order n repeats n times per turn; a run of several turns has fractions of an order as well.

#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/results/speed_fluctuation.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::results {

/// What is meant of an order: all of it, or, of a vector in the plane, its part that turns with θ or against it.
enum class OrderPart { whole, forward, backward };

/// "order", "forward order", "backward order".
const char* name_of(OrderPart part);

/// Orders of a scalar or of a vector with all its components.
struct QuantityOrders {
  std::string quantity;                 ///< "shaking_force", "torque[A]"
  std::string unit;                     ///< SI
  std::vector<std::string> components;  ///< "x", "y"; empty: a scalar
  VectorX mean;                         ///< a₀ per component
  MatrixX cosine, sine;                 ///< aₙ and bₙ, orders × components
  double variance = 0;                  ///< mean square of the difference from the mean, all components together
  double round_off = 0;                 ///< amplitudes up to this are round-off

  /// Amplitude of one component, √(aₙ² + bₙ²): a peak value.
  double amplitude(Eigen::Index order, Eigen::Index component) const;
  /// Largest magnitude of an order's part: of a scalar its amplitude, of a vector the major semi-axis of its ellipse.
  double peak(Eigen::Index order) const;
  /// Part of the mean square of everything that varies, 0 to 1.
  double share(Eigen::Index order) const;
};

struct OrderAnalysis {
  UniformTurning turning;
  std::vector<double> orders;  ///< k/turns, increasing
  std::vector<QuantityOrders> quantities;
  std::optional<SpeedFluctuation> fluctuation;  ///< of a machine with a single actuator
};

/// The first actuated coordinate that turns uniformly, by whole turns from start to end; else the first one of all.
/// @throws std::invalid_argument if there is none. The message is suitable for users.
UniformTurning find_uniform_turning(const RunResult& run);

/// Orders of all recorded forces, moments, efforts, powers, energies, positions, velocities and accelerations that repeat
/// from turn to turn. The last sample, which repeats the first one, is left out.
/// @param highest order, at least 1
/// @param stated coefficient of fluctuation for which a flywheel is wanted (speed_fluctuation.hpp)
/// @throws std::invalid_argument as find_uniform_turning(), or if there are fewer than four samples per period of the
///         highest order, or if the run does not repeat: force, moments, efforts or positions at its end differ from
///         those at its start by more than 1e-9 of their range. The message is suitable for users.
OrderAnalysis analyse_orders(const RunResult& run, int highest, std::optional<double> stated = {});

/// Cosine and sine of order · θ at the samples of a run, but for the last one.
struct Harmonic {
  VectorX cosine, sine;

  /// @param angle θ per sample [rad]
  Harmonic(const VectorX& angle, double order);
};

/// QuantityOrders::peak() of one order of one quantity of a run, or the radius of its part (RotatingParts); round-off is 0.
/// @param order positive, a multiple of the reciprocal of the run's turns
/// @throws std::invalid_argument as analyse_orders(), or if a run of so many turns does not have the order, or for a part of
///         what is no vector in the plane
double compute_order_peak(const RunResult& run, const MetricSeries& series, double order,
                          OrderPart part = OrderPart::whole);

/// Whether a run of so many whole turns has an order: a multiple of 1/turns.
bool has_order(double order, int turns);
/// Samples that the highest order needs in a run of so many turns, both ends included.
long count_needed_samples(double order, int turns);
/// "2", "0.5"
std::string format_order(double order);

// Rotating parts of a vector in the plane.

/// Parts of an order that turn with θ and against it: amplitudes of the circles whose sum is the order's ellipse.
struct RotatingParts {
  double forward = 0, backward = 0;
};

/// @param orders of a vector with components x and y
RotatingParts split_rotation(const QuantityOrders& orders, Eigen::Index order);

}  // namespace balance::results
