#pragma once
/// Figures of a trajectory as functions of the parameters, without moving the mechanism again: along a fixed motion every force
/// is a matrix times the parameters, and its rms a quadratic form whose size does not depend on the number of samples.

#include "balance/conditions/parameter.hpp"
#include "balance/motion/motion.hpp"
#include "balance/motion/trajectory.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace balance {

enum class Figure { peak, rms, mean, range };

/// One figure along one trajectory: value and, where asked for, gradient.
using CostFunction = std::function<double(const VectorX& parameters, VectorX* gradient)>;

class TrajectoryCost {
 public:
  /// Solves the motion and keeps the forces' matrices.
  TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory, const LooseSprings& loose = {});
  ~TrajectoryCost();
  TrajectoryCost(TrajectoryCost&&) noexcept;
  TrajectoryCost& operator=(TrajectoryCost&&) noexcept;

  /// Not done: the mechanism cannot follow the trajectory, and there are no figures.
  const MotionOutcome& outcome() const;

  /// @param quantity as in Result::metrics: "torque", "torque[A1]", "shaking_force", "shaking_moment", "ground_force",
  ///        "ground_moment", "power", "power[A1]", "kinetic_energy"
  /// @return nothing if the quantity is not linear in the parameters or does not exist
  std::optional<CostFunction> figure(Figure figure, const std::string& quantity) const;

 private:
  struct Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

/// The prescribed motion itself depends on where the mass is (drive com).
bool depends_on_masses(const Trajectory& trajectory);

}  // namespace balance
