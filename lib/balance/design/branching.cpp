#include "balance/design/branching.hpp"

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

/// Next to one of the sizes, in parts of the range.
constexpr double at_size = 1e-9;

const Variable& variable(const DesignProblem& problem, int i) { return problem.variables[static_cast<std::size_t>(i)]; }

}  // namespace

Branching::Branching(const DesignProblem& problem, int least) : problem_(problem) {
  std::optional<std::size_t> shared;
  for (const Choice& choice : problem.choices) {
    std::size_t group = groups_.size();
    if (choice.most < 0 && shared)
      group = *shared;
    else
      groups_.push_back(choice.most < 0 ? least : choice.most);
    if (choice.most < 0) shared = group;
    for (const OptionalElement& element : choice.elements) elements_.push_back({element.numbers, group});
  }
}

int Branching::count_least(const DesignProblem& problem) {
  std::size_t count = 0;
  for (const Choice& choice : problem.choices) count += choice.most < 0 ? choice.elements.size() : 0;
  return static_cast<int>(count);
}

Branch Branching::root() const {
  Branch branch;
  const auto n = static_cast<Eigen::Index>(problem_.variables.size());
  branch.lower.resize(n);
  branch.upper.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    branch.lower[i] = variable(problem_, static_cast<int>(i)).lower;
    branch.upper[i] = variable(problem_, static_cast<int>(i)).upper;
  }
  branch.fates.assign(elements_.size(), Branch::Fate::open);
  return branch;
}

bool Branching::settle_sizes(Branch& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    double &lower = branch.lower[static_cast<Eigen::Index>(i)], &upper = branch.upper[static_cast<Eigen::Index>(i)];
    const std::vector<double>& sizes = problem_.variables[i].sizes;
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
bool Branching::settle_element(Branch& branch, std::size_t k) const {
  Branch::Fate& fate = branch.fates[k];
  bool zero = true, never = false;
  for (const int i : elements_[k].numbers) {
    zero = zero && branch.lower[i] == 0 && branch.upper[i] == 0;
    never = never || branch.lower[i] > 0 || branch.upper[i] < 0;
  }
  if (zero && fate != Branch::Fate::left_out) {
    if (fate == Branch::Fate::kept) return false;  // the same as one that is left out
    fate = Branch::Fate::left_out;
  }
  if (never && fate == Branch::Fate::left_out) return false;
  if (never) fate = Branch::Fate::kept;
  if (fate == Branch::Fate::left_out)
    for (const int i : elements_[k].numbers) branch.lower[i] = branch.upper[i] = 0;
  return true;
}

int Branching::count(const Branch& branch, std::size_t group, Branch::Fate fate) const {
  int found = 0;
  for (std::size_t k = 0; k < elements_.size(); ++k)
    found += elements_[k].group == group && branch.fates[k] == fate ? 1 : 0;
  return found;
}

bool Branching::settle_counts(Branch& branch) const {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const int kept = count(branch, g, Branch::Fate::kept);
    if (kept > groups_[g]) return false;
    if (kept < groups_[g]) continue;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (elements_[k].group == g && branch.fates[k] == Branch::Fate::open) branch.fates[k] = Branch::Fate::left_out;
  }
  return true;
}

bool Branching::settle(Branch& branch) const {
  for (;;) {
    const std::vector<Branch::Fate> fates = branch.fates;
    const VectorX lower = branch.lower, upper = branch.upper;
    if (!settle_counts(branch) || !settle_sizes(branch)) return false;
    for (std::size_t k = 0; k < elements_.size(); ++k)
      if (!settle_element(branch, k)) return false;
    if (fates == branch.fates && lower == branch.lower && upper == branch.upper) return true;
  }
}

bool Branching::decided(const Branch& branch) const {
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!problem_.variables[i].sizes.empty() && branch.lower[k] != branch.upper[k]) return false;
  }
  for (std::size_t g = 0; g < groups_.size(); ++g)
    if (count(branch, g, Branch::Fate::kept) + count(branch, g, Branch::Fate::open) > groups_[g]) return false;
  return true;
}

double Branching::share(const Element& element, const VectorX& x) const {
  double most = 0;
  for (const int i : element.numbers) {
    const double reach = std::max(std::abs(variable(problem_, i).lower), std::abs(variable(problem_, i).upper));
    if (reach > 0) most = std::max(most, std::abs(x[i]) / reach);
  }
  return most;
}

std::vector<Branch> Branching::split(const Branch& branch, const VectorX& x) const {
  std::size_t chosen = elements_.size();
  double largest = -1;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::size_t g = elements_[k].group;
    const bool matters = branch.fates[k] == Branch::Fate::open &&
                         count(branch, g, Branch::Fate::kept) + count(branch, g, Branch::Fate::open) > groups_[g];
    if (!matters || !(share(elements_[k], x) > largest)) continue;
    largest = share(elements_[k], x);
    chosen = k;
  }
  if (chosen < elements_.size()) return split_element(branch, chosen);
  int number = -1;
  double farthest = -1;
  for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
    const std::vector<double>& sizes = problem_.variables[i].sizes;
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
  return split_number(branch, number, x[number]);
}

std::vector<Branch> Branching::split_element(const Branch& branch, std::size_t k) const {
  std::vector<Branch> parts(2, branch);
  parts[0].fates[k] = Branch::Fate::left_out;
  parts[1].fates[k] = Branch::Fate::kept;
  return parts;
}

std::vector<Branch> Branching::split_number(const Branch& branch, int number, double at) const {
  const std::vector<double>& sizes = variable(problem_, number).sizes;
  const double range = sizes.back() - sizes.front(), value = std::clamp(at, branch.lower[number], branch.upper[number]);
  const auto above = std::lower_bound(sizes.begin(), sizes.end(), value - at_size * range);
  std::vector<Branch> parts;
  const auto add = [&](double lower, double upper) {
    if (lower > upper || lower > branch.upper[number] || upper < branch.lower[number]) return;
    parts.push_back(branch);
    parts.back().lower[number] = std::max(lower, branch.lower[number]);
    parts.back().upper[number] = std::min(upper, branch.upper[number]);
  };
  const double infinite = std::numeric_limits<double>::infinity();
  if (above != sizes.end() && *above <= value + at_size * range) {
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

Narrowed Branching::narrowed(const Branch& branch) const {
  Narrowed part{branch.lower, branch.upper, {}};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (count(branch, g, Branch::Fate::open) == 0) continue;
    VectorX coefficients = VectorX::Zero(branch.lower.size());
    bool positive = true;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      if (elements_[k].group != g || branch.fates[k] != Branch::Fate::open) continue;
      const int i = elements_[k].numbers.front();  // its share of the range is at most one
      positive = positive && branch.lower[i] >= 0 && coefficients[i] == 0;
      coefficients[i] = 1 / variable(problem_, i).upper;
    }
    const int left = groups_[g] - count(branch, g, Branch::Fate::kept);
    if (positive && coefficients.allFinite()) part.sums.emplace_back(coefficients, left);
  }
  return part;
}

std::vector<std::vector<bool>> Branching::kept(const VectorX& x) const {
  std::vector<std::vector<bool>> all;
  for (const Choice& choice : problem_.choices) {
    all.emplace_back();
    for (const OptionalElement& element : choice.elements)
      all.back().push_back(
          std::any_of(element.numbers.begin(), element.numbers.end(), [&](int i) { return x[i] != 0; }));
  }
  return all;
}

}  // namespace balance::designing
