#pragma once
/// Response of the free coordinates to driven joints that turn at constant speed, order by order.
///
/// Linear: with δ = Σ X_k e^{ikωt} over the period 2π/ω of the driven motion, and the Fourier coefficients R_k of R and of the
/// matrices of linear_motion.hpp (harmonic balance; G. W. Hill, Acta Math. 8, 1886),
///
///     Σ_k (K_{j−k} + ikω C_{j−k} − k²ω² M_{j−k}) X_k = −R_j.
///
/// Where the matrices are constant, the orders separate: (K − j²ω² M + ijω C) X_j = −R_j. What this leaves out are products of
/// deviations. Exact: the periodic motion found by shooting (motion/simulation/free_motion.hpp).

#include "balance/mechanics/results/orders.hpp"
#include "balance/motion/vibration/linear_motion.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::vibration {

struct ForcedResponse {
  results::UniformTurning turning;
  std::vector<double> orders;  ///< k/turns, increasing
  MotionOutcome outcome;       ///< of the linear response: done, or why there is none
  /// Of the free coordinates, ground_force, ground_moment and the torques of the actuators.
  std::vector<results::QuantityOrders> linear;
  results::QuantityOrders excitation;          ///< ground_force with the free coordinates at rest at the reference
  MotionOutcome exact_outcome;                 ///< done: `exact` was computed; else why not, if that was asked
  std::vector<results::QuantityOrders> exact;  ///< the same quantities; empty: not computed

  /// Ground force per excitation, linear; NaN where nothing excites.
  double transmissibility(Eigen::Index order) const;
  /// Largest difference of an order's linear peak from the exact one, as a part of the quantity's largest exact peak.
  double difference(Eigen::Index quantity, Eigen::Index order) const;
};

/// The joint that turns uniformly by whole turns along the trajectory, an actuated one if possible; none if none does.
std::optional<results::UniformTurning> find_driven_turning(const Mechanism& mechanism, const Trajectory& trajectory);

struct ResponseOptions {
  int highest_order = 4;
  bool is_exact = true;  ///< also by shooting
};

/// @param trajectory nullptr: none
/// @return none unless driven joints make whole turns in a steady motion of a mechanism without constraints on rates
/// @throws std::invalid_argument if the mechanism does not go with it. The message is suitable for users.
std::optional<ForcedResponse> find_forced_response(const Mechanism& mechanism, const Trajectory* trajectory,
                                                   const LinearMotion& motion, const ResponseOptions& options);

}  // namespace balance::vibration
