#pragma once
/// The complete balancing conditions of any mechanism: which linear combinations of its parameters must vanish.

#include "balance/conditions/goal.hpp"
#include "balance/conditions/parameter.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace balance {

enum class ConditionsStatus {
  unsolved,
  done,
  not_assembled,  ///< the loops cannot be closed
  mismatch,       ///< the goal asks for actuators or a tool that the mechanism does not have
  rank_unclear,   ///< the singular values have no gap that separates conditions from round-off
};

/// R π = 0: necessary and sufficient.
struct Conditions {
  ConditionsStatus status = ConditionsStatus::unsolved;
  std::string reason;  ///< one sentence if not done
  std::vector<Goal> goals;
  std::vector<Parameter> parameters;  ///< P columns
  MatrixX matrix;           ///< rank × P [SI], reduced: each row is solved for its pivot, whose coefficient is 1
  std::vector<int> pivots;  ///< per row: a parameter that occurs in no other row
  VectorX
      scale;  ///< per row: the size of its terms in a mechanism of this mass and length; residuals are divided by it
  int rank = 0;
  double smallest_kept = 0;        ///< singular value, the largest being 1
  double largest_dropped = 0;      ///< the next one
  double gap = 0;                  ///< their ratio; finite (round-off stands in for an exact zero)
  int samples = 0;                 ///< configurations that the rows were taken at
  std::vector<std::string> notes;  ///< what a user should know (which joints' accelerations are meant, …)
};

struct ConditionOptions {
  Vector3 about =
      Vector3::Zero();  ///< world point of the angular momentum [m]; matters only while the force is not met
  LooseSprings loose_springs;
  std::uint64_t seed = 1;  ///< of the configurations
};

/// Stacks the goals' rows at random admissible configurations and velocities, decides the rank and reduces the row space.
/// Source: P0 section 2; the method is described in docs/theory.md.
/// @param goals at least one; several: all of them at once
Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options = {});

/// How far parameters are from meeting the conditions, per row, divided by `scale`; signed.
VectorX scaled_residuals(const Conditions& conditions, const VectorX& parameters);

/// The goals' rows times the parameters at fixed samples: what is left over, for mechanisms that differ from a first one in
/// any numbers, lengths and ratios included. It vanishes where the conditions of that very mechanism are met, and it is a
/// smooth function of the numbers.
class GoalResidual {
 public:
  /// @throws std::invalid_argument if the mechanism has no conditions for these goals (see derive_conditions)
  GoalResidual(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options = {});
  ~GoalResidual();
  GoalResidual(GoalResidual&&) noexcept;
  GoalResidual& operator=(GoalResidual&&) noexcept;

  /// @param residual scaled like scaled_residuals, always of the same length
  /// @return false if a sample cannot be assembled with these numbers; then the residual is unchanged
  bool evaluate(const Mechanism& mechanism, VectorX& residual);

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace balance
