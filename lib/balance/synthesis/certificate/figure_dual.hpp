#pragma once
/// The best masses and places at given lengths, and the multipliers that prove it: weights of the forces along the
/// motion.

#include "balance/synthesis/certificate/figure_problem.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace balance::certificate {

/// A force along the motion, moment by moment, as a linear function of the mass parameters.
struct ForceSeries {
  MatrixX rows;          ///< moments · components × parameters, and a column that depends on none [SI]
  VectorX time_weights;  ///< of each moment in the average over time
  Eigen::Index components = 1;
};

/// All forces of a problem at given lengths.
struct ForceRows {
  std::vector<std::vector<ForceSeries>> figures, vanishing;  ///< per force: its series
  VectorX parameters;  ///< their values [SI]: m, mx, my, J of bodies, attachments and discs
};

/// Computes them: the library's own mechanics, which the enclosures are compared with.
class ForceRowModel {
 public:
  virtual ~ForceRowModel() = default;
  /// @param x all free numbers @return none if the mechanism cannot follow the motion
  virtual std::optional<ForceRows> evaluate(const VectorX& x) const = 0;
};

/// Weights of a force: one vector per series, ordered as its rows.
using ForceMultipliers = std::vector<VectorX>;

struct FigureDual {
  double value = 0;  ///< least objective at these lengths, where a place's moment of inertia is relaxed
  VectorX x;         ///< all free numbers, with the best masses and places
  std::vector<ForceMultipliers> figures, vanishing;
};

/// @param x its lengths are used
/// @return none if the mechanism cannot follow the motion, or the program cannot be solved
std::optional<FigureDual> solve_figure_dual(const FigureProblem& problem, const Mechanism& mechanism,
                                            const ForceRows& rows, const VectorX& x);

}  // namespace balance::certificate
