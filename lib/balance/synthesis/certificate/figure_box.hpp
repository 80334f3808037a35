#pragma once
/// A lower bound of figures along a motion for all lengths of a box.
///
/// At fixed lengths the forces are A w, linear in the masses' parameters w. For every weight y whose dual norm is at most
/// 1, figure(A w) ≥ y · A w ≥ min over w of y · A w. Over a box, y is affine in the lengths, and y · A(l) is enclosed by
/// its value and gradient in the middle and the interval of its second derivatives. Derivation: docs/certificate.md,
/// section 13.

#include "balance/synthesis/certificate/figure_dual.hpp"
#include "balance/synthesis/certificate/force_functional.hpp"

#include <limits>
#include <optional>
#include <vector>

namespace balance::certificate {

/// A motion as the program follows it at given lengths, as far as it gets.
struct SampledMotion {
  std::vector<MotionPoint> points;
  bool is_complete = false;
};

/// @param x all free numbers
SampledMotion sample_planar_motion(const DesignSpace& space, const FigureProblem& problem, const VectorX& x);

struct FigureBoxBound {
  double bound = -std::numeric_limits<double>::infinity();  ///< of the objective; −infinite: nothing was shown
  VectorX losses;            ///< per length of the problem: how much of the bound its width costs, about
  std::size_t enclosed = 0;  ///< moments of the motion that were enclosed
};

/// @param middle the motion in the middle of the box
/// @param corners of the box, in the order of their bits (bit k: the upper end of length k); null: not known. At least
/// one must be known
/// @param time_weights of the motion's moments
FigureBoxBound bound_figures(const DesignSpace& space, const FigureProblem& problem, const LengthBox& box,
                             const SampledMotion& middle, const std::vector<const FigureDual*>& corners,
                             const VectorX& time_weights);

}  // namespace balance::certificate
