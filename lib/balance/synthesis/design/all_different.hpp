#pragma once
/// Variables with sizes, no two of which may have the same size: the constraint `alldifferent` of constraint programming.

#include "balance/synthesis/design/design_problem.hpp"

#include <utility>
#include <vector>

namespace balance::design {

/// The groups of DesignProblem::all_different.
class AllDifferent {
 public:
  /// @param problem must outlive this object
  explicit AllDifferent(const DesignProblem& problem);

  bool is_empty() const { return groups_.empty(); }
  /// Whether a variable is in a group.
  bool contains(int variable) const;
  /// Whether two variables of a group have the same size, or one has a size that is taken.
  bool is_violated(const VectorX& x) const;
  /// The same for a single variable. @param is_set variables that have a value; only these count
  bool is_violated_by(int variable, const VectorX& x, const std::vector<bool>& is_set) const;
  /// Other variables that must differ from this one and have its size.
  std::vector<int> find_equal(int variable, const VectorX& x) const;
  /// Whether in every group those variables that have no value yet can be given different sizes.
  bool can_complete(const VectorX& x, const std::vector<bool>& is_set) const;
  /// Removes sizes that are taken at the ends of intervals of sizes. @param is_active variables that count
  /// @return false if some group cannot have different sizes within the intervals
  bool propagate(VectorX& lower, VectorX& upper, const std::vector<bool>& is_active) const;
  /// The largest sum of different sizes in each group, as a coefficient for each variable and a limit. Empty for groups
  /// without active variables, or with negative sizes.
  std::vector<std::pair<VectorX, double>> sum_limits(const VectorX& lower, const VectorX& upper,
                                                     const std::vector<bool>& is_active) const;

 private:
  struct Group {
    std::vector<int> variables;
    std::vector<double> taken;
    double scale = 0;           ///< largest magnitude of a size
    std::vector<double> sizes;  ///< of all variables, different and ascending
    bool is_uniform = false;    ///< all variables have all sizes
  };
  const std::vector<double>& sizes_of(int variable) const;

  const DesignProblem& problem_;
  std::vector<Group> groups_;
};

}  // namespace balance::design
