#include "balance/synthesis/design/condition_dependence.hpp"

#include <cmath>

namespace balance::design {

namespace {

/// Relative to the sum of absolute terms; conditions derived anew have a larger round-off.
constexpr double rounding_change_threshold = 1e-12, derivation_change_threshold = 1e-7;

bool has_same_joints(const Mechanism& a, const Mechanism& b) {
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    const Joint &p = a.joints[j], &q = b.joints[j];
    if (p.point_first != q.point_first || p.point_second != q.point_second || p.axis != q.axis || p.axis2 != q.axis2 ||
        p.rotation != q.rotation || p.radius != q.radius)
      return false;
  }
  return true;
}

bool has_same_constraints(const Mechanism& a, const Mechanism& b) {
  for (std::size_t c = 0; c < a.constraints.size(); ++c)
    for (std::size_t t = 0; t < a.constraints[c].terms.size(); ++t) {
      const model::GeneralisedSpeedTerm &p = a.constraints[c].terms[t], &q = b.constraints[c].terms[t];
      if (p.factor != q.factor || p.position != q.position) return false;
    }
  return true;
}

bool is_same_sum(const model::CoordinateCombination& a, const model::CoordinateCombination& b) {
  return std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(),
                    [](const model::CoordinateTerm& p, const model::CoordinateTerm& q) { return p.ratio == q.ratio; });
}

/// Compares everything except masses, centres of mass, inertias, stiffnesses and preloads.
bool has_same_geometry(const Mechanism& a, const Mechanism& b) {
  if (!has_same_joints(a, b) || !has_same_constraints(a, b) || a.gravity != b.gravity) return false;
  for (std::size_t d = 0; d < a.discs.size(); ++d) {
    const Disc &p = a.discs[d], &q = b.discs[d];
    if (p.position != q.position || p.axis != q.axis || p.ratio != q.ratio || !is_same_sum(p.follows, q.follows))
      return false;
  }
  for (std::size_t c = 0; c < a.couplings.size(); ++c)
    if (a.couplings[c].ratio != b.couplings[c].ratio || a.couplings[c].offset != b.couplings[c].offset ||
        !is_same_sum(a.couplings[c].leader, b.couplings[c].leader))
      return false;
  for (std::size_t s = 0; s < a.springs.size(); ++s) {
    const Spring &p = a.springs[s], &q = b.springs[s];
    if (p.is_joint_spring()) continue;
    if (p.point_first != q.point_first || p.point_second != q.point_second || p.free_length != q.free_length)
      return false;
  }
  for (std::size_t e = 0; e < a.force_elements.size(); ++e) {
    const ForceElement &p = a.force_elements[e], &q = b.force_elements[e];
    if (p.point_first != q.point_first || p.point_second != q.point_second ||
        p.table.displacement != q.table.displacement || p.table.force != q.table.force)
      return false;
  }
  for (std::size_t l = 0; l < a.loads.size(); ++l)
    if (a.loads[l].point != b.loads[l].point) return false;
  return !a.tool || a.tool->position == b.tool->position;
}

bool has_same_pivots(const Conditions& a, const Conditions& b) {
  return a.status == ConditionsStatus::done && b.status == ConditionsStatus::done && a.pivots == b.pivots &&
         a.matrix.cols() == b.matrix.cols();
}

/// Well inside the bounds, at a different fraction of the range for each number, to avoid accidental zeros.
VectorX generic_point(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = numbers[static_cast<std::size_t>(i)];
    const double fraction = std::fmod(0.37 + 0.6180339887498949 * static_cast<double>(i), 1.0);
    x[i] = number.lower + (0.2 + 0.6 * fraction) * (number.upper - number.lower);
  }
  return x;
}

class ConditionDependence {
 public:
  ConditionDependence(const DesignSpace& space, const std::function<Conditions(const Mechanism&)>& derive,
                      const dynamics::FreeSprings& loose, const Conditions& at_start)
      : space_(space), derive_(derive), loose_(loose), x_(generic_point(space.start.free_numbers)) {
    base_mechanism_ = space.instantiate(x_).mechanism;
    base_values_ = conditions::term_values(base_mechanism_, loose_);
    base_conditions_ = has_same_geometry(base_mechanism_, space.start.mechanism) ? at_start : derive_(base_mechanism_);
    // If nothing can be derived here, use the conditions at the start.
    if (!has_same_pivots(at_start, base_conditions_)) base_conditions_ = at_start;
  }

  /// For each condition, whether it depends on the number.
  std::vector<bool> find_affected(Eigen::Index number) const {
    VectorX x = x_;
    const FreeNumber& free = space_.start.free_numbers[static_cast<std::size_t>(number)];
    x[number] += 0.1 * (free.upper - free.lower);
    const Mechanism perturbed = space_.instantiate(x).mechanism;
    const VectorX values = conditions::term_values(perturbed, loose_);
    if (has_same_geometry(base_mechanism_, perturbed))
      return find_affected(base_conditions_.matrix * (values - base_values_),
                           base_conditions_.matrix.cwiseAbs() * (values - base_values_).cwiseAbs(),
                           rounding_change_threshold);
    const Conditions perturbed_conditions = derive_(perturbed);
    if (!has_same_pivots(base_conditions_, perturbed_conditions))
      return std::vector<bool>(static_cast<std::size_t>(base_conditions_.matrix.rows()), true);
    return find_affected(perturbed_conditions.matrix * values - base_conditions_.matrix * base_values_,
                         perturbed_conditions.matrix.cwiseAbs() * values.cwiseAbs() +
                             base_conditions_.matrix.cwiseAbs() * base_values_.cwiseAbs(),
                         derivation_change_threshold);
  }

 private:
  static std::vector<bool> find_affected(const VectorX& change, const VectorX& scale, double tolerance) {
    std::vector<bool> result;
    for (Eigen::Index row = 0; row < change.size(); ++row)
      result.push_back(std::abs(change[row]) > tolerance * scale[row]);
    return result;
  }

  const DesignSpace& space_;
  const std::function<Conditions(const Mechanism&)>& derive_;
  const dynamics::FreeSprings& loose_;
  VectorX x_, base_values_;
  Mechanism base_mechanism_;
  Conditions base_conditions_;
};

}  // namespace

std::vector<std::vector<int>> probe_condition_variables(const DesignSpace& space, const Conditions& conditions,
                                                        const std::function<Conditions(const Mechanism&)>& derive,
                                                        const dynamics::FreeSprings& loose) {
  std::vector<std::vector<int>> result(static_cast<std::size_t>(conditions.matrix.rows()));
  if (space.start.free_numbers.empty()) return result;
  const ConditionDependence probe(space, derive, loose, conditions);
  for (std::size_t i = 0; i < space.start.free_numbers.size(); ++i) {
    const std::vector<bool> affected = probe.find_affected(static_cast<Eigen::Index>(i));
    for (std::size_t row = 0; row < result.size(); ++row)
      if (affected[row]) result[row].push_back(static_cast<int>(i));
  }
  return result;
}

}  // namespace balance::design
