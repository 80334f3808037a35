#include "balance/design/branching.hpp"

#include <algorithm>
#include <cmath>

namespace balance::design {

namespace {

/// Next to one of the sizes, in parts of the range.
constexpr double discrete_value_tolerance = 1e-9;

const DesignVariable& variable(const DesignProblem& problem, int i) {
  return problem.variables[static_cast<std::size_t>(i)];
}

}  // namespace

BranchingRule::BranchingRule(const DesignProblem& problem, int least) : problem_(problem) {
  std::optional<std::size_t> shared;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints) {
    std::size_t group = groups_.size();
    if (choice.max_count < 0 && shared)
      group = *shared;
    else
      groups_.push_back(choice.max_count < 0 ? least : choice.max_count);
    if (choice.max_count < 0) shared = group;
    for (const OptionalElement& element : choice.elements) elements_.push_back({element.variables, group});
  }
}

int BranchingRule::count_unrestricted_elements(const DesignProblem& problem) {
  std::size_t count = 0;
  for (const CardinalityConstraint& choice : problem.cardinality_constraints)
    count += choice.max_count < 0 ? choice.elements.size() : 0;
  return static_cast<int>(count);
}

BranchNode BranchingRule::root() const {
  BranchNode branch;
  const auto n = static_cast<Eigen::Index>(problem_.variables.size());
  branch.lower.resize(n);
  branch.upper.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    branch.lower[i] = variable(problem_, static_cast<int>(i)).lower;
    branch.upper[i] = variable(problem_, static_cast<int>(i)).upper;
  }
  branch.element_states.assign(elements_.size(), BranchNode::ElementState::undecided);
  return branch;
}

bool BranchingRule::propagate_values(BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    double &lower = branch.lower[static_cast<Eigen::Index>(i)], &upper = branch.upper[static_cast<Eigen::Index>(i)];
    const std::vector<double>& sizes = problem_.variables[i].discrete_values;
    if (!sizes.empty()) {
      const auto first = std::lower_bound(sizes.begin(), sizes.end(), lower);
      const auto last = std::upper_bound(sizes.begin(), sizes.end(), upper);
      if (first >= last) return false;
      lower = *first;
      upper = *std::prev(last);
    }
    if (!(lower <= upper)) return false;
  }
  return true;
}

/// An element is left out exactly if its numbers are zero.
bool BranchingRule::propagate_element(BranchNode& branch, std::size_t k) const {
  BranchNode::ElementState& fate = branch.element_states[k];
  bool zero = true, never = false;
  for (const int i : elements_[k].numbers) {
    zero = zero && branch.lower[i] == 0 && branch.upper[i] == 0;
    never = never || branch.lower[i] > 0 || branch.upper[i] < 0;
  }
  if (zero && fate != BranchNode::ElementState::excluded) {
    if (fate == BranchNode::ElementState::kept) return false;  // the same as one that is left out
    fate = BranchNode::ElementState::excluded;
  }
  if (never && fate == BranchNode::ElementState::excluded) return false;
  if (never) fate = BranchNode::ElementState::kept;
  if (fate == BranchNode::ElementState::excluded)
    for (const int i : elements_[k].numbers) branch.lower[i] = branch.upper[i] = 0;
  return true;
}

int BranchingRule::count(const BranchNode& branch, std::size_t group, BranchNode::ElementState fate) const {
  int found = 0;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    found += elements_[k].group == group && branch.element_states[k] == fate ? 1 : 0;
  return found;
}

bool BranchingRule::propagate_counts(BranchNode& branch) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const int kept = count(branch, g, BranchNode::ElementState::kept);
    if (kept > groups_[g]) return false;
    if (kept < groups_[g]) continue;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (elements_[k].group == g && branch.element_states[k] == BranchNode::ElementState::undecided)
        branch.element_states[k] = BranchNode::ElementState::excluded;
  }
  return true;
}

bool BranchingRule::propagate(BranchNode& branch) const {
  for (;;) {
    const std::vector<BranchNode::ElementState> fates = branch.element_states;
    const VectorX lower = branch.lower, upper = branch.upper;
    if (!propagate_counts(branch) || !propagate_values(branch)) return false;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (!propagate_element(branch, k)) return false;
    if (fates == branch.element_states && lower == branch.lower && upper == branch.upper) return true;
  }
}

bool BranchingRule::is_leaf(const BranchNode& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!problem_.variables[i].discrete_values.empty() && branch.lower[k] != branch.upper[k]) return false;
  }
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (count(branch, g, BranchNode::ElementState::kept) + count(branch, g, BranchNode::ElementState::undecided) >
        groups_[g])
      return false;
  return true;
}

double BranchingRule::range_fraction(const Element& element, const VectorX& x) const {
  double most = 0;
  for (const int i : element.numbers) {
    const double reach = std::max(std::abs(variable(problem_, i).lower), std::abs(variable(problem_, i).upper));
    if (reach > 0) most = std::max(most, std::abs(x[i]) / reach);
  }
  return most;
}

std::vector<BranchNode> BranchingRule::branch(const BranchNode& branch, const VectorX& x) const {
  std::size_t chosen = elements_.size();
  double largest = -1;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::size_t g = elements_[k].group;
    const bool matters =
        branch.element_states[k] == BranchNode::ElementState::undecided &&
        count(branch, g, BranchNode::ElementState::kept) + count(branch, g, BranchNode::ElementState::undecided) >
            groups_[g];
    if (!matters || !(range_fraction(elements_[k], x) > largest)) continue;
    largest = range_fraction(elements_[k], x);
    chosen = k;
  }
  if (chosen < elements_.size()) return branch_on_element(branch, chosen);
  int number = -1;
  double farthest = -1;
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const std::vector<double>& sizes = problem_.variables[i].discrete_values;
    const auto k = static_cast<Eigen::Index>(i);
    if (sizes.empty() || branch.lower[k] == branch.upper[k]) continue;
    const auto above = std::lower_bound(sizes.begin(), sizes.end(), x[k]);
    double off = above != sizes.end() ? *above - x[k] : std::numeric_limits<double>::infinity();
    if (above != sizes.begin()) off = std::min(off, x[k] - *std::prev(above));
    off /= sizes.back() - sizes.front();
    if (!(off > farthest)) continue;
    farthest = off;
    number = static_cast<int>(i);
  }
  return branch_on_value(branch, number, x[number]);
}

std::vector<BranchNode> BranchingRule::branch_on_element(const BranchNode& branch, std::size_t k) const {
  std::vector<BranchNode> parts(2, branch);
  parts[0].element_states[k] = BranchNode::ElementState::excluded;
  parts[1].element_states[k] = BranchNode::ElementState::kept;
  return parts;
}

std::vector<BranchNode> BranchingRule::branch_on_value(const BranchNode& branch, int number, double at) const {
  const std::vector<double>& sizes = variable(problem_, number).discrete_values;
  const double range = sizes.back() - sizes.front(), value = std::clamp(at, branch.lower[number], branch.upper[number]);
  const auto above = std::lower_bound(sizes.begin(), sizes.end(), value - discrete_value_tolerance * range);
  std::vector<BranchNode> parts;
  const auto add = [&](double lower, double upper) {
    if (lower > upper || lower > branch.upper[number] || upper < branch.lower[number]) return;
    parts.push_back(branch);
    parts.back().lower[number] = std::max(lower, branch.lower[number]);
    parts.back().upper[number] = std::min(upper, branch.upper[number]);
  };
  const double infinite = std::numeric_limits<double>::infinity();
  if (above != sizes.end() && *above <= value + discrete_value_tolerance * range) {
    if (above != sizes.begin()) add(-infinite, *std::prev(above));
    if (std::next(above) != sizes.end()) add(*std::next(above), infinite);
    add(*above, *above);
    return parts;
  }
  const bool up = *above - value < value - *std::prev(above);
  if (up) add(-infinite, *std::prev(above));
  add(*above, infinite);
  if (!up) add(-infinite, *std::prev(above));
  return parts;
}

VariableDomain BranchingRule::node_domain(const BranchNode& branch) const {
  VariableDomain part{branch.lower, branch.upper, {}};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (count(branch, g, BranchNode::ElementState::undecided) == 0) continue;
    VectorX coefficients = VectorX::Zero(branch.lower.size());
    bool positive = true;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      if (elements_[k].group != g || branch.element_states[k] != BranchNode::ElementState::undecided) continue;
      const int i = elements_[k].numbers.front();  // its share of the range is at most one
      positive = positive && branch.lower[i] >= 0 && coefficients[i] == 0;
      coefficients[i] = 1 / variable(problem_, i).upper;
    }
    const int left = groups_[g] - count(branch, g, BranchNode::ElementState::kept);
    if (positive && coefficients.allFinite()) part.linear_limits.emplace_back(coefficients, left);
  }
  return part;
}

std::vector<std::vector<bool>> BranchingRule::kept_elements(const VectorX& x) const {
  std::vector<std::vector<bool>> all;
  for (const CardinalityConstraint& choice : problem_.cardinality_constraints) {
    all.emplace_back();
    for (const OptionalElement& element : choice.elements)
      all.back().push_back(
          std::any_of(element.variables.begin(), element.variables.end(), [&](int i) { return x[i] != 0; }));
  }
  return all;
}

}  // namespace balance::design
