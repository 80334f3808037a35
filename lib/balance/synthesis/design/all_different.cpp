#include "balance/synthesis/design/all_different.hpp"

#include "balance/motion/study/different_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace balance::design {

namespace {

bool contains_variable(const std::vector<int>& variables, int variable) {
  return std::find(variables.begin(), variables.end(), variable) != variables.end();
}

}  // namespace

AllDifferent::AllDifferent(const DesignProblem& problem) : problem_(problem) {
  for (const DifferentNumbers& different : problem.all_different) {
    Group group{different.numbers, different.taken, 0, {}, true};
    std::vector<double> all;
    for (const int i : group.variables) all.insert(all.end(), sizes_of(i).begin(), sizes_of(i).end());
    for (const double size : all) group.scale = std::max(group.scale, std::abs(size));
    std::sort(all.begin(), all.end());
    for (const double size : all)
      if (!is_taken(group, size) && (group.sizes.empty() || !is_same_size(group.sizes.back(), size, group.scale)))
        group.sizes.push_back(size);
    for (const int i : group.variables) {
      const auto count =
          std::count_if(sizes_of(i).begin(), sizes_of(i).end(), [&](double size) { return !is_taken(group, size); });
      group.is_uniform = group.is_uniform && static_cast<std::size_t>(count) == group.sizes.size();
    }
    groups_.push_back(std::move(group));
  }
}

const std::vector<double>& AllDifferent::sizes_of(int variable) const {
  return problem_.variables[static_cast<std::size_t>(variable)].discrete_values;
}

bool AllDifferent::is_taken(const Group& group, double size) {
  return std::any_of(group.taken.begin(), group.taken.end(),
                     [&](double taken) { return is_same_size(taken, size, group.scale); });
}

bool AllDifferent::contains(int variable) const {
  return std::any_of(groups_.begin(), groups_.end(),
                     [variable](const Group& group) { return contains_variable(group.variables, variable); });
}

bool AllDifferent::is_violated_by(int variable, const VectorX& x, const std::vector<bool>& is_set) const {
  for (const Group& group : groups_) {
    if (!contains_variable(group.variables, variable)) continue;
    if (is_taken(group, x[variable])) return true;
    for (const int other : group.variables)
      if (other != variable && is_set[static_cast<std::size_t>(other)] &&
          is_same_size(x[other], x[variable], group.scale))
        return true;
  }
  return false;
}

bool AllDifferent::is_violated(const VectorX& x) const {
  const std::vector<bool> all(problem_.variables.size(), true);
  for (const Group& group : groups_)
    for (const int i : group.variables)
      if (is_violated_by(i, x, all)) return true;
  return false;
}

std::vector<int> AllDifferent::find_equal(int variable, const VectorX& x) const {
  std::vector<int> equal;
  for (const Group& group : groups_) {
    if (!contains_variable(group.variables, variable)) continue;
    for (const int other : group.variables)
      if (other != variable && is_same_size(x[other], x[variable], group.scale)) equal.push_back(other);
  }
  return equal;
}

bool AllDifferent::can_complete(const VectorX& x, const std::vector<bool>& is_set) const {
  for (const Group& group : groups_) {
    if (group.is_uniform && group.variables.size() <= group.sizes.size()) continue;
    std::vector<std::vector<double>> domains;
    for (const int i : group.variables) {
      domains.push_back(is_set[static_cast<std::size_t>(i)] ? std::vector<double>{x[i]} : sizes_of(i));
      std::erase_if(domains.back(), [&](double size) { return is_taken(group, size); });
    }
    if (!find_scarce_domains(domains, group.scale).empty()) return false;
  }
  return true;
}

bool AllDifferent::propagate(VectorX& lower, VectorX& upper, const std::vector<bool>& is_active) const {
  for (const Group& group : groups_) {
    std::vector<std::vector<double>> domains;
    for (const int i : group.variables) {
      if (!is_active[static_cast<std::size_t>(i)]) continue;
      std::vector<double> domain;
      for (const double size : sizes_of(i)) {
        if (size < lower[i] || size > upper[i] || is_taken(group, size)) continue;
        const bool is_fixed_elsewhere = std::any_of(group.variables.begin(), group.variables.end(), [&](int other) {
          return other != i && is_active[static_cast<std::size_t>(other)] && lower[other] == upper[other] &&
                 is_same_size(lower[other], size, group.scale);
        });
        if (!is_fixed_elsewhere) domain.push_back(size);
      }
      if (domain.empty()) return false;
      lower[i] = domain.front();
      upper[i] = domain.back();
      domains.push_back(std::move(domain));
    }
    if (!find_scarce_domains(domains, group.scale).empty()) return false;
  }
  return true;
}

std::vector<std::pair<VectorX, double>> AllDifferent::sum_limits(const VectorX& lower, const VectorX& upper,
                                                                 const std::vector<bool>& is_active) const {
  std::vector<std::pair<VectorX, double>> limits;
  for (const Group& group : groups_) {
    VectorX coefficients = VectorX::Zero(lower.size());
    std::size_t count = 0;
    double largest = 0;
    bool is_positive = true;
    for (const int i : group.variables) {
      if (!is_active[static_cast<std::size_t>(i)]) continue;
      coefficients[i] = 1;
      largest = std::max(largest, upper[i]);
      is_positive = is_positive && lower[i] >= 0;
      ++count;
    }
    if (count < 2 || !is_positive) continue;
    const auto end = std::upper_bound(group.sizes.begin(), group.sizes.end(), largest * (1 + 1e-9));
    if (static_cast<std::size_t>(end - group.sizes.begin()) < count) continue;
    const double sum = std::accumulate(end - static_cast<std::ptrdiff_t>(count), end, 0.0);
    limits.emplace_back(std::move(coefficients), sum * (1 + 1e-9));
  }
  return limits;
}

}  // namespace balance::design
