#pragma once
/// Orders of forces, moments and efforts along a periodic motion as linear functions of the parameters.
///
/// Along a motion that geometry alone determines, such a quantity is a row of numbers times the parameters at every
/// moment, f(θ) = Y(θ) π. The order n of f is the order n of Y times π:
///
///     aₙ = 2/N Σ Y(θₖ) cos nθₖ π,    bₙ = 2/N Σ Y(θₖ) sin nθₖ π,
///
/// summed over N moments that divide the period evenly (trapezoidal rule). For smooth periodic functions its error
/// decreases faster than any power of 1/N: it is the sum of the orders N − n, N + n, 2N − n, … Source: Trefethen and
/// Weideman, The exponentially convergent trapezoidal rule, SIAM Review 56 (2014).

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <string>
#include <vector>

namespace balance::conditions {

/// The cosine or sine part of one order of a scalar: its product with the values of all terms (list_terms) is the
/// amplitude.
struct OrderRow {
  std::size_t goal = 0;  ///< index into the goals
  std::string quantity;  ///< the scalar: "shaking_force[x]"; of a rotating part the vector
  bool is_sine = false;  ///< of a rotating part, x + i y = (c + i s) exp(±i n θ): s
  std::string unit;      ///< of the amplitude [SI]
  VectorX coefficients;  ///< per term [SI]
  double magnitude = 0;  ///< root mean square over the motion of the quantity's largest coefficient, in natural units
};

/// How orders along one trajectory were computed.
struct OrderMotion {
  std::string trajectory;
  results::UniformTurning turning;
  long samples = 0;             ///< N, moments over the whole run
  double spectral_error = 0;    ///< largest change of a coefficient by the last doubling of N, relative to `magnitude`
  double known_term_error = 0;  ///< the same of loads and friction, which need not be smooth
};

struct OrderRows {
  std::string mismatch;  ///< why there are none, as a sentence; empty: there are
  std::vector<OrderMotion> motions;
  std::vector<OrderRow> rows;
};

/// Rows of all goals that are orders.
/// @param motions the trajectories that they name (study::select_goal_motions)
/// @param units of all terms, in which coefficients are comparable (NaturalUnits::parameter)
OrderRows compute_order_rows(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const std::vector<Trajectory>& motions, const dynamics::FreeSprings& loose,
                             const VectorX& units);

}  // namespace balance::conditions
