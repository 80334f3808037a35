#pragma once
/// The least rms or peak of forces along a motion over all lengths: branch and bound over boxes of lengths.

#include "balance/synthesis/certificate/figure_box.hpp"
#include "balance/synthesis/certificate/length_bound.hpp"

#include <functional>
#include <memory>

namespace balance::certificate {

struct FigureBoundOptions {
  long max_nodes = 20'000;      ///< boxes bounded, at least 1
  double gap_tolerance = 1e-6;  ///< relative; the search ends below it
};

/// A branch and bound that can be continued, and that hears of designs that others found. It finds lengths that promise
/// good designs, but no designs itself.
class FigureBoundSearch {
 public:
  /// Bounds the whole box. @param space, problem, rows must outlive this object; the problem has no reason
  FigureBoundSearch(const DesignSpace& space, const FigureProblem& problem, const ForceRowModel& rows,
                    const FigureBoundOptions& options);
  ~FigureBoundSearch();

  /// Bounds boxes until the gap is closed, nothing is left to divide, the boxes or the time are used up.
  /// @param interrupted asked after every box
  void run(const std::function<bool()>& interrupted);
  /// @param x all free numbers @param value of the objective
  void add_design(const VectorX& x, double value);
  bool is_finished() const;
  /// All free numbers, with the lengths at which the least objective was found, and the masses and places for it where
  /// moments of inertia are relaxed. Empty: the motion could not be followed anywhere.
  const VectorX& promising() const;
  /// The objective there: no design with these lengths is better.
  double promised_value() const;
  /// The bound is in the unit of the objective.
  LengthBound result() const;

 private:
  class Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace balance::certificate
