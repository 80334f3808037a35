#pragma once
/// Follows prescribed values through time: Taylor's prediction, Newton on all equations, then velocities and accelerations.
/// Private to natural.

#include "balance/base/tall_matrix.hpp"
#include "balance/motion/approach.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/schedule.hpp"
#include "balance/natural/equations.hpp"

#include <functional>
#include <utility>

namespace balance::natural {

class Stepper {
 public:
  /// @param model, schedule must outlive the stepper
  Stepper(const Model& model, DriveRows drive, const Schedule& schedule, int freedoms);

  /// Another matrix that must keep full column rank, from begin() on.
  void watch(std::function<MatrixX(const Coordinates&)> held) { held_ = std::move(held); }
  /// Time 0, from a configuration near it. Also true of advance: on false outcome() says why, and the last good state stays.
  bool begin(const Coordinates& near);
  /// On to a later time, in as many steps as it takes to stay on the same assembly mode.
  bool advance(double time);
  /// Accelerations on one side of the present time (advance() leaves those of the side `after`).
  void accelerate(Side side);

  double time() const { return now_.time; }
  double duration() const { return schedule_.duration(); }  ///< of the whole motion [s]
  const State& state() const { return now_; }
  /// Angle of every body, running on past ±π [rad], with its rates; from the scalars or read off the directions.
  const std::vector<double>& angles() const { return angles_; }
  double spin(BodyId body) const;
  double spin_rate(BodyId body) const;
  int iterations() const { return iterations_; }
  const Equations& equations() const { return equations_; }
  const MotionOutcome& outcome() const { return outcome_; }

 private:
  enum class Attempt { done, no_convergence, far, singular, not_held };

  Attempt step(double time);
  Attempt judge(const State& next);
  double curvature(const State& next) const;
  bool far_from(const Coordinates& predicted, const Coordinates& found) const;
  void read_angles(const std::vector<double>& expected);
  void stop(Attempt attempt);

  const Model& model_;
  const Schedule& schedule_;
  int freedoms_;
  Equations equations_;
  State now_;
  std::vector<double> angles_;
  DriveSample sample_;
  int iterations_ = 0;
  TallMatrix all_, actuation_;
  Approach approach_, actuation_approach_;
  std::function<MatrixX(const Coordinates&)> held_;
  MotionOutcome outcome_;
};

}  // namespace balance::natural
