#pragma once
/// What the limited quantities are at the places of a path: coefficients of s'', s'², 1 and s'. Private to timing.

#include "balance/motion/motion.hpp"
#include "balance/motion/offset.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/result/limited.hpp"

#include <memory>
#include <vector>

namespace balance {

/// The path alone, run through in one second: time is the path's parameter.
Trajectory reparametrise_by_path(Trajectory trajectory);

/// Where one quantity's coefficients stand in a row of samples: `count` columns each; −1: it has none.
struct CoefficientColumns {
  LimitableQuantity quantity;
  int a = -1, b = -1, c = -1, d = -1;  ///< of s'', s'², 1, s'
};

/// A path without a law: its parameter s runs from 0 to 1.
class PathDynamicsSampler {
 public:
  virtual ~PathDynamicsSampler() = default;

  /// Done, or why the path cannot be followed.
  const MotionOutcome& outcome() const { return outcome_; }
  const std::vector<CoefficientColumns>& limits() const { return limits_; }
  int columns() const { return columns_; }
  /// Where one leg ends in rest and the next begins, 0 and 1 included.
  const std::vector<double>& leg_ends() const { return leg_ends_; }
  /// Where splines have knots: accelerations bend there.
  const std::vector<double>& knots() const { return knots_; }
  /// How many components the point has that a corridor is for. @throws std::invalid_argument if it has fewer than two
  int corridor_components() const { return balance::count_corridor_components(quantities_); }
  /// How fast the driven point goes at both ends for s' = 1 [m]; without one the norm of the driven coordinates' rates.
  double start_speed() const { return start_speed_; }
  double end_speed() const { return end_speed_; }

  /// @param places increasing, in (0, 1), none of them the end of a leg
  /// @param rows one per place: the columns that limits() names
  /// @return false if the path cannot be followed; outcome() says why
  virtual bool sample(const std::vector<double>& places, Samples& rows) = 0;

  /// Rates of the coordinates with dry friction, for s' = 1: where they change their sign, friction jumps.
  virtual bool sample_friction(const std::vector<double>& places, Samples& rows) = 0;
  virtual int friction_count() const = 0;

  /// How large forces [N] and moments [N m] are that joints transmit for s' = 1 and for s'' = 1: what round-off is a part of.
  struct ReactionMagnitude {
    double force = 0, moment = 0;
  };
  virtual ReactionMagnitude max_reactions(const std::vector<double>& places) = 0;

 protected:
  MotionOutcome outcome_;
  std::vector<CoefficientColumns> limits_;
  int columns_ = 0;
  std::vector<double> leg_ends_, knots_;
  DriveQuantities quantities_;
  double start_speed_ = 0, end_speed_ = 0;
};

/// @param trajectory its law, duration and limits do not matter
/// @throws std::invalid_argument if the trajectory asks for something that does not exist
std::unique_ptr<PathDynamicsSampler> make_path_dynamics_sampler(const Mechanism& mechanism,
                                                                const Trajectory& trajectory,
                                                                const std::vector<LimitableQuantity>& quantities);

}  // namespace balance
