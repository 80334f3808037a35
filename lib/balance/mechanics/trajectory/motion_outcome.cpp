#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/model/validation.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>

namespace balance::trajectory {

namespace {

/// "t = 0.1, 0.2 s". Of many times, only the first ones and the last.
std::string format_times(const std::vector<double>& times) {
  constexpr std::size_t max_listed_times = 6;
  std::string text = "t = ";
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (times.size() > max_listed_times && k == max_listed_times - 1) {
      text += ", … (" + std::to_string(times.size()) + " times)";
      k = times.size() - 1;
    }
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", times[k]);
    text += (k == 0 ? "" : ", ") + std::string(number);
  }
  return text + " s";
}

}  // namespace

std::string format_time_prefix(double time) {
  char text[64];
  std::snprintf(text, sizeof text, "at t = %.9g s: ", time);
  return text;
}

MotionOutcome make_actuation_singularity_outcome(double time, const std::string& configuration) {
  return {MotionStatus::actuation_singularity,
          time,
          format_time_prefix(time) +
              "actuation singularity: the actuators do not hold the mechanism in a configuration reached there" +
              (configuration.empty() ? "" : "; configuration: " + configuration),
          {}};
}

std::string describe_near_singularity(SingularityKind what, double mobility, double time) {
  char text[240];
  std::snprintf(text, sizeof text,
                "comes near a singularity of %s at t = %.6g s, where the mobility%s drops to %.3g: rates and forces "
                "are large there and accurate to about %.0e of their size",
                what == SingularityKind::motion ? "the motion" : "actuation", time,
                what == SingularityKind::motion ? "" : " under the actuators", mobility, 1e-16 / (mobility * mobility));
  return text;
}

std::string describe_change_point(const std::string& loop, const std::vector<double>& times) {
  return "passes a change point of the loop " + loop + " at " + format_times(times) +
         ": harmless, since other closures keep the motion determinate there";
}

std::string describe_redundant_actuator(const std::string& actuator, const std::vector<double>& times) {
  return "passes a singularity of the actuators other than " + actuator + " at " + format_times(times) +
         ": harmless, since " + actuator + " helps them to hold the mechanism there";
}

MotionOutcome make_overflow_outcome(double time, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, "numbers overflow at t = %.9g s: ", time);
  return {MotionStatus::overflow, time, text + what + " is too large to represent", {}};
}

MotionOutcome make_overflow_outcome(double time, const std::string& what, const Mechanism& mechanism) {
  if (!has_mass(mechanism)) return {MotionStatus::overflow, time, model::no_mass_message, {}};
  return make_overflow_outcome(time, what);
}

std::string describe_flat_disc(const Mechanism& mechanism, const std::vector<double>& coordinates) {
  constexpr int lean_coordinate_index = 3;  // index of the lean angle among a disc's coordinates
  constexpr double min_cosine = 0.1;        // of a disc that is not flat
  for (std::size_t c = 0; c < coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const Joint& joint = mechanism.joints[coordinate.joint];
    if (joint.type == JointType::rolling_disc && coordinate.index == lean_coordinate_index &&
        std::abs(elementary::cos(coordinates[c])) < min_cosine)
      return "the disc of " + joint.name + " lies flat on its plane";
  }
  return "";
}

std::string describe_under_actuation(int motors, int freedoms) {
  return "under-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
         " degrees of freedom; name as many coordinates in `actuators`";
}

std::string describe_over_actuation(int motors, int freedoms, const std::string& distribution) {
  return "over-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
         " degrees of freedom; the efforts are those of " + distribution;
}

std::string describe_nonlinear_efforts(const std::string& what) {
  return "torque_distribution: the efforts are not a sum of " + what +
         " unless the method is least-norm without limits and preload";
}

std::string describe_determined_efforts(int motors, int freedoms) {
  return "torque_distribution: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
         " degrees of freedom leave no choice; the efforts are only compared with limits and preloads";
}

std::string describe_over_constraint() {
  return "the loops are over-constrained: reactions are those of least norm, not the only possible ones";
}

std::string describe_locked_freedom(const Mechanism& mechanism, const model::PassiveFreedom& spin) {
  return mechanism.bodies[spin.body].name +
         ": the spin between its two spherical joints is held as if one of them were universal";
}

}  // namespace balance::trajectory
