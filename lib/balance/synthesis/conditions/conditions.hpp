#pragma once
/// The complete balancing conditions of any mechanism: which linear combinations of its parameters must vanish.

#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/motion/study/balance_goal.hpp"
#include "balance/synthesis/conditions/chosen_speeds.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"
#include "balance/synthesis/conditions/order_rows.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace balance::conditions {

enum class ConditionsStatus {
  unsolved,
  done,
  not_assembled,  ///< the loops cannot be closed
  mismatch,       ///< the goal needs actuators or a tool that the mechanism does not have
  rank_unclear,   ///< the singular values have no gap that separates conditions from round-off
};

/// R π = 0: necessary and sufficient. After the parameters of bodies and springs, π contains known terms: loads and
/// friction. Rows with parameters come first: they state what the loads require of the parameters. Rows with known
/// terms alone follow: no choice of parameters can change them.
struct Conditions {
  ConditionsStatus status = ConditionsStatus::unsolved;
  std::string reason;  ///< one sentence, unless done
  std::vector<Goal> goals;
  std::string speeds;  ///< names of those in whose derivatives efforts are written; empty: none are chosen
  std::vector<dynamics::Parameter> parameters;  ///< P columns: list_terms
  VectorX known_term_values;                    ///< values of the last columns, which are known terms [SI]
  std::vector<bool> variable_terms;             ///< per known term, as in ConditionOptions
  MatrixX matrix;           ///< rank × P [SI], reduced: each row is solved for its pivot, whose coefficient is 1
  std::vector<int> pivots;  ///< per row: a parameter that occurs in no other row
  VectorX row_scales;       ///< per row: magnitude of its terms for this mass and length; divides residuals
  int rank = 0;
  double min_kept_singular_value = 0;     ///< smallest singular value kept, relative to the largest
  double max_dropped_singular_value = 0;  ///< the next smaller one
  double singular_value_gap = 0;          ///< ratio of the two; finite (round-off replaces an exact zero)
  int samples = 0;                        ///< number of configurations at which rows were evaluated
  std::vector<std::string> notes;         ///< what a user should know (which joints' accelerations are meant, …)
  OrderRows orders;                       ///< of the goals that are orders

  /// Whether free numbers change known term k.
  bool is_variable_term(Eigen::Index k) const {
    return static_cast<std::size_t>(k) < variable_terms.size() && variable_terms[static_cast<std::size_t>(k)];
  }
  /// Number of columns that are not known terms.
  Eigen::Index parameter_columns() const {
    return static_cast<Eigen::Index>(parameters.size()) - known_term_values.size();
  }
  /// Number of rows that contain a parameter; the rows after them contain known terms alone.
  Eigen::Index parameter_rows() const;
};

struct ConditionOptions {
  Vector3 about = Vector3::Zero();  ///< world point of the angular momentum [m]; irrelevant once the force is balanced
  dynamics::FreeSprings loose_springs;
  std::vector<std::string> excluded;     ///< sections and elements that the goals ignore (left_out)
  std::vector<bool> variable_terms;      ///< known terms that free numbers change: included even where they are zero
  std::uint64_t seed = 1;                ///< of the random configurations
  std::vector<Trajectory> motions = {};  ///< that goals of orders name (study::select_goal_motions)
  /// If not empty, velocity terms and inertia are those of the equations in the derivatives of these speeds, as many of
  /// them as there are freedoms: the first ones that determine the motion.
  ChosenSpeeds speeds;
};

/// Coordinates whose joints must not be cut when conditions are derived.
std::vector<CoordinateId> list_needed_coordinates(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                                  const ConditionOptions& options);

/// Stacks the goals' rows at random admissible configurations and velocities, finds the rank and reduces the row space.
/// Source: P0 section 2; the method is described in docs/theory.md.
/// @param goals at least one; several must hold simultaneously
Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options = {});

/// Signed residual of each condition, divided by `row_scales`.
/// @param values of all columns, or of those that are not known terms: then `known_term_values` completes them
VectorX scaled_residuals(const Conditions& conditions, const VectorX& values);

/// The goals' rows times the parameters at fixed samples, for mechanisms that differ from the first one in any numbers,
/// including lengths and ratios. The residual vanishes if the given mechanism meets its own conditions, and it is a
/// smooth function of the numbers. Known terms that no parameter can balance are not counted.
class GoalResidual {
 public:
  /// @throws std::invalid_argument if the mechanism has no conditions for these goals (see derive_conditions)
  GoalResidual(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options = {});
  ~GoalResidual();
  GoalResidual(GoalResidual&&) noexcept;
  GoalResidual& operator=(GoalResidual&&) noexcept;

  /// @param residual scaled as in scaled_residuals; its length never changes
  /// @return false if a sample cannot be assembled with these numbers; then the residual is unchanged
  bool evaluate(const Mechanism& mechanism, VectorX& residual);

  /// The rows themselves, which depend on the geometry alone and are smooth in it, even where their rank drops.
  /// @param rows the residual per unit [SI] of every term (list_terms), without what the goal's own unknowns absorb
  /// @return false as above; then the rows are unchanged
  bool rows(const Mechanism& mechanism, MatrixX& rows) const;

  struct Implementation;

 private:
  std::unique_ptr<Implementation> implementation_;
};

// Conditions that always hold and need not be shown.

/// Whether a condition involves discs alone and holds for every disc that is symmetric about its axis: its CoM lies on
/// the axis, and its inertia is the same in all directions across it.
bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism);

}  // namespace balance::conditions

namespace balance {

using conditions::ConditionOptions;
using conditions::Conditions;
using conditions::ConditionsStatus;
using conditions::derive_conditions;

}  // namespace balance
