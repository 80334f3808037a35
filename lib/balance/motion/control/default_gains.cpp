#include "balance/motion/control/default_gains.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

namespace balance {

namespace {

constexpr double max_damping_fraction =
    0.25;  // kd · period / inertia of the lightest pose, as part of what kd itself is of ω I
constexpr double difference_step =
    1e-5;  // step of differences, in radians or characteristic lengths, and these per second
constexpr double frequency_ratio = 1.25;  // two frequencies that are tried
constexpr int max_frequencies = 49;
constexpr double max_frequency_times_period = 1;  // ω · period that is tried

/// The loop at one moment of the motion, for small departures x = (δq, δν) of the independent coordinates.
struct OperatingPoint {
  VectorX inertia;           ///< felt by each motor alone
  MatrixX plant;             ///< 2d×2d: ẋ = plant · x + input · δu
  MatrixX input;             ///< 2d×A
  MatrixX output;            ///< A×d: the motors' coordinates
  MatrixX gravity_feedback;  ///< A×d: how the efforts that hold the model follow the pose
};

MatrixX compute_matrix_exponential(MatrixX A) {
  int halvings = 0;
  for (; max_abs(A.cwiseAbs().rowwise().sum()) > 0.25 && halvings < 60; ++halvings) A /= 2;
  MatrixX sum = MatrixX::Identity(A.rows(), A.cols()), term = sum;
  for (int k = 1; k <= 12; ++k) sum += term = term * A / k;
  for (; halvings > 0; --halvings) sum = sum * sum;
  return sum;
}

/// The largest magnitude of an eigenvalue, by squaring again and again.
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
  LinearisedPlant(const Mechanism& believed, const Controller& controller)
      : mechanism_(frictionless(believed)),
        controller_(controller),
        length_(characteristic_length(believed)),
        model_(mechanism_, {.preferred = mechanism_.actuators}) {}

  int freedoms() const { return model_.freedoms(); }

  /// @return nothing where the model cannot be put
  std::optional<OperatingPoint> at(const DesiredState& state) {
    if (!set_state(state.position, state.velocity)) return {};
    const std::vector<CoordinateId> independent = model_.independent();
    const EquationOfMotion here = model_.equation();
    const Transformation all = model_.transformation();
    const auto d = static_cast<Eigen::Index>(independent.size()), motors = here.input.cols();
    OperatingPoint moment;
    const Eigen::LLT<MatrixX> mass(here.mass);
    if (mass.info() != Eigen::Success) return {};
    const MatrixX push = mass.solve(here.input);
    moment.inertia = (here.input.transpose() * push).diagonal().cwiseInverse();
    if (motors < d) return moment;
    VectorX rate_change(d);
    for (Eigen::Index k = 0; k < d; ++k) rate_change[k] = state.acceleration[independent[static_cast<std::size_t>(k)]];
    const VectorX efforts = CompleteOrthogonalDecomposition(here.input).solve(here.mass * rate_change + here.bias);
    moment.plant = MatrixX::Zero(2 * d, 2 * d);
    moment.plant.topRightCorner(d, d).setIdentity();
    moment.input = MatrixX::Zero(2 * d, motors);
    moment.input.bottomRows(d) = push;
    moment.output.resize(motors, d);
    for (Eigen::Index a = 0; a < motors; ++a)
      moment.output.row(a) = all.matrix.row(mechanism_.actuators[static_cast<std::size_t>(a)]);
    moment.gravity_feedback = MatrixX::Zero(motors, d);
    for (Eigen::Index k = 0; k < d; ++k) {
      const double step = difference_step * unit(independent[static_cast<std::size_t>(k)]);
      const VectorX along = step * all.matrix.col(k), none = VectorX::Zero(state.velocity.size());
      VectorX up, down, turned_up, turned_down;
      if (!acceleration_at(state.position + along, state.velocity, efforts, independent, up) ||
          !acceleration_at(state.position - along, state.velocity, efforts, independent, down) ||
          !acceleration_at(state.position, state.velocity + along, efforts, independent, turned_up) ||
          !acceleration_at(state.position, state.velocity - along, efforts, independent, turned_down))
        return {};
      moment.plant.col(k).tail(d) = (up - down) / (2 * step);
      moment.plant.col(d + k).tail(d) = (turned_up - turned_down) / (2 * step);
      if (controller_.gravity == GravityCompensation::ignored) continue;
      if (!gravity_efforts_at(state.position + along, none, up) ||
          !gravity_efforts_at(state.position - along, none, down))
        return {};
      moment.gravity_feedback.col(k) = (up - down) / (2 * step);
    }
    return moment;
  }

 private:
  static Mechanism frictionless(Mechanism mechanism) {
    mechanism.friction.clear();
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
    const EquationOfMotion equation = model_.equation();
    out = Eigen::LLT<MatrixX>(equation.mass).solve(equation.input * efforts - equation.bias);
    return out.allFinite();
  }

  bool gravity_efforts_at(const VectorX& position, const VectorX& none, VectorX& out) {
    if (!set_state(position, none)) return false;
    const EquationOfMotion equation = model_.equation();
    out = CompleteOrthogonalDecomposition(equation.input).solve(equation.bias);
    return out.allFinite();
  }

  const Mechanism mechanism_;
  const Controller& controller_;
  double length_;
  ForwardDynamics model_;
};

/// One period after another, the efforts held: (x, last measured position) → the same one period later.
double compute_closed_loop_spectral_radius(const OperatingPoint& moment, const Controller& controller,
                                           const VectorX& kp, const VectorX& kd) {
  const Eigen::Index n = moment.plant.rows(), d = n / 2, motors = moment.input.cols();
  MatrixX both = MatrixX::Zero(n + motors, n + motors);
  both.topLeftCorner(n, n) = moment.plant * controller.period;
  both.topRightCorner(n, motors) = moment.input * controller.period;
  const MatrixX held = compute_matrix_exponential(both);
  const bool differences = controller.measurement.velocity == VelocitySource::difference;
  MatrixX feedback = MatrixX::Zero(motors, n + motors);
  feedback.leftCols(d) = moment.gravity_feedback - MatrixX(kp.asDiagonal()) * moment.output;
  if (differences) {
    feedback.leftCols(d) -= MatrixX(kd.asDiagonal()) * moment.output / controller.period;
    feedback.rightCols(motors) = MatrixX(kd.asDiagonal()) / controller.period;
  } else {
    feedback.middleCols(d, d) = -(MatrixX(kd.asDiagonal()) * moment.output);
  }
  MatrixX step = MatrixX::Zero(n + motors, n + motors);
  step.topRows(n) = held.block(0, n, n, motors) * feedback;
  step.topLeftCorner(n, n) += held.topLeftCorner(n, n);
  step.bottomLeftCorner(motors, d) = moment.output;
  return spectral_radius(step);
}

std::string other_bandwidth(const Controller& controller, double frequency) {
  char text[200];
  std::snprintf(text, sizeof text,
                ": the default gains are those of a bandwidth of %.3g Hz, since those of %.3g Hz would not be stable "
                "all along the motion at this sample rate",
                frequency / (2 * std::numbers::pi), controller.natural_frequency() / (2 * std::numbers::pi));
  return controller.name + text;
}

}  // namespace

PdGains default_pd_gains(const Mechanism& believed, const Controller& controller,
                         const std::vector<DesiredState>& along) {
  LinearisedPlant model(believed, controller);
  std::vector<OperatingPoint> moments;
  for (const DesiredState& state : along)
    if (std::optional<OperatingPoint> moment = model.at(state)) moments.push_back(std::move(*moment));
  const auto motors = static_cast<Eigen::Index>(believed.actuators.size());
  PdGains best;
  VectorX most = VectorX::Zero(motors), least = VectorX::Constant(motors, INFINITY);
  for (const OperatingPoint& moment : moments) {
    most = most.cwiseMax(moment.inertia);
    least = least.cwiseMin(moment.inertia);
  }
  const double nominal = controller.natural_frequency();
  double min_growth = INFINITY, used = nominal;
  for (int turn = 0; turn < max_frequencies; ++turn) {
    // the nominal one, then higher and lower ones in turn; a stated bandwidth is not exceeded
    const bool up = turn % 2 == 1;
    const int steps = up ? (turn + 1) / 2 : -turn / 2;
    const double frequency = nominal * elementary::pow(frequency_ratio, steps);
    if (up && (controller.bandwidth || frequency * controller.period > max_frequency_times_period)) continue;
    const double allowed =
        std::max(1.0, max_damping_fraction / std::max(controller.damping * frequency * controller.period, 1e-12));
    const VectorX inertia = most.cwiseMin(allowed * least);
    const VectorX kp = controller.kp.size() > 0 ? controller.kp : VectorX(frequency * frequency * inertia);
    const VectorX kd = controller.kd.size() > 0 ? controller.kd : VectorX(2 * controller.damping * frequency * inertia);
    double worst = 0;
    for (const OperatingPoint& moment : moments) {
      if (moment.plant.size() == 0) continue;
      for (const double more : {1.0, 2.0})
        worst = std::max(worst, compute_closed_loop_spectral_radius(moment, controller, more * kp, more * kd));
    }
    if (worst < min_growth || turn == 0) {
      min_growth = worst;
      best.kp = kp, best.kd = kd;
      used = frequency;
    }
    if (worst < 1) break;
  }
  if (!(min_growth < 1))
    best.notes.push_back(
        controller.name +
        ": no default gains are stable at every single moment of the motion; those that come nearest are taken");
  else if (used != nominal)
    best.notes.push_back(other_bandwidth(controller, used));
  return best;
}

}  // namespace balance
