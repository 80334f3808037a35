#pragma once
/// Figures of a trajectory as functions of the parameters without simulating the motion again. Along a fixed motion
/// every force is a matrix times the parameters. Its rms is the root of a quadratic form whose size does not depend on
/// the number of samples.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::design {

// Figures of a run along a fixed motion: norms of rows times the parameters.

/// A force or another quantity, sample by sample along a motion.
struct AffineSeries {
  MatrixX rows;  ///< samples · components × (parameters, 1) [SI]; the last column does not depend on parameters
  Eigen::Index components = 1;  ///< rows per sample
  VectorX time_weights;         ///< per sample: weight in the time average
};

/// weight · a convex function of the parameters.
struct AffineFigure {
  double weight = 1;
  VectorX coefficients;               ///< of a linear function of the parameters; empty for other figures
  Statistic figure = Statistic::rms;  ///< rms, peak, or maximum of scalars
  std::vector<AffineSeries> series;   ///< the figure is that of the worst one

  /// Without the weight. @param parameters [SI], followed by a 1
  double operator()(const VectorX& parameters) const;
};

/// One figure along one trajectory [SI]: value and, if requested, gradient.
/// @param parameters in the order of list_parameters for the same loose springs
/// @param gradient null, or output of the size of the parameters
/// @throws std::invalid_argument for a wrong number of parameters
using CostFunction = std::function<double(const VectorX& parameters, VectorX* gradient)>;

class TrajectoryCost {
 public:
  /// Solves the start pose. For CoM drives, the motion is that of the mechanism's own masses.
  /// @param loose springs whose parameters are all products of stiffness and end points
  /// @throws std::invalid_argument if trajectory and mechanism do not match
  TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory, const dynamics::FreeSprings& loose = {});
  ~TrajectoryCost();
  TrajectoryCost(TrajectoryCost&&) noexcept;
  TrajectoryCost& operator=(TrajectoryCost&&) noexcept;

  /// If not `done`, the mechanism cannot follow the trajectory and there are no figures. Passes along the motion unless
  /// that has been done.
  const MotionOutcome& outcome() const;

  /// @param quantity a force, moment, power or the kinetic energy by its name in a run, or one of its components:
  /// "torque", "power[A1]", "shaking_force[x]", "shaking_moment[z] about ground.P", "joint_force[B]"
  /// Passes along the motion once (rms) or twice; the returned function does not, and does not depend on this object.
  /// Peak, rms, mean and maximum are convex; at a kink the gradient is one-sided.
  /// @return std::nullopt if the quantity does not exist, is not linear in the parameters, or there is no motion
  std::optional<CostFunction> figure(Statistic figure, const std::string& quantity) const;

  /// The rows of each quantity. There is one series per actuator or joint if the worst one counts. Passes along the
  /// motion once.
  /// @return std::nullopt as above
  std::vector<std::optional<std::vector<AffineSeries>>> rows(const std::vector<std::string>& quantities) const;

 private:
  struct Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

/// Whether the mechanism has the quantity and it is linear in the parameters.
bool is_linear_quantity(const Mechanism& mechanism, const std::string& quantity);

/// Whether the prescribed motion itself depends on the masses (drive com, or a pose given by the CoM).
bool is_mass_dependent(const Trajectory& trajectory);

}  // namespace balance::design
