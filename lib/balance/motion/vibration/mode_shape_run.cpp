#include "balance/motion/vibration/mode_shape_run.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/simulation/partly_driven_mechanism.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::vibration {

namespace {

constexpr double shown_amplitude = 0.1;  // rad or characteristic lengths
constexpr int knots = 64;                // of the spline through the motion
constexpr long shown_samples = 121;

/// Time and factor of the shape.
struct ModeMotion {
  double duration;
  std::complex<double> exponent;  ///< of e^(exponent · t); 0: the factor is the time

  explicit ModeMotion(const VibrationMode& mode) : duration(1), exponent(0) {
    if (mode.oscillates()) {
      exponent = {0, mode.eigenvalue.imag()};
      duration = 2 * std::numbers::pi / mode.eigenvalue.imag();
    } else if (mode.eigenvalue.real() != 0) {
      exponent = -std::abs(mode.eigenvalue.real());
      duration = 3 / std::abs(mode.eigenvalue.real());
    }
  }

  std::complex<double> factor_at(double time, bool is_growing) const {
    if (exponent == 0.0) return time;
    const double elapsed = is_growing ? duration - time : time;
    const double angle = exponent.imag() * elapsed;
    return elementary::exp(exponent.real() * elapsed) *
           std::complex<double>(elementary::cos(angle), elementary::sin(angle));
  }
};

}  // namespace

RunResult run_mode_shape(const Mechanism& mechanism, const Trajectory& trajectory, const VibrationModes& modes,
                         const VibrationMode& mode) {
  const simulation::PartlyDrivenMechanism system(mechanism, trajectory, simulation::RateConstraints::accepted);
  RunResult failed;
  failed.outcome = system.outcome();
  if (failed.outcome.status != MotionStatus::done) return failed;
  Mechanism guided = system.mechanism();
  guided.actuators = system.driven_coordinates();
  guided.assembly.clear();
  for (Eigen::Index c = 0; c < system.start().size(); ++c)
    guided.assembly.push_back({static_cast<int>(c), system.start()[c]});
  const ModeMotion motion(mode);
  Trajectory path;
  path.name = trajectory.name;
  path.drive = DriveKind::joints;
  path.about = trajectory.about;
  path.samples = shown_samples;
  trajectory::TablePath table;
  const std::vector<CoordinateId>& free = modes.motion.coordinates;
  for (int j = 0; j <= knots; ++j) {
    const double time = motion.duration * j / knots;
    const std::complex<double> factor = motion.factor_at(time, mode.eigenvalue.real() > 0);
    std::vector<double> row;
    for (const CoordinateId coordinate : guided.actuators) {
      double value = system.start()[coordinate];
      const auto k = std::find(free.begin(), free.end(), coordinate) - free.begin();
      if (k < modes.motion.free_count)
        value = modes.motion.position[k] + shown_amplitude * (factor * mode.shape[k]).real();
      row.push_back(value);
    }
    if (j == 0)
      for (std::size_t k = 0; k < row.size(); ++k) path.from.joints.push_back({guided.actuators[k], row[k]});
    table.time.push_back(time);
    table.values.push_back(std::move(row));
  }
  path.path = std::move(table);
  return simulation::simulate(guided, path);
}

}  // namespace balance::vibration
