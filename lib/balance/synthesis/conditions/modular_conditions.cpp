#include "balance/synthesis/conditions/modular_conditions.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/kinematics/compiled_trajectory.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/synthesis/conditions/chain_split.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace balance::conditions {

namespace {

/// Terms of a condition below this, relative to its largest one, are round-off.
constexpr double condition_term_tolerance = 1e-11;

/// Stores every joint coordinate of the assembled pose, so that the chains are assembled in the same mode.
template <class S>
bool complete_assembly(Mechanism& mechanism) {
  kinematics::Tree<S> tree = kinematics::compile_tree<S>(mechanism, mechanism.actuators);
  kinematics::ConstraintSystem<S> closures(tree, kinematics::Drive<S>{});
  const kinematics::AssemblySolution pose = kinematics::solve_pose(mechanism, tree, closures, {});
  if (!pose.found) return false;
  kinematics::TreeState<S> state(tree.nodes.size());
  compute_poses(tree, pose.y.data(), state);
  mechanism.assembly.clear();
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const Coordinate& coordinate = mechanism.coordinates[c];
    const Joint& joint = mechanism.joints[static_cast<std::size_t>(coordinate.joint)];
    const kinematics::JointMotion motion = compute_joint_motion(joint, relative_motion(tree, state, joint));
    mechanism.assembly.push_back({static_cast<int>(c), motion.position[static_cast<std::size_t>(coordinate.index)]});
  }
  return true;
}

bool complete_assembly(Mechanism& mechanism) {
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) { return complete_assembly<S>(mechanism); });
}

/// Why the strategy does not apply to the goals; empty if it does.
std::string mismatch_reason(const std::vector<Goal>& goals, bool serial) {
  for (const Goal& goal : goals) {
    const bool independent = goal.kind == GoalKind::gyroscopic_independent;
    if (goal.is_fully || (goal.kind != GoalKind::statics && goal.kind != GoalKind::gyroscopic && !independent))
      return "the modular strategy is for the goals static, gyroscopic and gyroscopic-independent, not for " +
             goal_name(goal);
    if (independent && !serial)
      return "balanced chains have no velocity terms in their own joints' accelerations, but the loops bring them back "
             "in the actuators' accelerations: the modular strategy cannot guarantee gyroscopic-independent";
  }
  return "";
}

class ModularDerivation {
 public:
  ModularDerivation(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options)
      : mechanism_(mechanism), options_(options) {
    out_.goals = goals;
    out_.parameters = list_terms(mechanism, options.loose_springs);
    out_.known_term_values = known_term_values(mechanism);
    out_.variable_terms = options.variable_terms;
    unfiltered_options_ = options;
    unfiltered_options_.excluded.clear();  // applied at the end, by names of the whole mechanism
  }

  Conditions run() {
    ChainSplit split = split_into_chains(mechanism_, options_.loose_springs);
    if (!split.failure_reason.empty()) return refuse(ConditionsStatus::mismatch, split.failure_reason);
    if (const std::string reason = mismatch_reason(out_.goals, split.is_serial); !reason.empty())
      return refuse(ConditionsStatus::mismatch, reason);
    if (split.is_serial) return derive_complete();
    if (has_velocity_constraints(mechanism_))
      return refuse(ConditionsStatus::mismatch, "the modular strategy does not support constraints on speeds");
    if (!complete_assembly(mechanism_)) return refuse(ConditionsStatus::not_assembled, "the loops cannot be closed");
    split = split_into_chains(mechanism_, options_.loose_springs);
    out_.notes = split.notes;
    const NaturalUnits units(mechanism_, out_.parameters);
    for (const Chain& chain : split.chains) {
      ConditionOptions options = unfiltered_options_;
      options.loose_springs = chain.loose_springs;
      options.variable_terms.assign(list_known_terms(chain.mechanism).size(), true);
      const Conditions chain_conditions = derive_conditions(chain.mechanism, out_.goals, options);
      if (chain_conditions.status != ConditionsStatus::done)
        return refuse(chain_conditions.status, fmt::format("chain ({}): {}", chain.name, chain_conditions.reason));
      append(chain_conditions, chain.mechanism, chain.parameters, units);
      add_notes(chain_conditions.notes);
    }
    add_gyroscopic_note(split.chains);
    if (!add_unassigned(split.unassigned, units)) return std::move(out_);
    return finish(units);
  }

 private:
  Conditions derive_complete() {
    Conditions out = derive_conditions(mechanism_, out_.goals, options_);
    out.notes.insert(out.notes.begin(), "there is no loop: the modular strategy is the ordinary one");
    return out;
  }

  Conditions refuse(ConditionsStatus status, const std::string& reason) {
    out_.status = status;
    out_.reason = reason;
    return std::move(out_);
  }

  /// Appends conditions on parameters that are linear in the whole mechanism's, in natural units.
  void append(const Conditions& conditions, const Mechanism& mechanism, const MatrixX& parameter_map,
              const NaturalUnits& units) {
    const VectorX parameter_units = NaturalUnits(mechanism, conditions.parameters).parameter;
    const Eigen::Index row_count = rows_.rows();
    rows_.conservativeResize(row_count + conditions.matrix.rows(), units.parameter.size());
    for (Eigen::Index r = 0; r < conditions.matrix.rows(); ++r) {
      const double size = numerics::max_abs(conditions.matrix.row(r).cwiseProduct(parameter_units.transpose()));
      auto row = rows_.row(row_count + r);
      row = conditions.matrix.row(r) * parameter_map * units.parameter.asDiagonal() / size;
      row = (row.array().abs() > condition_term_tolerance).select(row, 0.0);
    }
    out_.samples += conditions.samples;
  }

  void add_notes(const std::vector<std::string>& notes) {
    for (const std::string& note : notes)
      if (std::find(out_.notes.begin(), out_.notes.end(), note) == out_.notes.end()) out_.notes.push_back(note);
  }

  void add_gyroscopic_note(const std::vector<Chain>& chains) {
    const auto is_gyroscopic = [](const Goal& goal) { return goal.kind == GoalKind::gyroscopic; };
    if (std::none_of(out_.goals.begin(), out_.goals.end(), is_gyroscopic)) return;
    std::string joints;
    for (const Chain& chain : chains)
      for (const Joint& joint : chain.mechanism.joints)
        if (joint_degrees_of_freedom(joint.type) > 0) joints += (joints.empty() ? "" : ", ") + joint.name;
    out_.notes.push_back(
        "no velocity terms: when every chain's efforts are written in the accelerations of its joints, " + joints);
  }

  /// Balances what no chain carries by itself, with the whole mechanism moving.
  bool add_unassigned(const MatrixX& remainder_map, const NaturalUnits& units) {
    if (!is_relevant(remainder_map)) return true;
    const Conditions conditions = derive_conditions(mechanism_, out_.goals, unfiltered_options_);
    if (conditions.status != ConditionsStatus::done) {
      refuse(conditions.status, conditions.reason);
      return false;
    }
    const Eigen::Index row_count = rows_.rows();
    append(conditions, mechanism_, remainder_map, units);
    if (rows_.rows() == row_count || rows_.bottomRows(rows_.rows() - row_count).isZero(0)) return true;
    out_.notes.push_back("the remainder is balanced separately, with the whole mechanism moving");
    add_notes(conditions.notes);
    return true;
  }

  /// Weight does not depend on moments of inertia.
  bool is_relevant(const MatrixX& remainder_map) const {
    const bool is_dynamic = std::any_of(out_.goals.begin(), out_.goals.end(),
                                        [](const Goal& goal) { return goal.kind != GoalKind::statics; });
    for (std::size_t p = 0; p < out_.parameters.size(); ++p) {
      const dynamics::ParameterKind kind = out_.parameters[p].kind;
      const bool is_second_moment =
          kind == dynamics::ParameterKind::moment_of_inertia || kind == dynamics::ParameterKind::product_of_inertia;
      if ((is_dynamic || !is_second_moment) && !remainder_map.row(static_cast<Eigen::Index>(p)).isZero(0)) return true;
    }
    return false;
  }

  Conditions finish(const NaturalUnits& units) {
    for (std::size_t p = 0; p < out_.parameters.size() && rows_.rows() > 0; ++p) {
      const auto column = static_cast<Eigen::Index>(p);
      const Eigen::Index k = column - out_.parameter_columns();
      if ((k >= 0 && out_.known_term_values[k] == 0 && !out_.is_variable_term(k)) ||
          is_excluded(mechanism_, out_.parameters[p], options_.excluded))
        rows_.col(column).setZero();
    }
    if (!options_.excluded.empty())
      out_.notes.push_back(fmt::format("left out: {}", fmt::join(options_.excluded, ", ")));
    const std::vector<int> order = order_pivots(mechanism_, out_.parameters);
    if (!reduce_conditions(rows_, units.parameter, units.mass, order, out_))
      return refuse(ConditionsStatus::rank_unclear, "the chains' conditions are too nearly dependent to be counted");
    out_.status = ConditionsStatus::done;
    return std::move(out_);
  }

  Mechanism mechanism_;
  const ConditionOptions& options_;
  ConditionOptions unfiltered_options_;
  Conditions out_;
  MatrixX rows_;
};

}  // namespace

Conditions derive_modular_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                     const ConditionOptions& options) {
  if (goals.empty()) throw std::invalid_argument("conditions need a goal");
  return ModularDerivation(mechanism, goals, options).run();
}

}  // namespace balance::conditions
