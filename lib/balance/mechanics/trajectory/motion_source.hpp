#pragma once
/// A mechanism moving along a prescribed motion, in the order of time, whichever formulation computes it.

#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/mechanics/trajectory/prescribed_motion.hpp"

#include <vector>

namespace balance::trajectory {

class MotionSource {
 public:
  MotionSource() = default;
  virtual ~MotionSource() = default;
  MotionSource(const MotionSource&) = delete;
  MotionSource& operator=(const MotionSource&) = delete;

  /// done: the motion can be followed, and has been up to time(). Otherwise why not, or why the last call failed.
  virtual const MotionOutcome& outcome() const = 0;
  /// The driven quantities over time. @pre outcome() was done at first
  virtual const PrescribedMotion& prescribed_motion() const = 0;

  /// Goes to time 0. As for advance(): if it returns false, outcome() says why.
  virtual bool begin() = 0;
  /// Advances to a later time [s], not across a jump, in as many steps as needed to stay in the same assembly mode.
  virtual bool advance(double time) = 0;
  /// Computes accelerations on one side of a jump at time() (begin() and advance() leave those after it).
  virtual void update_accelerations(Side side) = 0;
  /// Attaches and detaches payloads as from time() on; until the first call, all are attached.
  /// @return whether masses change
  virtual bool update_payloads() = 0;
  virtual double time() const = 0;  ///< [s]; before begin(): 0

  /// Computes sample() at time(). Returns false if the actuators do not hold the mechanism there; see outcome().
  virtual bool evaluate() = 0;
  /// As evaluated last. Sources that only follow the motion evaluate its coordinates and the tool.
  virtual const Sample& sample() const = 0;
  /// Speed of a point of a body, in the body's frame [m/s], and angular speed of the body [rad/s], where evaluated last.
  virtual double point_speed(BodyId body, const Vector3& point) const = 0;
  virtual double angular_speed(BodyId body) const = 0;
};

/// Visits increasing times, and every break before them, so that no step extends across one.
/// @param breaks increasing [s]
/// @param visit called with whether time() is a break; the source is not evaluated there yet
/// @return false if the source failed
template <class Visitor>
bool visit_times(MotionSource& source, const std::vector<double>& breaks, const std::vector<double>& times,
                 Visitor&& visit) {
  if (!source.begin()) return false;
  const auto move_to = [&](double time, bool is_break) {
    if (time > source.time() && !source.advance(time)) return false;
    visit(is_break);
    return true;
  };
  auto next_break = breaks.begin();
  for (const double time : times) {
    for (; next_break != breaks.end() && *next_break < time; ++next_break)
      if (!move_to(*next_break, true)) return false;
    if (!move_to(time, false)) return false;
  }
  return true;
}

/// A motion at given times: row k at time k. At a jump of the acceleration, the values just after it.
struct MotionTable {
  MotionOutcome outcome;
  double duration = 0;    ///< of the trajectory [s]
  Eigen::Index rows = 0;  ///< number of valid rows: all if the outcome is done, else those before its end
  Samples position, velocity, acceleration;  ///< rows × coordinates of the mechanism; angles are continuous past ±π
  Samples tool_position;                     ///< rows × 3 [m]; empty without a tool
  VectorX tool_angle;                        ///< planar [rad]
  std::vector<Matrix3> tool_rotation;        ///< spatial
};

/// @param times increasing, from 0 [s]; beyond the end, the last pose is held
MotionTable sample_motion(const Mechanism& mechanism, MotionSource& source, const std::vector<double>& times);

}  // namespace balance::trajectory
