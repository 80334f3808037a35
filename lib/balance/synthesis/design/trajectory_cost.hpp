#pragma once
/// Figures of a trajectory as functions of the parameters, without moving the mechanism again: along a fixed motion every force
/// is a matrix times the parameters, and its rms a quadratic form whose size does not depend on the number of samples.

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

namespace balance {

// Figures of a run as what they are of the parameters along one motion: sizes of rows times the parameters.

/// A force or another quantity place by place along a motion.
struct AffineSeries {
  MatrixX rows;  ///< places · components × (parameters, one) [SI]: what does not depend on a parameter stands last
  Eigen::Index components = 1;  ///< rows of one place
  VectorX time_weights;         ///< per place: of the time average
};

/// weight · a convex function of the parameters.
struct AffineFigure {
  double weight = 1;
  VectorX coefficients;               ///< of the parameters, if it is a sum of them; else empty
  Statistic figure = Statistic::rms;  ///< rms or peak
  std::vector<AffineSeries> series;   ///< the worst of them counts

  /// Without the weight. @param parameters [SI], a one behind them
  double operator()(const VectorX& parameters) const;
};

/// One figure along one trajectory [SI]: value and, where asked for, gradient.
/// @param parameters in the order of list_parameters for the same loose springs
/// @param gradient null, or where to put it: of the parameters' size
/// @throws std::invalid_argument if there are not as many values as parameters
using CostFunction = std::function<double(const VectorX& parameters, VectorX* gradient)>;

class TrajectoryCost {
 public:
  /// Solves the motion. For com drives it is that of the mechanism's own masses.
  /// @param loose springs whose parameters are all products of stiffness and end points
  /// @throws std::invalid_argument if trajectory and mechanism do not fit
  TrajectoryCost(const Mechanism& mechanism, const Trajectory& trajectory, const FreeSprings& loose = {});
  ~TrajectoryCost();
  TrajectoryCost(TrajectoryCost&&) noexcept;
  TrajectoryCost& operator=(TrajectoryCost&&) noexcept;

  /// Not done: the mechanism cannot follow the trajectory, and there are no figures.
  const MotionOutcome& outcome() const;

  /// @param quantity as in RunResult::metrics: "torque", "torque[A1]", "total_torque", "shaking_force", "shaking_moment", "ground_force",
  ///        "ground_moment", "power", "power[A1]", "kinetic_energy"
  /// Goes along the motion once (rms) or twice; the function it returns does not, and does not need this object any more. Peak
  /// and rms are convex; where a figure has a corner the gradient is that of one side.
  /// @return nothing if the quantity is not linear in the parameters or does not exist
  std::optional<CostFunction> figure(Statistic figure, const std::string& quantity) const;

  /// The quantity's rows as they are, one series per actuator where the worst one counts. Goes along the motion once.
  /// @return nothing as above
  std::optional<std::vector<AffineSeries>> rows(const std::string& quantity) const;

 private:
  struct Implementation;
  std::shared_ptr<const Implementation> implementation_;
};

/// The mechanism has such a quantity, and it is linear in the parameters.
bool is_linear_quantity(const Mechanism& mechanism, const std::string& quantity);

/// The prescribed motion itself depends on where the mass is (drive com, or a pose that is stated by the CoM).
bool is_mass_dependent(const Trajectory& trajectory);

}  // namespace balance
