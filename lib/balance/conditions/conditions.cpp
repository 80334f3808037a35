#include "balance/conditions/conditions.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/reduce.hpp"
#include "balance/conditions/rows.hpp"
#include "balance/model/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

constexpr int fewest_samples = 12, most_samples = 2000;
constexpr int repetitions = 2;  ///< with more samples each, before the rank is called unclear

/// Entries are of the order one in natural units; squares of such numbers have no value any more. False for NaN, too.
bool within_reach(const MatrixX& rows) { return (rows.array().abs() < 1e100).all(); }

template <class S>
class Derivation {
 public:
  Derivation(const Mechanism& mechanism, const std::vector<Goal>& goals, const ConditionOptions& options)
      : mechanism_(mechanism),
        options_(options),
        tree_(compile<S>(mechanism, mechanism.actuators)),
        sampler_(mechanism, tree_, options.seed),
        random_(options.seed + 1) {
    out_.goals = goals;
    out_.parameters = list_terms(mechanism, options.loose_springs);
    out_.known = known_values(mechanism);
    out_.open_terms = options.open_terms;
  }

  Conditions run() {
    Configuration configuration;
    if (!sampler_.next(configuration)) return refuse(ConditionsStatus::not_assembled, sampler_.obstacle());
    const NaturalUnits units(mechanism_, out_.parameters);
    GoalRows<S> rows(mechanism_, tree_, units, out_.goals, options_, sampler_.freedoms());
    if (!rows.mismatch().empty()) return refuse(ConditionsStatus::mismatch, rows.mismatch());
    const std::vector<int> order = pivot_order(mechanism_, out_.parameters);
    MatrixX all(0, rows.parameters() + rows.extra());
    for (int k = 0, wanted = 2 * static_cast<int>(all.cols()) + 20; k <= repetitions; ++k, wanted *= 2) {
      if (!collect(rows, configuration, wanted, all))
        return refuse(ConditionsStatus::not_assembled,
                      "too few configurations were found in which the actuators hold the mechanism");
      if (!within_reach(all) || !units.parameter.allFinite())
        return refuse(ConditionsStatus::rank_unclear,
                      has_mass(mechanism_)
                          ? "numbers overflow: terms of the conditions are larger than can be computed with"
                          : no_mass);
      if (!reduce(without_extra(all, rows.parameters()), units.parameter, units.mass, order, out_)) continue;
      out_.status = ConditionsStatus::done;
      add_notes();
      return std::move(out_);
    }
    return refuse(
        ConditionsStatus::rank_unclear,
        fmt::format("the number of conditions is not clear: the widest gap between singular values is {:.1e}, from "
                    "{:.1e} to {:.1e}",
                    out_.gap, out_.smallest_kept, out_.largest_dropped));
  }

 private:
  /// More rows, until there are `wanted`, starting with a configuration at hand.
  bool collect(GoalRows<S>& rows, Configuration& configuration, int wanted, MatrixX& all) {
    std::vector<MatrixX> blocks{all};
    Eigen::Index count = all.rows();
    for (int tried = 0; count < wanted || out_.samples < fewest_samples; ++tried) {
      if (tried == most_samples) return false;
      const VectorX velocity = configuration.null_space * random_.normal(configuration.null_space.cols());
      const Probe probe{some_of(configuration.null_space, wanted / fewest_samples + 1), velocity};
      MatrixX block;
      if (rows.at(configuration, probe, block)) {
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
  MatrixX some_of(const MatrixX& directions, Eigen::Index count) {
    constexpr Eigen::Index many = 48;
    const Eigen::Index all = directions.cols();
    if (all <= std::max(many, count)) return directions;
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
    if (!options_.without.empty()) {
      std::string names;
      for (const std::string& name : options_.without) names += (names.empty() ? "" : ", ") + name;
      out_.notes.push_back("left out: " + names);
    }
    if (efforts && mechanism_.gravity.norm() == 0)
      out_.notes.push_back("there is no gravity in this spec: weight asks for nothing");
    for (const Parameter& p : out_.parameters)
      if (efforts && p.kind == ParameterKind::stiffness_moment &&
          !mechanism_.springs[static_cast<std::size_t>(p.index)].in_joint()) {
        out_.notes.push_back(p.owner +
                             ".kaxby stands for the stiffness times x of the spring's first end times y of its second");
        break;
      }
    if (tree_.closure_rows == 0 || (!wants(GoalKind::gyroscopic) && !wants(GoalKind::decoupled))) return;
    std::string joints;
    for (std::size_t j = 0; j < mechanism_.joints.size(); ++j)
      if (tree_.joint_nodes[j] >= 0 && freedom(mechanism_.joints[j].type) > 0)
        joints += (joints.empty() ? "" : ", ") + mechanism_.joints[j].name;
    out_.notes.push_back("no velocity terms: when the efforts are written in the accelerations of " + joints);
  }

  const Mechanism& mechanism_;
  const ConditionOptions& options_;
  Tree<S> tree_;
  Sampler<S> sampler_;
  Random random_;
  Conditions out_;
};

}  // namespace

Conditions derive_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const ConditionOptions& options) {
  if (goals.empty()) throw std::invalid_argument("conditions need a goal");
  return in_space(mechanism.space, [&]<class S>(S) { return Derivation<S>(mechanism, goals, options).run(); });
}

Eigen::Index Conditions::own_rows() const {
  Eigen::Index rows = matrix.rows();
  while (known.size() > 0 && rows > 0 && matrix.row(rows - 1).head(own_columns()).isZero(0)) --rows;
  return rows;
}

VectorX scaled_residuals(const Conditions& conditions, const VectorX& values) {
  VectorX all = values;
  if (values.size() == conditions.own_columns()) {
    all.resize(values.size() + conditions.known.size());
    all << values, conditions.known;
  }
  return (conditions.matrix * all).cwiseQuotient(conditions.scale);
}

}  // namespace balance
