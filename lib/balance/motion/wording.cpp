#include "balance/motion/wording.hpp"

#include <cstdio>

namespace balance {

std::string at_time(double time) {
  char text[64];
  std::snprintf(text, sizeof text, "at t = %.9g s: ", time);
  return text;
}

MotionOutcome no_longer_held(double time, const std::string& configuration) {
  return {MotionStatus::actuation_singularity,
          time,
          at_time(time) +
              "actuation singularity: the actuators do not hold the mechanism in a configuration reached there" +
              (configuration.empty() ? "" : "; configuration: " + configuration),
          {}};
}

std::string passes_near(const std::string& what, double distance, double time) {
  char text[200];
  std::snprintf(text, sizeof text,
                "comes near %s at t = %.6g s, to %.2g of a regular configuration: rates and forces are large there and "
                "good to about "
                "%.0e of their size",
                what.c_str(), time, distance, 1e-16 / (distance * distance));
  return text;
}

MotionOutcome numbers_overflow(double time, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, "numbers overflow at t = %.9g s: ", time);
  return {MotionStatus::overflow, time, text + what + " is larger than can be computed with", {}};
}

std::string under_actuated(int motors, int freedoms) {
  return "under-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
         " degrees of freedom; name as many coordinates in `actuators`";
}

std::string over_actuated(int motors, int freedoms) {
  return "over-actuated: " + std::to_string(motors) + " actuators for " + std::to_string(freedoms) +
         " degrees of freedom; the efforts are those of least norm";
}

std::string over_constrained() {
  return "the loops are over-constrained: reactions are those of least norm, not the only possible ones";
}

std::string held_spin(const Mechanism& mechanism, const IdleSpin& spin) {
  return mechanism.bodies[spin.body].name +
         ": the spin between its two spherical joints is held as if one of them were universal";
}

}  // namespace balance
