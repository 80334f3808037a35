#include "balance/synthesis/conditions/conditions.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

constexpr int min_condition_samples = 12, max_condition_samples = 2000;
constexpr int max_rank_retries = 2;  ///< with more samples each, before the rank is called unclear

/// Entries are of the order one in natural units; squares of such numbers have no value any more. False for NaN, too.
bool is_representable(const MatrixX& rows) { return (rows.array().abs() < 1e100).all(); }

template <class S>
class ConditionDerivation {
 public:
  ConditionDerivation(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options)
      : mechanism_(mechanism),
        options_(options),
        tree_(compile_tree<S>(mechanism, mechanism.actuators)),
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
    MatrixX all(0, rows.parameters() + rows.extra_unknowns());
    for (int k = 0, wanted = 2 * static_cast<int>(all.cols()) + 20; k <= max_rank_retries; ++k, wanted *= 2) {
      if (!collect_rows(rows, configuration, wanted, all))
        return refuse(ConditionsStatus::not_assembled,
                      "too few configurations were found in which the actuators hold the mechanism");
      if (!is_representable(all) || !units.parameter.allFinite())
        return refuse(ConditionsStatus::rank_unclear,
                      has_mass(mechanism_)
                          ? "numbers overflow: terms of the conditions are larger than can be computed with"
                          : no_mass_message);
      if (!reduce_conditions(eliminate_extra_unknowns(all, rows.parameters()), units.parameter, units.mass, order,
                             out_))
        continue;
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
  /// More rows, until there are `wanted`, starting with a configuration at hand.
  bool collect_rows(GoalRows<S>& rows, SampledConfiguration& configuration, int wanted, MatrixX& all) {
    std::vector<MatrixX> blocks{all};
    Eigen::Index count = all.rows();
    for (int tried = 0; count < wanted || out_.samples < min_condition_samples; ++tried) {
      if (tried == max_condition_samples) return false;
      const VectorX velocity = configuration.null_space * random_.normal(configuration.null_space.cols());
      const VelocityProbe probe{mix_directions(configuration.null_space, wanted / min_condition_samples + 1), velocity};
      MatrixX block;
      if (rows.evaluate(configuration, probe, block)) {
        ++out_.samples;
        count += block.rows();
        blocks.push_back(std::move(block));
        if (count == 0) break;  // nothing that the goal wants to vanish exists
      }
      if (!sampler_.next(configuration)) return false;
    }
    all.resize(count, all.cols());
    Eigen::Index at = 0;
    for (const MatrixX& block : blocks) {
      all.middleRows(at, block.rows()) = block;
      at += block.rows();
    }
    return true;
  }

  /// Of many directions so many mixtures at random, which are as good: each goal's rows come from several configurations anyway.
  MatrixX mix_directions(const MatrixX& directions, Eigen::Index count) {
    constexpr Eigen::Index max_probe_directions = 48;
    const Eigen::Index all = directions.cols();
    if (all <= std::max(max_probe_directions, count)) return directions;
    MatrixX mixed(directions.rows(), count);
    for (Eigen::Index k = 0; k < count; ++k) mixed.col(k) = directions * random_.normal(all).normalized();
    return mixed;
  }

  Conditions refuse(ConditionsStatus status, const std::string& reason) {
    out_.status = status;
    out_.reason = reason;
    return std::move(out_);
  }

  void add_notes() {
    const auto wants = [&](GoalKind kind) {
      return std::any_of(out_.goals.begin(), out_.goals.end(), [&](const Goal& g) { return g.kind == kind; });
    };
    const bool efforts = wants(GoalKind::statics) || wants(GoalKind::gyroscopic) || wants(GoalKind::decoupled) ||
                         wants(GoalKind::gyroscopic_independent);
    if (!options_.excluded.empty()) {
      std::string names;
      for (const std::string& name : options_.excluded) names += (names.empty() ? "" : ", ") + name;
      out_.notes.push_back("left out: " + names);
    }
    if (efforts && mechanism_.gravity.norm() == 0)
      out_.notes.push_back("there is no gravity in this spec: weight asks for nothing");
    for (const Parameter& p : out_.parameters)
      if (efforts && p.kind == ParameterKind::stiffness_moment &&
          !mechanism_.springs[static_cast<std::size_t>(p.index)].is_joint_spring()) {
        out_.notes.push_back(p.owner +
                             ".kaxby stands for the stiffness times x of the spring's first end times y of its second");
        break;
      }
    if (tree_.closure_rows == 0 || (!wants(GoalKind::gyroscopic) && !wants(GoalKind::decoupled))) return;
    std::string joints;
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (tree_.joint_nodes[j] >= 0 && joint_degrees_of_freedom(mechanism_.joints[j].type) > 0)
        joints += (joints.empty() ? "" : ", ") + mechanism_.joints[j].name;
    out_.notes.push_back("no velocity terms: when the efforts are written in the accelerations of " + joints);
  }

  const Mechanism& mechanism_;
  const ConditionOptions& options_;
  Tree<S> tree_;
  ConfigurationSampler<S> sampler_;
  UniformRandom random_;
  Conditions out_;
};

}  // namespace

Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options) {
  if (goals.empty()) throw std::invalid_argument("conditions need a goal");
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return ConditionDerivation<S>(mechanism, goals, options).run(); });
}

Eigen::Index Conditions::parameter_rows() const {
  Eigen::Index rows = matrix.rows();
  while (known_term_values.size() > 0 && rows > 0 && matrix.row(rows - 1).head(parameter_columns()).isZero(0)) --rows;
  return rows;
}

VectorX scaled_residuals(const Conditions& conditions, const VectorX& values) {
  VectorX all = values;
  if (values.size() == conditions.parameter_columns()) {
    all.resize(values.size() + conditions.known_term_values.size());
    all << values, conditions.known_term_values;
  }
  return (conditions.matrix * all).cwiseQuotient(conditions.row_scales);
}

namespace {

/// A disc with one moment of inertia about its axis and another across it.
Disc make_symmetric_disc(const Disc& disc, double mass, double axial, double transverse) {
  Disc result = disc;
  result.mass = mass;
  result.inertia = transverse * Matrix3::Identity() + (axial - transverse) * disc.axis * disc.axis.transpose();
  return result;
}

/// Parameters of a mechanism in which only one disc has mass or inertia.
VectorX single_disc_parameters(const Mechanism& mechanism, std::size_t which, double mass, double axial,
                               double transverse) {
  Mechanism alone = mechanism;
  for (Disc& disc : alone.discs) disc = make_symmetric_disc(disc, 0, 0, 0);
  alone.discs[which] = make_symmetric_disc(mechanism.discs[which], mass, axial, transverse);
  return parameter_values(alone);
}

}  // namespace

bool is_met_by_symmetric_discs(const Conditions& conditions, int row, const Mechanism& mechanism) {
  const VectorX coefficients = conditions.matrix.row(row);
  const double largest = max_abs(coefficients);
  Eigen::Index begin = coefficients.size(), end = 0;
  for (Eigen::Index p = 0; p < coefficients.size(); ++p) {
    if (std::abs(coefficients[p]) <= 1e-12 * largest) continue;
    if (conditions.parameters[static_cast<std::size_t>(p)].owner_kind != ParameterOwner::disc) return false;
    begin = std::min(begin, p);
    end = p + 1;
  }
  const auto vanishes = [&](std::size_t disc, double mass, double axial, double transverse) {
    // Springs come last, so that discs' parameters have the same places however springs are described.
    const VectorX values = single_disc_parameters(mechanism, disc, mass, axial, transverse);
    return begin >= end ||
           std::abs(coefficients.segment(begin, end - begin).dot(values.segment(begin, end - begin))) <= 1e-9 * largest;
  };
  for (std::size_t d = 0; d < mechanism.discs.size(); ++d)
    if (!vanishes(d, 1, 0, 0) || !vanishes(d, 0, 1, 0) || !vanishes(d, 0, 0, 1)) return false;
  return true;
}

}  // namespace balance
