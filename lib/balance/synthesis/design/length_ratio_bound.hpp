#pragma once
/// Lower bounds of efforts of springs over boxes of rows and places, in which the length of a spring at a sample is
/// compared with its mean over the motion.

#include "balance/foundation/base/types.hpp"
#include "balance/synthesis/design/box_form.hpp"

#include <utility>
#include <vector>

namespace balance::design {

/// Squared lengths of a spring at the samples of a motion: linear in the features of its ends (1, a, b, a bᵀ,
/// |a|² + |b|²).
struct SquaredLengths {
  MatrixX rows;  ///< samples × features
  VectorX mean;  ///< of the rows
};

/// An effort as a function of springs: y = constant + Σ rows · (1 − ε/length) · V with the stiffness times features V
/// and the free length ε of each spring.
class SpringSeries {
 public:
  struct Part {
    std::vector<int> features;  ///< those that matter, of the columns of per_spring
    MatrixX rows;               ///< samples · components × features
    SquaredLengths lengths;
  };

  SpringSeries() = default;
  /// @param time_weights of the samples, with sum one
  /// @param per_spring samples · components × features
  SpringSeries(Eigen::Index components, bool is_peak, const VectorX& time_weights, VectorX constant,
               const std::vector<MatrixX>& per_spring, const std::vector<SquaredLengths>& lengths);

  Eigen::Index components = 1;
  bool is_peak = false;
  VectorX constant, weights;  ///< by row
  std::vector<Part> parts;    ///< by spring
  MatrixX rows;               ///< of all parts
  MatrixX inverse;            ///< of rowsᵀ weights rows; empty if it is singular
};

/// A spring over a box.
struct SpringRange {
  std::vector<BoxForm> features;  ///< as of SquaredLengths, by the places
  std::vector<double> middle_features;
  std::vector<BoxForm> forces;  ///< stiffness times the features that matter
  std::vector<Interval> middle_forces;
  BoxForm free_length;
  Interval middle_free_length;
  std::vector<Interval> squares;  ///< of the lengths by sample
};

/// Distances of the free numbers from the middle of a box that are still possible.
class PlaceRange {
 public:
  explicit PlaceRange(const VectorX& half);
  /// Keeps the places where a function can reach a target.
  /// @param middle value at the middle of the box
  /// @return false if there are none
  bool narrow(const BoxForm& form, const Interval& middle, const Interval& target);
  const std::vector<Interval>& ranges() const { return delta_; }

 private:
  std::vector<Interval> delta_;
};

/// A bound, and the share of each free number and each spring in its uncertainty.
struct LengthRatioBound {
  bool is_feasible = true;  ///< false: nothing in the box is below the cutoff
  double lower = 0;         ///< of the figure, for everything in the box below the cutoff
  VectorX score;            ///< of the places
  VectorX part_score;       ///< of stiffness and free length of each spring
};

/// @param cutoff of the figure; finite
/// @param places is narrowed to where the figure can be below it
LengthRatioBound bound_by_length_ratios(const SpringSeries& series, const std::vector<SpringRange>& springs,
                                        double cutoff, PlaceRange& places);

}  // namespace balance::design
