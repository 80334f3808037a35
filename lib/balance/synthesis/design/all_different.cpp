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
  for (const study::DifferentNumbers& different : problem.all_different) {
    Group group{different.numbers, different.taken, 0, {}, true};
    std::vector<std::vector<double>> domains;
    for (const int i : group.variables) {
      domains.push_back(sizes_of(i));
      for (const double size : domains.back()) group.scale = std::max(group.scale, std::abs(size));
    }
    for (std::vector<double>& domain : domains)
      std::erase_if(domain, [&](double size) { return study::is_taken(group.taken, size, group.scale); });
    group.sizes = study::merge_sizes(domains, group.scale);
    group.is_uniform = std::all_of(domains.begin(), domains.end(), [&](const std::vector<double>& domain) {
      return domain.size() == group.sizes.size();
    });
    groups_.push_back(std::move(group));
  }
}

const std::vector<double>& AllDifferent::sizes_of(int variable) const {
  return problem_.variables[static_cast<std::size_t>(variable)].discrete_values;
}

bool AllDifferent::contains(int variable) const {
  return std::any_of(groups_.begin(), groups_.end(),
                     [variable](const Group& group) { return contains_variable(group.variables, variable); });
}

bool AllDifferent::is_violated_by(int variable, const VectorX& x, const std::vector<bool>& is_set) const {
  for (const Group& group : groups_) {
    if (!contains_variable(group.variables, variable)) continue;
    if (study::is_taken(group.taken, x[variable], group.scale)) return true;
    for (const int other : group.variables)
      if (other != variable && is_set[static_cast<std::size_t>(other)] &&
          study::is_same_size(x[other], x[variable], group.scale))
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
      if (other != variable && study::is_same_size(x[other], x[variable], group.scale)) equal.push_back(other);
  }
  return equal;
}

bool AllDifferent::can_complete(const VectorX& x, const std::vector<bool>& is_set) const {
  for (const Group& group : groups_) {
    if (group.is_uniform && group.variables.size() <= group.sizes.size()) continue;
    std::vector<std::vector<double>> domains;
    for (const int i : group.variables) {
      domains.push_back(is_set[static_cast<std::size_t>(i)] ? std::vector<double>{x[i]} : sizes_of(i));
      std::erase_if(domains.back(), [&](double size) { return study::is_taken(group.taken, size, group.scale); });
    }
    if (!study::find_scarce_domains(domains, group.scale).empty()) return false;
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
        if (size < lower[i] || size > upper[i] || study::is_taken(group.taken, size, group.scale)) continue;
        const bool is_fixed_elsewhere = std::any_of(group.variables.begin(), group.variables.end(), [&](int other) {
          return other != i && is_active[static_cast<std::size_t>(other)] && lower[other] == upper[other] &&
                 study::is_same_size(lower[other], size, group.scale);
        });
        if (!is_fixed_elsewhere) domain.push_back(size);
      }
      if (domain.empty()) return false;
      lower[i] = domain.front();
      upper[i] = domain.back();
      domains.push_back(std::move(domain));
    }
    if (!study::find_scarce_domains(domains, group.scale).empty()) return false;
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
