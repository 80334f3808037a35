#pragma once
/// Orders of affine quantities along a fixed motion as convex functions of the parameters. They are those of the
/// trajectory's samples, as results::compute_order_peak() gives them for a run.

#include "balance/mechanics/results/orders.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"

#include <vector>

namespace balance::design {

/// Amplitudes a = cosine · (π, 1) and b = sine · (π, 1) of an order, per component of the quantity.
struct OrderMatrices {
  MatrixX cosine, sine;  ///< components × (parameters, 1) [SI]
};

/// @param series at all points of the time grid
/// @param samples of the trajectory; other points of the grid are left out
/// @throws std::invalid_argument if the run does not have the order, or too few samples. The message is suitable for users.
OrderMatrices project_on_order(const AffineSeries& series, double order, const results::UniformTurning& turning,
                               long samples);

/// The order's peak, or the radius of its part, with its gradient.
///
/// Of a scalar it is the norm of (a, b). In the plane it is the sum of the radii of the two circles that turn with θ and
/// against it, |F| + |B| with 2F = (aₓ + b_y, a_y − bₓ) and 2B = (aₓ − b_y, a_y + bₓ); in space the larger singular value of
/// [a b]. All are norms, and therefore convex.
CostFunction make_order_cost(const OrderMatrices& matrices, results::OrderPart part);

/// The same as figures whose sum it is. In space the largest of the values at evenly spaced phases, which is below the
/// peak by less than 1e-5 of it: a lower bound of it is one of the peak.
std::vector<AffineFigure> make_order_figures(const OrderMatrices& matrices, results::OrderPart part, double weight);

}  // namespace balance::design
