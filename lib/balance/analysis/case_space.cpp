#include "balance/analysis/case_space.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance {

VectorX CaseSpace::values(std::size_t which, const VectorX& x) const { return x(variable_index[which]); }

VectorX CaseSpace::start_values() const {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) x[static_cast<Eigen::Index>(i)] = numbers[i].start;
  return x;
}

CaseSpace CaseSpace::fix_others(const VectorX& x, const std::vector<int>& kept) const {
  CaseSpace part;
  for (const int i : kept) {
    part.numbers.push_back(numbers[static_cast<std::size_t>(i)]);
    part.numbers.back().start = x[i];
  }
  for (std::size_t k = 0; k < cases.size(); ++k) {
    std::vector<int> own, place;
    for (std::size_t i = 0; i < variable_index[k].size(); ++i) {
      const auto at = std::find(kept.begin(), kept.end(), variable_index[k][i]);
      if (at == kept.end()) continue;
      own.push_back(static_cast<int>(i));
      place.push_back(static_cast<int>(at - kept.begin()));
    }
    part.cases.push_back(cases[k].fix_others(values(k, x), own));
    part.variable_index.push_back(std::move(place));
  }
  return part;
}

CaseSpace make_case_space(const DesignSpace& space) {
  const LoadCases& loads = space.start.design.cases;
  const auto& free = space.start.free_numbers;
  const auto adapted = [&](std::size_t i) {
    return std::find(loads.adapted.begin(), loads.adapted.end(), static_cast<int>(i)) != loads.adapted.end();
  };
  CaseSpace whole;
  std::vector<int> shared(free.size(), -1);
  for (std::size_t i = 0; i < free.size(); ++i) {
    if (adapted(i)) continue;
    shared[i] = static_cast<int>(whole.numbers.size());
    whole.numbers.push_back(free[i]);
  }
  for (Eigen::Index k = 0; k < loads.size(); ++k) {
    const VectorX load = loads.values.row(k);
    whole.cases.push_back(at_load(space, load));
    whole.variable_index.push_back(shared);
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (!adapted(i)) continue;
      whole.variable_index.back()[i] = static_cast<int>(whole.numbers.size());
      whole.numbers.push_back(free[i]);
      whole.numbers.back().key_path += fmt::format(" ({})", load_text(loads.numbers, load));
    }
  }
  return whole;
}

DesignSpace at_load(const DesignSpace& space, const VectorX& loads) {
  DesignSpace loaded = space;
  const auto& numbers = space.start.design.cases.numbers;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    loaded.inputs[static_cast<std::size_t>(numbers[i].input)] = loads[static_cast<Eigen::Index>(i)];
  loaded.start = loaded.study_at(space.start_values());
  return loaded;
}

VectorX nominal_load(const DesignSpace& space) {
  const auto& numbers = space.start.design.cases.numbers;
  VectorX loads(static_cast<Eigen::Index>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) loads[static_cast<Eigen::Index>(i)] = numbers[i].nominal;
  return loads;
}

std::string load_text(const std::vector<LoadParameter>& numbers, const VectorX& loads) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    text += fmt::format("{}{} = {:.6g}", i == 0 ? "" : ", ", numbers[i].name,
                        loads[static_cast<Eigen::Index>(i)] / numbers[i].unit);
  return text;
}

}  // namespace balance
