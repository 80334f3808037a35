#include "balance/synthesis/conditions/conditions.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/conditions/condition_notes.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance::conditions {

namespace {

constexpr int min_condition_samples = 12, max_condition_samples = 2000;
constexpr int max_rank_retries = 2;  ///< each with more samples, before the status becomes rank_unclear

/// Whether all entries, which are of order one in natural units, can still be squared. False for NaN, too.
bool is_representable(const MatrixX& rows) { return (rows.array().abs() < 1e100).all(); }

template <class S>
class ConditionDerivation {
 public:
  ConditionDerivation(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options)
      : mechanism_(mechanism),
        options_(options),
        tree_(kinematics::compile_tree<S>(mechanism, list_needed_coordinates(mechanism, goals, options))),
        sampler_(mechanism, tree_, options.seed),
        random_(options.seed + 1) {
    out_.goals = goals;
    out_.parameters = list_terms(mechanism, options.loose_springs);
    out_.known_term_values = known_term_values(mechanism);
    out_.variable_terms = options.variable_terms;
  }

  Conditions run() {
    SampledConfiguration configuration;
    if (!sampler_.next(configuration)) return refuse(ConditionsStatus::not_assembled, sampler_.infeasibility_reason());
    const NaturalUnits units(mechanism_, out_.parameters);
    GoalRows<S> rows(mechanism_, tree_, units, out_.goals, options_, sampler_.freedoms());
    if (!rows.mismatch_reason().empty()) return refuse(ConditionsStatus::mismatch, rows.mismatch_reason());
    const std::vector<int> order = order_pivots(mechanism_, out_.parameters);
    if (has_goals(true)) {
      out_.orders =
          compute_order_rows(mechanism_, out_.goals, options_.motions, options_.loose_springs, units.parameter);
      if (!out_.orders.mismatch.empty()) return refuse(ConditionsStatus::mismatch, out_.orders.mismatch);
      if (!has_goals(false)) return reduce_with_orders(rows, units, order);
    }
    MatrixX stacked_rows(0, rows.parameters() + rows.extra_unknowns());
    for (int k = 0, min_rows = 2 * static_cast<int>(stacked_rows.cols()) + 20; k <= max_rank_retries;
         ++k, min_rows *= 2) {
      if (!collect_rows(rows, configuration, min_rows, stacked_rows))
        return refuse(ConditionsStatus::not_assembled,
                      rows.has_constant_speeds()
                          ? "too few configurations were found in which the coordinates at constant speed are "
                            "independent and the actuators hold the mechanism"
                      : options_.speeds.empty()
                          ? "too few configurations were found in which the actuators hold the mechanism"
                          : "too few configurations were found in which the speeds determine the motion and the "
                            "actuators hold the mechanism");
      if (!is_representable(stacked_rows) || !units.parameter.allFinite())
        return refuse(ConditionsStatus::rank_unclear,
                      has_mass(mechanism_) ? "numbers overflow: terms of the conditions are too large to represent"
                                           : model::no_mass_message);
      if (!reduce_conditions(eliminate_extra_unknowns(stacked_rows, rows.parameters()), units.parameter, units.mass,
                             order, out_))
        continue;
      if (has_goals(true)) return reduce_with_orders(rows, units, order);
      out_.status = ConditionsStatus::done;
      add_notes();
      return std::move(out_);
    }
    return refuse(
        ConditionsStatus::rank_unclear,
        fmt::format("the number of conditions is not clear: the widest gap between singular values is {:.1e}, from "
                    "{:.1e} to {:.1e}",
                    out_.singular_value_gap, out_.min_kept_singular_value, out_.max_dropped_singular_value));
  }

 private:
  bool has_goals(bool are_orders) const {
    return std::any_of(out_.goals.begin(), out_.goals.end(),
                       [&](const Goal& goal) { return (goal.kind == GoalKind::order) == are_orders; });
  }

  /// The conditions of the other goals so far, if there are any, and those of the orders.
  Conditions reduce_with_orders(const GoalRows<S>& rows, const NaturalUnits& units, const std::vector<int>& order) {
    for (OrderRow& row : out_.orders.rows) row.coefficients.array() *= rows.term_mask().array();
    const bool has_others = has_goals(false);
    const double kept = out_.min_kept_singular_value, dropped = out_.max_dropped_singular_value,
                 gap = out_.singular_value_gap;
    MatrixX basis = has_others ? condition_basis(out_, units.parameter) : MatrixX(0, units.parameter.size());
    const MatrixX order_rows = scale_order_rows(out_.orders, units.parameter, rows.term_mask());
    if (!is_representable(order_rows) || !units.parameter.allFinite())
      return refuse(ConditionsStatus::rank_unclear,
                    has_mass(mechanism_) ? "numbers overflow: terms of the conditions are too large to represent"
                                         : model::no_mass_message);
    if (const std::optional<OrderRemainder> unclear = add_order_rows(order_rows, basis)) {
      const OrderRow& row = out_.orders.rows[static_cast<std::size_t>(unclear->row)];
      return refuse(
          ConditionsStatus::rank_unclear,
          fmt::format("the number of conditions is not clear: beside the others, the goal {} requires {:.1e} of "
                      "the size of {} to vanish, hardly more than round-off",
                      goal_name(out_.goals[row.goal]), unclear->size, row.quantity));
    }
    if (!reduce_conditions(basis, units.parameter, units.mass, order, out_))
      return refuse(ConditionsStatus::rank_unclear, "the number of conditions is not clear");
    if (has_others) {
      out_.min_kept_singular_value = kept;
      out_.max_dropped_singular_value = dropped;
      out_.singular_value_gap = gap;
    }
    out_.status = ConditionsStatus::done;
    add_notes();
    return std::move(out_);
  }

  /// Adds rows until there are `min_rows`, starting with the given configuration.
  bool collect_rows(GoalRows<S>& rows, SampledConfiguration& configuration, int min_rows, MatrixX& stacked_rows) {
    std::vector<MatrixX> blocks{stacked_rows};
    Eigen::Index count = stacked_rows.rows();
    for (int attempts = 0; count < min_rows || out_.samples < min_condition_samples; ++attempts) {
      if (attempts == max_condition_samples) return false;
      const VectorX velocity = configuration.null_space * random_.sample_normal(configuration.null_space.cols());
      const VelocityProbe probe{mix_directions(configuration.null_space, min_rows / min_condition_samples + 1),
                                velocity};
      MatrixX block;
      if (rows.evaluate(configuration, probe, block)) {
        ++out_.samples;
        count += block.rows();
        blocks.push_back(std::move(block));
        if (count == 0) break;  // the mechanism has nothing that the goal requires to vanish
      }
      if (!sampler_.next(configuration)) return false;
    }
    stacked_rows.resize(count, stacked_rows.cols());
    Eigen::Index first_row = 0;
    for (const MatrixX& block : blocks) {
      stacked_rows.middleRows(first_row, block.rows()) = block;
      first_row += block.rows();
    }
    return true;
  }

  /// Replaces many directions by `count` random mixtures. They suffice: a goal's rows come from several configurations.
  MatrixX mix_directions(const MatrixX& directions, Eigen::Index count) {
    constexpr Eigen::Index max_probe_directions = 48;
    const Eigen::Index direction_count = directions.cols();
    if (direction_count <= std::max(max_probe_directions, count)) return directions;
    MatrixX mixed(directions.rows(), count);
    for (Eigen::Index k = 0; k < count; ++k)
      mixed.col(k) = directions * random_.sample_normal(direction_count).normalized();
    return mixed;
  }

  Conditions refuse(ConditionsStatus status, const std::string& reason) {
    out_.status = status;
    out_.reason = reason;
    return std::move(out_);
  }

  void add_notes() {
    const auto has_goal = [&](GoalKind kind) {
      return std::any_of(out_.goals.begin(), out_.goals.end(), [&](const Goal& g) { return g.kind == kind; });
    };
    const bool has_effort_goal = has_goal(GoalKind::statics) || has_goal(GoalKind::gyroscopic) ||
                                 has_goal(GoalKind::decoupled) || has_goal(GoalKind::gyroscopic_independent);
    if (!options_.excluded.empty()) {
      std::string names;
      for (const std::string& name : options_.excluded) names += (names.empty() ? "" : ", ") + name;
      out_.notes.push_back("left out: " + names);
    }
    if (has_effort_goal && mechanism_.gravity.norm() == 0) out_.notes.emplace_back(no_gravity_note);
    for (const dynamics::Parameter& p : out_.parameters)
      if (has_effort_goal && p.kind == dynamics::ParameterKind::stiffness_moment &&
          !mechanism_.springs[static_cast<std::size_t>(p.index)].is_joint_spring()) {
        out_.notes.push_back(p.owner +
                             ".kaxby stands for the stiffness times x of the spring's first end times y of its second");
        break;
      }
    add_constant_speed_notes();
    for (const OrderMotion& motion : out_.orders.motions)
      if (motion.known_term_error > motion.spectral_error + 1e-12)
        out_.notes.push_back(
            fmt::format("along {} the orders of loads and friction, which are not smooth, are accurate to "
                        "{:.1g} of their size",
                        motion.trajectory, motion.known_term_error));
    if (!options_.speeds.empty()) return add_speeds_note(has_effort_goal);
    if (tree_.closure_rows == 0 || (!has_goal(GoalKind::gyroscopic) && !has_goal(GoalKind::decoupled))) return;
    std::string joints;
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (tree_.joint_nodes[j] >= 0 && joint_degrees_of_freedom(mechanism_.joints[j].type) > 0)
        joints += (joints.empty() ? "" : ", ") + mechanism_.joints[j].name;
    out_.notes.push_back("no velocity terms: when the efforts are written in the accelerations of " + joints);
  }

  /// Says which coordinates goals at constant speed mean, once for each set.
  void add_constant_speed_notes() {
    std::vector<std::string> notes;
    for (const Goal& goal : out_.goals) {
      if (!goal.is_at_constant_speed) continue;
      const std::vector<CoordinateId> coordinates = study::list_constant_speed_coordinates(goal, mechanism_);
      std::string names;
      for (const CoordinateId c : coordinates)
        names += (names.empty() ? "" : ", ") + mechanism_.coordinates[static_cast<std::size_t>(c)].name;
      std::string note = "at constant speed: " + (names.empty() ? std::string("all coordinates") : names);
      if (!names.empty() && static_cast<int>(coordinates.size()) < sampler_.freedoms())
        note += "; other freedoms may accelerate";
      if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(std::move(note));
    }
    out_.notes.insert(out_.notes.end(), notes.begin(), notes.end());
  }

  void add_speeds_note(bool has_effort_goal) {
    if (!has_effort_goal) {
      out_.notes.push_back("the goals do not depend on the choice of speeds");
      return;
    }
    for (const model::GeneralisedSpeed& speed : options_.speeds.in(mechanism_))
      out_.speeds += (out_.speeds.empty() ? "" : ", ") + speed.name;
    out_.notes.push_back("velocity terms and inertia: when the efforts are written in the derivatives of " +
                         out_.speeds);
    if (options_.speeds.depend_on_masses())
      out_.notes.push_back(
          "the centre of mass in these speeds is that of the present masses: whether they meet the conditions is "
          "exact; for other masses, which move it, the coefficients are others");
  }

  const Mechanism& mechanism_;
  const ConditionOptions& options_;
  kinematics::Tree<S> tree_;
  ConfigurationSampler<S> sampler_;
  numerics::UniformRandom random_;
  Conditions out_;
};

}  // namespace

std::vector<CoordinateId> list_needed_coordinates(const Mechanism& mechanism, const std::vector<Goal>& goals,
                                                  const ConditionOptions& options) {
  std::vector<CoordinateId> needed = mechanism.actuators;
  const std::vector<CoordinateId> of_speeds = options.speeds.coordinates();
  needed.insert(needed.end(), of_speeds.begin(), of_speeds.end());
  for (const Goal& goal : goals) {
    const std::vector<CoordinateId> of_goal = study::list_constant_speed_coordinates(goal, mechanism);
    needed.insert(needed.end(), of_goal.begin(), of_goal.end());
  }
  return needed;
}

Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options) {
  if (goals.empty()) throw std::invalid_argument("conditions need a goal");
  return kinematics::dispatch_space(
      mechanism.space, [&]<class S>(S) { return ConditionDerivation<S>(mechanism, goals, options).run(); });
}

Eigen::Index Conditions::parameter_rows() const {
  Eigen::Index rows = matrix.rows();
  while (known_term_values.size() > 0 && rows > 0 && matrix.row(rows - 1).head(parameter_columns()).isZero(0)) --rows;
  return rows;
}

VectorX scaled_residuals(const Conditions& conditions, const VectorX& values) {
  VectorX all_values = values;
  if (values.size() == conditions.parameter_columns()) {
    all_values.resize(values.size() + conditions.known_term_values.size());
    all_values << values, conditions.known_term_values;
  }
  return (conditions.matrix * all_values).cwiseQuotient(conditions.row_scales);
}

namespace {

/// A disc with the given moments of inertia about its axis and across it.
Disc make_symmetric_disc(const Disc& disc, double mass, double axial, double transverse) {
  Disc result = disc;
  result.mass = mass;
  result.inertia = transverse * Matrix3::Identity() + (axial - transverse) * disc.axis * disc.axis.transpose();
  return result;
}

/// Parameters of a mechanism in which only one disc has mass or inertia.
VectorX single_disc_parameters(const Mechanism& mechanism, std::size_t disc_index, double mass, double axial,
                               double transverse) {
  Mechanism single_disc = mechanism;
  for (Disc& disc : single_disc.discs) disc = make_symmetric_disc(disc, 0, 0, 0);
  single_disc.discs[disc_index] = make_symmetric_disc(mechanism.discs[disc_index], mass, axial, transverse);
  return dynamics::parameter_values(single_disc);
}

}  // namespace

bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism) {
  const VectorX coefficients = conditions.matrix.row(row);
  const double largest = numerics::max_abs(coefficients);
  Eigen::Index begin = coefficients.size(), end = 0;
  for (Eigen::Index p = 0; p < coefficients.size(); ++p) {
    if (std::abs(coefficients[p]) <= 1e-12 * largest) continue;
    if (conditions.parameters[static_cast<std::size_t>(p)].owner_kind != dynamics::ParameterOwner::disc) return false;
    begin = std::min(begin, p);
    end = p + 1;
  }
  const auto vanishes = [&](std::size_t disc, double mass, double axial, double transverse) {
    // Springs come last, so the discs' parameters have the same columns however springs are described.
    const VectorX values = single_disc_parameters(mechanism, disc, mass, axial, transverse);
    return begin >= end ||
           std::abs(coefficients.segment(begin, end - begin).dot(values.segment(begin, end - begin))) <= 1e-9 * largest;
  };
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d)
    if (!vanishes(d, 1, 0, 0) || !vanishes(d, 0, 1, 0) || !vanishes(d, 0, 0, 1)) return false;
  return true;
}

}  // namespace balance::conditions
