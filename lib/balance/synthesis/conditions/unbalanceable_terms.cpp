#include "balance/synthesis/conditions/unbalanceable_terms.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance {

namespace {

constexpr int static_effort_samples = 60;
/// Smallest singular value of what holds the actuators: nearer to singular configurations efforts grow beyond all bounds.
constexpr double min_regularity = 0.05;
/// The same on the way from a pose to the largest effort around it, so that none is followed towards a singular one.
constexpr double min_regularity_path = 0.2;
constexpr int max_coordinate_sweeps = 12;
/// Efforts below this part of the element's own are round-off.
constexpr double static_effort_epsilon = 1e-9;

/// Known terms alone, or one spring alone.
bool is_unbalanceable_row(const Conditions& conditions, int row) {
  int spring = -1;
  bool known = false;
  for (Eigen::Index p = 0; p < conditions.matrix.cols(); ++p) {
    if (conditions.matrix(row, p) == 0) continue;
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(p)];
    known = known || is_known_term(term);
    if (is_known_term(term)) continue;
    if (term.owner_kind != ParameterOwner::spring || (spring >= 0 && spring != term.index)) return false;
    spring = term.index;
  }
  return spring < 0 || !known;
}

std::string element_name(const Mechanism& mechanism, ParameterOwner bearer, int index) {
  const auto i = static_cast<std::size_t>(index);
  if (bearer == ParameterOwner::spring) return mechanism.springs[i].name;
  if (bearer == ParameterOwner::load) return mechanism.loads[i].name;
  return mechanism.coordinates[static_cast<std::size_t>(mechanism.friction[i].coordinate)].name;
}

/// Efforts of the actuators per unit of every term: rows = efforts of one configuration after the other.
struct EffortRows {
  MatrixX constant, changing;
};

/// How much there is of every term.
struct TermAmounts {
  VectorX own;        ///< of the element itself
  VectorX asked;      ///< and of what the masses take for it
  MatrixX histories;  ///< what changes: a column of zeros, then one for every time

  VectorX largest(const EffortRows& rows, const VectorX& constant) const {
    return row_maxima(((rows.changing * histories).colwise() + rows.constant * constant).cwiseAbs()).cwiseMax(0);
  }
};

template <class S>
class StaticEffortSearch {
 public:
  StaticEffortSearch(const Mechanism& mechanism, const Conditions& conditions, const ConditionOptions& options)
      : units_(mechanism, conditions.parameters),
        tree_(compile_tree<S>(mechanism, mechanism.actuators)),
        scale_(column_scale(tree_)),
        histories_(load_histories(mechanism)) {
    ConfigurationSampler<S> sampler(mechanism, tree_, options.seed);
    SampledConfiguration here;
    if (!sampler.next(here)) return;
    freedoms_ = sampler.freedoms();
    rows_.emplace(mechanism, tree_, units_, std::vector<Goal>{{GoalKind::statics}}, options, freedoms_);
    select(mechanism);
    EffortRows there;
    for (int k = 0; k < static_effort_samples; ++k) {
      if (evaluate(here, min_regularity, there)) {
        append(there.constant, all_.constant);
        append(there.changing, all_.changing);
        poses_.push_back(here.y);
      }
      if (!sampler.next(here)) break;
    }
  }

  std::vector<PeakEffort> find_peaks(const Conditions& conditions, const UnbalanceableElement& remainder,
                                     const VectorX& values) {
    const auto n = static_cast<Eigen::Index>(actuators_.size());
    if (n == 0 || poses_.empty()) return {};
    const TermAmounts amounts = amounts_of(conditions, remainder, values);
    const double size = max_abs(amounts.largest(all_, amounts.own));
    const VectorX efforts = amounts.largest(all_, amounts.asked);
    std::vector<PeakEffort> largest;
    if (!std::isfinite(size) || !efforts.allFinite()) {
      for (const int actuator : actuators_) largest.push_back({actuator, INFINITY});
      return largest;
    }
    for (Eigen::Index a = 0; a < n; ++a) {
      Eigen::Index best = a;
      for (Eigen::Index r = a; r < efforts.size(); r += n)
        if (efforts[r] > efforts[best]) best = r;
      if (!(efforts[best] > static_effort_epsilon * size)) continue;
      const double most = maximise(amounts, a, poses_[static_cast<std::size_t>(best / n)], efforts[best]);
      largest.push_back({actuators_[static_cast<std::size_t>(a)],
                         most * units_.acceleration * (lengths_[static_cast<std::size_t>(a)] ? 1 : units_.length)});
    }
    return largest;
  }

 private:
  TermAmounts amounts_of(const Conditions& conditions, const UnbalanceableElement& remainder,
                         const VectorX& values) const {
    const Eigen::Index terms = all_.constant.cols();
    TermAmounts amounts{VectorX::Zero(terms), {}, MatrixX::Zero(terms, 1 + histories_.rows())};
    for (const int t : remainder.terms) {
      const Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
      if (is_load_change(term))
        amounts.histories.row(t).tail(histories_.rows()) =
            histories_.col(load_component(term, S::dimension == 2)).transpose() / units_.parameter[t];
      else
        amounts.own[t] = values[t] / units_.parameter[t];
    }
    // masses take what the conditions ask of them; what these leave open does not reach the actuators
    amounts.asked = amounts.own;
    for (Eigen::Index row = 0; row < conditions.parameter_rows(); ++row) {
      const int pivot = conditions.pivots[static_cast<std::size_t>(row)];
      for (const int t : remainder.terms)
        if (t >= conditions.parameter_columns())
          amounts.asked[pivot] -= conditions.matrix(row, t) * values[t] / units_.parameter[pivot];
    }
    return amounts;
  }

  /// The efforts at one configuration; false if the actuators do not hold it that firmly.
  bool evaluate(const SampledConfiguration& here, double firmness, EffortRows& efforts) {
    MatrixX directions, found;
    if (!holding_directions(here.null_space, firmness, directions) ||
        !rows_->evaluate(here, {directions, VectorX::Zero(tree_.columns)}, found))
      return false;
    // behind what is constant, what changes
    const auto n = static_cast<Eigen::Index>(actuators_.size());
    const auto part = [&](Eigen::Index first) {
      return found.rows() >= first + n ? MatrixX(found.middleRows(first, n)) : MatrixX(MatrixX::Zero(n, found.cols()));
    };
    efforts = {part(0), part(n)};
    return true;
  }

  /// From a pose up to where the effort is largest around it, by parabolas along the freedoms in turn.
  double maximise(const TermAmounts& amounts, Eigen::Index actuator, VectorX y, double most) {
    if (!tree_.spherical_joints.empty()) return most;  // their coordinates may have changed their meaning since
    ConstraintSystem<S> closures(tree_, Drive<S>{});
    SampledConfiguration here;
    EffortRows rows;
    const auto at = [&](const VectorX& pose) {  // below what was found where it cannot be
      if (!project_onto_closures(closures, pose, freedoms_, here) || !evaluate(here, min_regularity_path, rows))
        return -1.0;
      return amounts.largest(rows, amounts.asked)[actuator];
    };
    double reach = 0.2;  // [rad, characteristic lengths]
    for (int sweep = 0; sweep < max_coordinate_sweeps && at(y) >= 0; ++sweep, reach = std::max(0.7 * reach, 0.01)) {
      const MatrixX ways = here.null_space;
      for (Eigen::Index f = 0; f < ways.cols(); ++f) {
        const VectorX way = scale_.cwiseProduct(ways.col(f));
        const double ahead = at(y + reach * way), behind = at(y - reach * way);
        if (ahead < 0 || behind < 0) return most;
        const double bend = ahead + behind - 2 * most;
        const double step = bend < 0 ? std::clamp((behind - ahead) / (2 * bend), -2.0, 2.0) : ahead > behind ? 1 : -1;
        const double reached = at(y + step * reach * way);
        if (reached > most) most = reached, y = here.y;
      }
    }
    return most;
  }

  void select(const Mechanism& mechanism) {
    actuators_ = mechanism.actuators;
    if (actuators_.empty() && tree_.closure_rows == 0)
      for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) actuators_.push_back(static_cast<int>(c));
    selection_ = MatrixX::Zero(static_cast<Eigen::Index>(actuators_.size()), tree_.columns);
    for (std::size_t a = 0; a < actuators_.size(); ++a) {
      const LinearQuantity& source = tree_.coordinate_expressions[static_cast<std::size_t>(actuators_[a])];
      lengths_.push_back(source.is_length);
      for (const auto& [column, ratio] : source.terms)
        selection_(static_cast<Eigen::Index>(a), column) =
            ratio * scale_[column] / (source.is_length ? tree_.characteristic_length : 1);
    }
  }

  /// Velocities by which virtual power gives the actuators' efforts, of least norm where there are more than are needed.
  bool holding_directions(const MatrixX& null_space, double firmness, MatrixX& directions) const {
    const MatrixX held = selection_ * null_space;
    if (held.rows() < held.cols() || held.rows() == 0) return false;
    const SingularValueDecomposition svd(held, Eigen::ComputeThinU | Eigen::ComputeThinV);
    if (held.cols() > 0 && svd.singularValues().tail(1)[0] < firmness) return false;
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
  Tree<S> tree_;
  VectorX scale_;
  MatrixX histories_;  ///< changes of all loads' components at all times
  std::vector<CoordinateId> actuators_;
  std::vector<bool> lengths_;
  MatrixX selection_;
  EffortRows all_;
  std::vector<VectorX> poses_;  ///< that the rows are of
  int freedoms_ = 0;
  std::optional<GoalRows<S>> rows_;
};

template <class S>
std::vector<PeakEffort> find_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                            const UnbalanceableElement& remainder, const ConditionOptions& options) {
  return StaticEffortSearch<S>(mechanism, conditions, options)
      .find_peaks(conditions, remainder, term_values(mechanism, options.loose_springs));
}

std::string unit_text(const Parameter& term, const Mechanism& mechanism) {
  if (term.owner_kind == ParameterOwner::spring) return term.length_power == 2 ? "N m/rad" : "N/m";
  if (term.owner_kind == ParameterOwner::load) return term.kind == ParameterKind::couple ? "N m" : "N";
  const CoordinateId coordinate = mechanism.friction[static_cast<std::size_t>(term.index)].coordinate;
  const bool turns = mechanism.coordinates[static_cast<std::size_t>(coordinate)].kind == CoordinateKind::angle;
  if (term.kind == ParameterKind::viscous) return turns ? "N m s/rad" : "N s/m";
  return turns ? "N m" : "N";
}

}  // namespace

std::vector<UnbalanceableElement> list_unbalanceable_elements(const Conditions& conditions, const VectorX& values,
                                                              const Mechanism& mechanism, double tolerance) {
  std::vector<UnbalanceableElement> all;
  const VectorX residuals = scaled_residuals(conditions, values);
  for (int row = 0; row < static_cast<int>(conditions.matrix.rows()); ++row) {
    if (!(std::abs(residuals[row]) > tolerance) || !is_unbalanceable_row(conditions, row)) continue;
    for (int t = 0; t < static_cast<int>(conditions.parameters.size()); ++t) {
      const Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
      if (conditions.matrix(row, t) == 0 || values[t] == 0) continue;
      auto known = std::find_if(all.begin(), all.end(), [&](const UnbalanceableElement& r) {
        return r.bearer == term.owner_kind && r.index == term.index;
      });
      if (known == all.end())
        known = all.insert(known,
                           {term.owner_kind, term.index, element_name(mechanism, term.owner_kind, term.index), {}, {}});
      if (std::find(known->terms.begin(), known->terms.end(), t) == known->terms.end()) known->terms.push_back(t);
      if (std::find(known->rows.begin(), known->rows.end(), row) == known->rows.end()) known->rows.push_back(row);
    }
  }
  std::sort(all.begin(), all.end(), [](const UnbalanceableElement& a, const UnbalanceableElement& b) {
    return std::pair(a.bearer, a.index) < std::pair(b.bearer, b.index);
  });
  for (UnbalanceableElement& r : all) std::sort(r.terms.begin(), r.terms.end());
  return all;
}

std::string unbalanceable_element_text(const UnbalanceableElement& remainder, const Conditions& conditions,
                                       const VectorX& values, const Mechanism& mechanism) {
  std::string constant, changing;
  for (const int t : remainder.terms) {
    const Parameter& term = conditions.parameters[static_cast<std::size_t>(t)];
    const std::string number = fmt::format("{:.6g} {}", values[t], unit_text(term, mechanism));
    if (is_load_change(term)) {
      changing += (changing.empty() ? "" : ", ") +
                  fmt::format("{} by {}", term.symbol.substr(0, term.symbol.find('(')), number);
      continue;
    }
    constant += constant.empty() ? "" : ", ";
    if (term.owner_kind == ParameterOwner::friction)
      constant += number + (term.kind == ParameterKind::viscous ? " viscous"
                            : term.symbol == coulomb_forward    ? " dry forwards"
                            : term.symbol == coulomb_backward   ? " dry backwards"
                                                                : " dry");
    else
      constant += term.symbol + " = " + number;
  }
  const char* what = remainder.bearer == ParameterOwner::friction ? "friction in "
                     : remainder.bearer == ParameterOwner::spring ? "spring "
                                                                  : "load ";
  std::string text = what + remainder.name;
  if (!changing.empty()) text += ", which changes over time (" + changing + ")";
  if (!constant.empty()) text += (changing.empty() ? " (" : ", and its ") + constant + (changing.empty() ? ")" : "");
  return text;
}

std::vector<PeakEffort> find_peak_static_efforts(const Mechanism& mechanism, const Conditions& conditions,
                                                 const UnbalanceableElement& remainder,
                                                 const ConditionOptions& options) {
  if (remainder.bearer == ParameterOwner::friction) return {};
  return dispatch_space(mechanism.space,
                        [&]<class S>(S) { return find_static_efforts<S>(mechanism, conditions, remainder, options); });
}

}  // namespace balance
