#include "balance/motion/control/default_gains.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

namespace balance::control {

namespace {

constexpr double max_damping_fraction = 0.25;  // bound on kd · period / (2 · smallest inertia along the motion)
constexpr double difference_step =
    1e-5;  // for finite differences, in radians or characteristic lengths, and these per second
constexpr double frequency_ratio = 1.25;  // of two successive trial frequencies
constexpr int max_frequencies = 49;
constexpr double max_frequency_times_period = 1;  // bound on ω · period

/// The loop at one state of the motion, for small deviations x = (δq, δν) of the independent coordinates.
struct OperatingPoint {
  VectorX inertia;           ///< of each controlled quantity alone
  MatrixX plant;             ///< 2d×2d: ẋ = plant · x + input · δu
  MatrixX input;             ///< 2d×A
  MatrixX output;            ///< C×d: the controlled quantities
  MatrixX actuation;         ///< A×C: efforts that are equivalent to forces on the controlled quantities
  MatrixX gravity_feedback;  ///< A×d: derivative of the efforts that hold the model with respect to the pose
};

MatrixX compute_matrix_exponential(MatrixX A) {
  int halvings = 0;
  for (; numerics::max_abs(A.cwiseAbs().rowwise().sum()) > 0.25 && halvings < 60; ++halvings) A /= 2;
  MatrixX sum = MatrixX::Identity(A.rows(), A.cols()), term = sum;
  for (int k = 1; k <= 12; ++k) sum += term = term * A / k;
  for (; halvings > 0; --halvings) sum = sum * sum;
  return sum;
}

/// The largest magnitude of an eigenvalue, by repeated squaring.
double spectral_radius(MatrixX A) {
  double logarithm = 0;
  for (int k = 0; k < 30; ++k) {
    const double size = A.norm();
    if (!(size > 0)) return 0;
    if (!std::isfinite(size)) return INFINITY;
    logarithm += elementary::log(size) / std::ldexp(1.0, k);
    A /= size;
    A = A * A;
  }
  return elementary::exp(logarithm);
}

class LinearisedPlant {
 public:
  LinearisedPlant(const Mechanism& believed, const Controller& controller, const TaskSpeeds* task)
      : mechanism_(frictionless(believed)),
        controller_(controller),
        task_(task),
        length_(characteristic_length(believed)),
        model_(mechanism_, {.preferred = mechanism_.actuators}) {}

  int freedoms() const { return model_.freedoms(); }

  /// @return std::nullopt if the model cannot be evaluated there
  std::optional<OperatingPoint> linearise(const DesiredState& state) {
    if (!set_state(state.position, state.velocity)) return {};
    const std::vector<CoordinateId> independent = model_.independent();
    const dynamics::EquationOfMotion equation = model_.equation();
    const dynamics::Transformation transformation = model_.transformation();
    const auto d = static_cast<Eigen::Index>(independent.size()), motors = equation.input.cols();
    OperatingPoint point;
    const Eigen::LLT<MatrixX> mass(equation.mass);
    if (mass.info() != Eigen::Success) return {};
    const MatrixX input_acceleration = mass.solve(equation.input);
    point.output = controlled_rows(state, transformation.matrix);
    const MatrixX forces = point.output.transpose();
    point.inertia = (point.output * mass.solve(forces)).diagonal().cwiseInverse();
    if (motors < d) return point;
    point.actuation = task_ == nullptr
                          ? MatrixX(MatrixX::Identity(motors, motors))
                          : MatrixX(numerics::CompleteOrthogonalDecomposition(equation.input).solve(forces));
    VectorX rate_change(d);
    for (Eigen::Index k = 0; k < d; ++k) rate_change[k] = state.acceleration[independent[static_cast<std::size_t>(k)]];
    const VectorX efforts =
        numerics::CompleteOrthogonalDecomposition(equation.input).solve(equation.mass * rate_change + equation.bias);
    point.plant = MatrixX::Zero(2 * d, 2 * d);
    point.plant.topRightCorner(d, d).setIdentity();
    point.input = MatrixX::Zero(2 * d, motors);
    point.input.bottomRows(d) = input_acceleration;
    point.gravity_feedback = MatrixX::Zero(motors, d);
    for (Eigen::Index k = 0; k < d; ++k) {
      const double step = difference_step * unit(independent[static_cast<std::size_t>(k)]);
      const VectorX perturbation = step * transformation.matrix.col(k),
                    zero_velocity = VectorX::Zero(state.velocity.size());
      VectorX plus, minus, rate_plus, rate_minus;
      if (!acceleration_at(state.position + perturbation, state.velocity, efforts, independent, plus) ||
          !acceleration_at(state.position - perturbation, state.velocity, efforts, independent, minus) ||
          !acceleration_at(state.position, state.velocity + perturbation, efforts, independent, rate_plus) ||
          !acceleration_at(state.position, state.velocity - perturbation, efforts, independent, rate_minus))
        return {};
      point.plant.col(k).tail(d) = (plus - minus) / (2 * step);
      point.plant.col(d + k).tail(d) = (rate_plus - rate_minus) / (2 * step);
      if (controller_.gravity == study::GravityCompensation::ignored) continue;
      if (!gravity_efforts_at(state.position + perturbation, zero_velocity, plus) ||
          !gravity_efforts_at(state.position - perturbation, zero_velocity, minus))
        return {};
      point.gravity_feedback.col(k) = (plus - minus) / (2 * step);
    }
    return point;
  }

 private:
  /// Rates of the controlled quantities for each column of motions.
  MatrixX controlled_rows(const DesiredState& state, const MatrixX& motions) const {
    if (task_ != nullptr) return task_->directions(state.position, motions);
    MatrixX rows(static_cast<Eigen::Index>(mechanism_.actuators.size()), motions.cols());
    for (Eigen::Index a = 0; a < rows.rows(); ++a)
      rows.row(a) = motions.row(mechanism_.actuators[static_cast<std::size_t>(a)]);
    return rows;
  }

  static Mechanism frictionless(Mechanism mechanism) {
    mechanism.friction.clear();
    std::erase_if(mechanism.force_elements, [](const ForceElement& element) { return element.is_damper(); });
    return mechanism;
  }

  double unit(CoordinateId coordinate) const {
    return mechanism_.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::length ? length_ : 1;
  }

  bool set_state(const VectorX& position, const VectorX& velocity) {
    return model_.set_state(0, position, velocity).status == MotionStatus::done;
  }

  bool acceleration_at(const VectorX& position, const VectorX& velocity, const VectorX& efforts,
                       const std::vector<CoordinateId>& independent, VectorX& out) {
    if (!set_state(position, velocity) || model_.independent() != independent) return false;
    const dynamics::EquationOfMotion equation = model_.equation();
    out = Eigen::LLT<MatrixX>(equation.mass).solve(equation.input * efforts - equation.bias);
    return out.allFinite();
  }

  bool gravity_efforts_at(const VectorX& position, const VectorX& none, VectorX& out) {
    if (!set_state(position, none)) return false;
    const dynamics::EquationOfMotion equation = model_.equation();
    out = numerics::CompleteOrthogonalDecomposition(equation.input).solve(equation.bias);
    return out.allFinite();
  }

  const Mechanism mechanism_;
  const Controller& controller_;
  const TaskSpeeds* task_;
  double length_;
  dynamics::ForwardDynamics model_;
};

/// Spectral radius of the map (x, last measured position) → the same one period later, with efforts held.
double compute_closed_loop_spectral_radius(const OperatingPoint& point, const Controller& controller, const VectorX& kp,
                                           const VectorX& kd) {
  const Eigen::Index n = point.plant.rows(), d = n / 2, motors = point.input.cols(), controlled = point.output.rows();
  MatrixX augmented = MatrixX::Zero(n + motors, n + motors);
  augmented.topLeftCorner(n, n) = point.plant * controller.period;
  augmented.topRightCorner(n, motors) = point.input * controller.period;
  const MatrixX transition = compute_matrix_exponential(augmented);
  const bool uses_difference = controller.measurement.velocity == study::VelocitySource::difference;
  const MatrixX damping = point.actuation * kd.asDiagonal();
  MatrixX feedback = MatrixX::Zero(motors, n + controlled);
  feedback.leftCols(d) = point.gravity_feedback - point.actuation * kp.asDiagonal() * point.output;
  if (uses_difference) {
    feedback.leftCols(d) -= damping * point.output / controller.period;
    feedback.rightCols(controlled) = damping / controller.period;
  } else {
    feedback.middleCols(d, d) = -damping * point.output;
  }
  MatrixX period_map = MatrixX::Zero(n + controlled, n + controlled);
  period_map.topRows(n) = transition.block(0, n, n, motors) * feedback;
  period_map.topLeftCorner(n, n) += transition.topLeftCorner(n, n);
  period_map.bottomLeftCorner(controlled, d) = point.output;
  return spectral_radius(period_map);
}

std::string other_bandwidth(const Controller& controller, double frequency) {
  char text[200];
  std::snprintf(text, sizeof text,
                ": the default gains are for a bandwidth of %.3g Hz, since those for %.3g Hz would not be stable "
                "throughout the motion at this sample rate",
                frequency / (2 * std::numbers::pi), controller.natural_frequency() / (2 * std::numbers::pi));
  return controller.name + text;
}

}  // namespace

PdGains default_pd_gains(const Mechanism& believed, const Controller& controller,
                         const std::vector<DesiredState>& states, const TaskSpeeds* task) {
  LinearisedPlant model(believed, controller, task);
  std::vector<OperatingPoint> operating_points;
  for (const DesiredState& state : states)
    if (std::optional<OperatingPoint> point = model.linearise(state)) operating_points.push_back(std::move(*point));
  const Eigen::Index controlled = task != nullptr ? task->size() : static_cast<Eigen::Index>(believed.actuators.size());
  PdGains best;
  VectorX max_inertia = VectorX::Zero(controlled), min_inertia = VectorX::Constant(controlled, INFINITY);
  for (const OperatingPoint& point : operating_points) {
    max_inertia = max_inertia.cwiseMax(point.inertia);
    min_inertia = min_inertia.cwiseMin(point.inertia);
  }
  const double nominal = controller.natural_frequency();
  double min_spectral_radius = INFINITY, best_frequency = nominal;
  for (int iteration = 0; iteration < max_frequencies; ++iteration) {
    // the nominal frequency, then alternately higher and lower ones; a given bandwidth is not exceeded
    const bool is_higher = iteration % 2 == 1;
    const int steps = is_higher ? (iteration + 1) / 2 : -iteration / 2;
    const double frequency = nominal * elementary::pow(frequency_ratio, steps);
    if (is_higher && (controller.bandwidth || frequency * controller.period > max_frequency_times_period)) continue;
    const double max_inertia_ratio =
        std::max(1.0, max_damping_fraction / std::max(controller.damping * frequency * controller.period, 1e-12));
    const VectorX inertia = max_inertia.cwiseMin(max_inertia_ratio * min_inertia);
    const VectorX kp = controller.kp.size() > 0 ? controller.kp : VectorX(frequency * frequency * inertia);
    const VectorX kd = controller.kd.size() > 0 ? controller.kd : VectorX(2 * controller.damping * frequency * inertia);
    double max_spectral_radius = 0;
    for (const OperatingPoint& point : operating_points) {
      if (point.plant.size() == 0) continue;
      for (const double gain_factor : {1.0, 2.0})
        max_spectral_radius = std::max(max_spectral_radius, compute_closed_loop_spectral_radius(
                                                                point, controller, gain_factor * kp, gain_factor * kd));
    }
    if (max_spectral_radius < min_spectral_radius || iteration == 0) {
      min_spectral_radius = max_spectral_radius;
      best.kp = kp, best.kd = kd;
      best_frequency = frequency;
    }
    if (max_spectral_radius < 1) break;
  }
  if (!(min_spectral_radius < 1))
    best.notes.push_back(controller.name +
                         ": no default gains are stable throughout the motion; the most nearly stable ones are used");
  else if (best_frequency != nominal)
    best.notes.push_back(other_bandwidth(controller, best_frequency));
  return best;
}

}  // namespace balance::control
