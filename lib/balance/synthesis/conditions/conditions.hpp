#pragma once
/// The complete balancing conditions of any mechanism: which linear combinations of its parameters must vanish.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/motion/study/balance_goal.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

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

/// R π = 0: necessary and sufficient. Behind the parameters of bodies and springs, π has known terms: loads and friction. Rows
/// come in two parts: first those that hold a parameter, which say what loads ask of it; then those of known terms alone,
/// which no choice of parameters can change.
struct Conditions {
  ConditionsStatus status = ConditionsStatus::unsolved;
  std::string reason;  ///< one sentence if not done
  std::vector<Goal> goals;
  std::vector<Parameter> parameters;  ///< P columns: list_terms
  VectorX known_term_values;          ///< values of the last ones, which are known terms [SI]
  std::vector<bool> variable_terms;   ///< of the known terms: as in ConditionOptions
  MatrixX matrix;           ///< rank × P [SI], reduced: each row is solved for its pivot, whose coefficient is 1
  std::vector<int> pivots;  ///< per row: a parameter that occurs in no other row
  VectorX
      row_scales;  ///< per row: the size of its terms in a mechanism of this mass and length; residuals are divided by it
  int rank = 0;
  double min_kept_singular_value = 0;     ///< singular value, the largest being 1
  double max_dropped_singular_value = 0;  ///< the next one
  double singular_value_gap = 0;          ///< their ratio; finite (round-off stands in for an exact zero)
  int samples = 0;                        ///< configurations that the rows were taken at
  std::vector<std::string> notes;         ///< what a user should know (which joints' accelerations are meant, …)

  /// Known term k is one that free numbers change.
  bool is_variable_term(Eigen::Index k) const {
    return static_cast<std::size_t>(k) < variable_terms.size() && variable_terms[static_cast<std::size_t>(k)];
  }
  /// Columns that are no known terms.
  Eigen::Index parameter_columns() const {
    return static_cast<Eigen::Index>(parameters.size()) - known_term_values.size();
  }
  /// Rows that hold a parameter; those behind them hold known terms alone.
  Eigen::Index parameter_rows() const;
};

struct ConditionOptions {
  Vector3 about =
      Vector3::Zero();  ///< world point of the angular momentum [m]; matters only while the force is not met
  FreeSprings loose_springs;
  std::vector<std::string> excluded;  ///< sections and elements that the goals leave out (left_out)
  std::vector<bool> variable_terms;   ///< known terms that free numbers change: asked for even where they are zero
  std::uint64_t seed = 1;             ///< of the configurations
};

/// Stacks the goals' rows at random admissible configurations and velocities, decides the rank and reduces the row space.
/// Source: P0 section 2; the method is described in docs/theory.md.
/// @param goals at least one; several: all of them at once
Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options = {});

/// How far parameters are from meeting the conditions, per row, divided by `scale`; signed.
/// @param values of all columns, or of those that are no known terms: then `known` stands for the others
VectorX scaled_residuals(const Conditions& conditions, const VectorX& values);

/// The goals' rows times the parameters at fixed samples: what is left over, for mechanisms that differ from a first one in
/// any numbers, lengths and ratios included. It vanishes where the conditions of that very mechanism are met, and it is a
/// smooth function of the numbers. Known terms that no parameter can balance are not counted.
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

  /// The rows by themselves, which depend on the geometry alone and are smooth in it, also where their rank falls.
  /// @param rows the residual per unit [SI] of every term (list_terms); less what the goal's own unknowns take up
  /// @return false as above; then the rows are unchanged
  bool rows(const Mechanism& mechanism, MatrixX& rows) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

// Conditions that nobody needs to read because they cannot fail.

/// Whether a condition is about discs alone and holds for every disc that is symmetrical about its axis: its CoM lies on the
/// axis, its inertia is the same all round.
bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism);

}  // namespace balance
