#include "balance/synthesis/conditions/unbalanceable_terms.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance::conditions {

using dynamics::ParameterOwner;

namespace {

constexpr int static_effort_samples = 60;
/// Minimum singular value of the actuators' rows: nearer to singular configurations, efforts grow without bound.
constexpr double min_regularity = 0.05;
/// The same on the way from a pose to the maximum effort around it, to stay away from singular configurations.
constexpr double min_regularity_path = 0.2;
constexpr int max_coordinate_sweeps = 12;
/// Efforts below this fraction of the element's own are round-off.
constexpr double static_effort_epsilon = 1e-9;

/// Whether a row contains known terms alone, or one spring alone.
bool is_unbalanceable_row(const Conditions& conditions, int row) {
  int spring = -1;
  bool known = false;
  for (Eigen::Index p = 0; p < conditions.matrix.cols(); ++p) {
    if (conditions.matrix(row, p) == 0) continue;
    const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(p)];
    known = known || is_known_term(term);
    if (is_known_term(term)) continue;
    if (term.owner_kind != ParameterOwner::spring || (spring >= 0 && spring != term.index)) return false;
    spring = term.index;
  }
  return spring < 0 || !known;
}

std::string element_name(const Mechanism& mechanism, ParameterOwner owner_kind, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (owner_kind == ParameterOwner::spring) return mechanism.springs[i].name;
  if (owner_kind == ParameterOwner::load) return mechanism.loads[i].name;
  if (owner_kind == ParameterOwner::force_element) return mechanism.force_elements[i].name;
  return mechanism.coordinates[static_cast<std::size_t>(mechanism.friction[i].coordinate)].name;
}

/// Efforts of the actuators per unit of every term; the rows contain the efforts of one configuration after the other.
struct EffortRows {
  MatrixX constant, changing;
};

/// Amount of every term.
struct TermAmounts {
  VectorX element_only;           ///< of the element itself
  VectorX with_balancing_masses;  ///< of the element and of the masses that balance it
  MatrixX histories;              ///< changes: a column of zeros, then one for every time

  VectorX peak_efforts(const EffortRows& rows, const VectorX& constant) const {
    return numerics::row_maxima(((rows.changing * histories).colwise() + rows.constant * constant).cwiseAbs())
        .cwiseMax(0);
  }
};

template <class S>
class StaticEffortSearch {
 public:
  StaticEffortSearch(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : units_(mechanism, conditions.parameters),
        tree_(kinematics::compile_tree<S>(mechanism, mechanism.actuators)),
        scale_(column_scale(tree_)),
        histories_(load_histories(mechanism)) {
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    SampledConfiguration configuration;
    if (!sampler.next(configuration)) return;
    freedoms_ = sampler.freedoms();
    rows_.emplace(mechanism, tree_, units_, std::vector<Goal>{{GoalKind::statics}}, options, freedoms_);
    select_actuators(mechanism);
    EffortRows effort_rows;
    for (int k = 0; k < static_effort_samples; ++k) {
      if (evaluate(configuration, min_regularity, effort_rows)) {
        append(effort_rows.constant, efforts_.constant);
        append(effort_rows.changing, efforts_.changing);
        poses_.push_back(configuration.y);
      }
      if (!sampler.next(configuration)) break;
    }
  }

  std::vector<PeakEffort> find_peaks(const Conditions& conditions, const UnbalanceableElement& remainder,
                                     const VectorX& values) {
    const auto n = static_cast<Eigen::Index>(actuators_.size());
    if (n == 0 || poses_.empty()) return {};
    const TermAmounts amounts = compute_amounts(conditions, remainder, values);
    const double effort_scale = numerics::max_abs(amounts.peak_efforts(efforts_, amounts.element_only));
    const VectorX efforts = amounts.peak_efforts(efforts_, amounts.with_balancing_masses);
    std::vector<PeakEffort> peaks;
    if (!std::isfinite(effort_scale) || !efforts.allFinite()) {
      for (const int actuator : actuators_) peaks.push_back({actuator, INFINITY});
      return peaks;
    }
    for (Eigen::Index a = 0; a < n; ++a) {
      Eigen::Index best = a;
      for (Eigen::Index r = a; r < efforts.size(); r += n)
        if (efforts[r] > efforts[best]) best = r;
      if (!(efforts[best] > static_effort_epsilon * effort_scale)) continue;
      const double max_effort = maximise(amounts, a, poses_[static_cast<std::size_t>(best / n)], efforts[best]);
      peaks.push_back(
          {actuators_[static_cast<std::size_t>(a)],
           max_effort * units_.acceleration * (is_length_[static_cast<std::size_t>(a)] ? 1 : units_.length)});
    }
    return peaks;
  }

 private:
  TermAmounts compute_amounts(const Conditions& conditions, const UnbalanceableElement& remainder,
                              const VectorX& values) const {
    const Eigen::Index terms = efforts_.constant.cols();
    TermAmounts amounts{VectorX::Zero(terms), {}, MatrixX::Zero(terms, 1 + histories_.rows())};
    for (const int t : remainder.terms) {
      const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
      if (is_load_change(term))
        amounts.histories.row(t).tail(histories_.rows()) =
            histories_.col(load_component(term, S::dimension == 2)).transpose() / units_.parameter[t];
      else
        amounts.element_only[t] = values[t] / units_.parameter[t];
    }
    // the masses take what the conditions require of them; what these leave free does not affect the actuators
    amounts.with_balancing_masses = amounts.element_only;
    for (Eigen::Index row = 0; row < conditions.parameter_rows(); ++row) {
      const int pivot = conditions.pivots[static_cast<std::size_t>(row)];
      for (const int t : remainder.terms)
        if (t >= conditions.parameter_columns())
          amounts.with_balancing_masses[pivot] -= conditions.matrix(row, t) * values[t] / units_.parameter[pivot];
    }
    return amounts;
  }

  /// Evaluates the efforts at one configuration. Returns false if the actuators do not hold it firmly enough.
  bool evaluate(const SampledConfiguration& configuration, double min_singular_value, EffortRows& efforts) {
    MatrixX directions, goal_rows;
    if (!actuated_basis(configuration.null_space, min_singular_value, directions) ||
        !rows_->evaluate(configuration, {directions, VectorX::Zero(tree_.columns)}, goal_rows))
      return false;
    // the constant efforts come first, then the changing ones
    const auto n = static_cast<Eigen::Index>(actuators_.size());
    const auto effort_block = [&](Eigen::Index first) {
      return goal_rows.rows() >= first + n ? MatrixX(goal_rows.middleRows(first, n))
                                           : MatrixX(MatrixX::Zero(n, goal_rows.cols()));
    };
    efforts = {effort_block(0), effort_block(n)};
    return true;
  }

  /// Climbs from a pose to the maximum effort around it, by parabolas along one freedom after the other.
  double maximise(const TermAmounts& amounts, Eigen::Index actuator, VectorX y, double max_effort) {
    if (!tree_.spherical_joints.empty()) return max_effort;  // reference orientations may have changed since
    kinematics::ConstraintSystem<S> closures(tree_, kinematics::Drive<S>{});
    SampledConfiguration configuration;
    EffortRows rows;
    const auto effort_at = [&](const VectorX& pose) {  // negative if the pose is impossible
      if (!project_onto_closures(closures, pose, freedoms_, configuration) ||
          !evaluate(configuration, min_regularity_path, rows))
        return -1.0;
      return amounts.peak_efforts(rows, amounts.with_balancing_masses)[actuator];
    };
    double trial_step = 0.2;  // [rad, characteristic lengths]
    for (int sweep = 0; sweep < max_coordinate_sweeps && effort_at(y) >= 0;
         ++sweep, trial_step = std::max(0.7 * trial_step, 0.01)) {
      const MatrixX directions = configuration.null_space;
      for (Eigen::Index f = 0; f < directions.cols(); ++f) {
        const VectorX direction = scale_.cwiseProduct(directions.col(f));
        const double forward = effort_at(y + trial_step * direction), backward = effort_at(y - trial_step * direction);
        if (forward < 0 || backward < 0) return max_effort;
        const double curvature = forward + backward - 2 * max_effort;
        const double step = curvature < 0        ? std::clamp((backward - forward) / (2 * curvature), -2.0, 2.0)
                            : forward > backward ? 1
                                                 : -1;
        const double new_effort = effort_at(y + step * trial_step * direction);
        if (new_effort > max_effort) max_effort = new_effort, y = configuration.y;
      }
    }
    return max_effort;
  }

  void select_actuators(const Mechanism& mechanism) {
    actuators_ = mechanism.actuators;
    if (actuators_.empty() && tree_.closure_rows == 0)
      for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) actuators_.push_back(static_cast<int>(c));
    selection_ = MatrixX::Zero(static_cast<Eigen::Index>(actuators_.size()), tree_.columns);
    for (std::size_t a = 0; a < actuators_.size(); ++a) {
      const kinematics::LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(actuators_[a])];
      is_length_.push_back(source.is_length);
      for (const auto& [column, ratio] : source.terms)
        selection_(static_cast<Eigen::Index>(a), column) =
            ratio * scale_[column] / (source.is_length ? tree_.characteristic_length : 1);
    }
  }

  /// Velocities for which virtual power gives the actuators' efforts, of minimum norm if there are redundant actuators.
  bool actuated_basis(const MatrixX& null_space, double min_singular_value, MatrixX& directions) const {
    const MatrixX actuator_jacobian = selection_ * null_space;
    if (actuator_jacobian.rows() < actuator_jacobian.cols() || actuator_jacobian.rows() == 0) return false;
    const numerics::SingularValueDecomposition svd(actuator_jacobian, Eigen::ComputeThinU | Eigen::ComputeThinV);
    if (actuator_jacobian.cols() > 0 && svd.singularValues().tail(1)[0] < min_singular_value) return false;
    directions =
        null_space * svd.matrixV() * svd.singularValues().cwiseInverse().asDiagonal() * svd.matrixU().transpose();
    return true;
  }

  static void append(const MatrixX& rows, MatrixX& all) {
    const Eigen::Index before = all.rows();
    all.conservativeResize(before + rows.rows(), rows.cols());
    all.bottomRows(rows.rows()) = rows;
  }

  NaturalUnits units_;
  kinematics::Tree<S> tree_;
  VectorX scale_;
  MatrixX histories_;  ///< changes of all loads' components at all times
  std::vector<CoordinateId> actuators_;
  std::vector<bool> is_length_;
  MatrixX selection_;
  EffortRows efforts_;
  std::vector<VectorX> poses_;  ///< of the rows in efforts_
  int freedoms_ = 0;
  std::optional<GoalRows<S>> rows_;
};

template <class S>
std::vector<PeakEffort> find_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                            const UnbalanceableElement& remainder, const ConditionOptions& options) {
  return StaticEffortSearch<S>(mechanism, conditions, options)
      .find_peaks(conditions, remainder, term_values(mechanism, options.loose_springs));
}

}  // namespace

std::vector<UnbalanceableElement> list_unbalanceable_elements(const Conditions& conditions, const VectorX& values,
                                                              const Mechanism& mechanism, double tolerance) {
  std::vector<UnbalanceableElement> elements;
  const VectorX residuals = scaled_residuals(conditions, values);
  for (int row = 0; row < static_cast<int>(conditions.matrix.rows()); ++row) {
    if (!(std::abs(residuals[row]) > tolerance) || !is_unbalanceable_row(conditions, row)) continue;
    for (int t = 0; t < static_cast<int>(conditions.parameters.size()); ++t) {
      const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
      if (conditions.matrix(row, t) == 0 || values[t] == 0) continue;
      auto element = std::find_if(elements.begin(), elements.end(), [&](const UnbalanceableElement& r) {
        return r.bearer == term.owner_kind && r.index == term.index;
      });
      if (element == elements.end())
        element = elements.insert(
            element, {term.owner_kind, term.index, element_name(mechanism, term.owner_kind, term.index), {}, {}});
      if (std::find(element->terms.begin(), element->terms.end(), t) == element->terms.end())
        element->terms.push_back(t);
      if (std::find(element->rows.begin(), element->rows.end(), row) == element->rows.end())
        element->rows.push_back(row);
    }
  }
  std::sort(elements.begin(), elements.end(), [](const UnbalanceableElement& a, const UnbalanceableElement& b) {
    return std::pair(a.bearer, a.index) < std::pair(b.bearer, b.index);
  });
  for (UnbalanceableElement& r : elements) std::sort(r.terms.begin(), r.terms.end());
  return elements;
}

bool is_damper(const UnbalanceableElement& element, const std::vector<dynamics::Parameter>& terms) {
  return element.bearer == ParameterOwner::force_element && !element.terms.empty() &&
         terms[static_cast<std::size_t>(element.terms.front())].kind == dynamics::ParameterKind::viscous;
}

std::string unbalanceable_element_text(const UnbalanceableElement& remainder, const Conditions& conditions,
                                       const VectorX& values) {
  std::string constant, changing;
  for (const int t : remainder.terms) {
    const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
    const std::string number = fmt::format("{:.6g} {}", values[t], unit_of(term));
    if (is_load_change(term)) {
      changing += (changing.empty() ? "" : ", ") +
                  fmt::format("{} by {}", term.symbol.substr(0, term.symbol.find('(')), number);
      continue;
    }
    constant += constant.empty() ? "" : ", ";
    if (term.owner_kind == ParameterOwner::friction)
      constant += number + (term.kind == dynamics::ParameterKind::viscous ? " viscous"
                            : term.symbol == coulomb_forward              ? " dry forwards"
                            : term.symbol == coulomb_backward             ? " dry backwards"
                                                                          : " dry");
    else if (term.kind == dynamics::ParameterKind::tabulated)
      constant += "a table up to " + number;
    else
      constant += term.symbol + (term.symbol.ends_with(')') ? " up to " : " = ") + number;
  }
  const char* kind = remainder.bearer == ParameterOwner::friction  ? "friction in "
                     : remainder.bearer == ParameterOwner::load    ? "load "
                     : is_damper(remainder, conditions.parameters) ? "damper "
                                                                   : "spring ";
  std::string text = kind + remainder.name;
  if (!changing.empty()) text += ", which changes over time (" + changing + ")";
  if (!constant.empty()) text += (changing.empty() ? " (" : ", and its ") + constant + (changing.empty() ? ")" : "");
  return text;
}

std::vector<PeakEffort> find_peak_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                                 const UnbalanceableElement& remainder,
                                                 const ConditionOptions& options) {
  if (remainder.bearer == ParameterOwner::friction || is_damper(remainder, conditions.parameters)) return {};
  return kinematics::dispatch_space(
      mechanism.space, [&]<class S>(S) { return find_static_efforts<S>(mechanism, conditions, remainder, options); });
}

}  // namespace balance::conditions
