#include "balance/synthesis/design/optional_elements.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace balance {

namespace {

/// Masses, moments of inertia, stiffness and preload of an element: what makes it something.
VectorX element_quantities(const Mechanism& mechanism, const std::string& section, const std::string& name) {
  const auto of_rotor = [](const auto& one) {
    VectorX all(10);
    all << one.mass, one.inertia.reshaped();
    return all;
  };
  if (section == "springs")
    for (const auto& spring : mechanism.springs)
      if (spring.name == name) return Vector2(spring.stiffness, spring.preload);
  if (section == "discs")
    for (const auto& disc : mechanism.discs)
      if (disc.name == name) return of_rotor(disc);
  if (section == "counterweights")
    for (const auto& one : mechanism.attachments)
      if (one.kind == AttachmentKind::counterweight && one.name == name) return of_rotor(one);
  throw std::invalid_argument(fmt::format("design.choose.{}: there is no {}", section, name));
}

bool can_be_zero(const FreeNumber& number) {
  if (!(number.lower <= 0 && number.upper >= 0)) return false;
  return number.discrete_values.empty() ||
         std::find(number.discrete_values.begin(), number.discrete_values.end(), 0.0) != number.discrete_values.end();
}

/// Inside all bounds and not zero.
VectorX generic_design_point(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = numbers[static_cast<std::size_t>(i)];
    x[i] = number.lower + 0.37 * (number.upper - number.lower);
    if (x[i] == 0) x[i] = number.lower + 0.61 * (number.upper - number.lower);
  }
  return x;
}

/// Numbers whose zeros make all of them vanish; nothing if something stays.
std::optional<std::vector<int>> find_vanishing_variables(const DesignSpace& space, const std::string& section,
                                                         const std::string& name) {
  const std::vector<FreeNumber>& free = space.start.free_numbers;
  const VectorX x = generic_design_point(free);
  VectorX left = element_quantities(space.instantiate(x).mechanism, section, name);
  std::vector<int> numbers;
  for (std::size_t i = 0; i < free.size() && !left.isZero(0); ++i) {
    if (!can_be_zero(free[i])) continue;
    VectorX without = x;
    without[static_cast<Eigen::Index>(i)] = 0;
    const VectorX other = element_quantities(space.instantiate(without).mechanism, section, name);
    bool helps = false;
    for (Eigen::Index k = 0; k < left.size(); ++k)
      if (left[k] != 0 && other[k] == 0) {
        left[k] = 0;
        helps = true;
      }
    if (helps) numbers.push_back(static_cast<int>(i));
  }
  if (!left.isZero(0) || numbers.empty()) return std::nullopt;
  return numbers;
}

}  // namespace

std::vector<CardinalityConstraint> list_optional_elements(const DesignSpace& space) {
  std::vector<CardinalityConstraint> choices;
  for (const CardinalityRequest& asked : space.start.design.cardinality) {
    CardinalityConstraint choice{asked.section, {}, asked.max_count};
    for (const OptionalElementText& element : asked.elements) {
      const auto numbers = find_vanishing_variables(space, asked.section, element.name);
      if (numbers)
        choice.elements.push_back({element.name, *numbers});
      else if (!asked.is_whole_section)
        throw std::invalid_argument(fmt::format(
            "design.choose.{}: {} cannot be left out: no free number that may be zero is its mass, inertia, "
            "stiffness or preload",
            asked.section, element.name));
    }
    if (choice.elements.empty())
      throw std::invalid_argument(
          fmt::format("design.choose.{}: none of them can be left out: no free number that may be zero is a mass, "
                      "inertia, stiffness or preload",
                      asked.section));
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace balance
