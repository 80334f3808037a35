#include "balance/synthesis/design/optional_elements.hpp"

#include "balance/mechanics/model/eccentric_disc.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::design {

namespace {

/// Masses, moments of inertia, stiffness and preload of an element. If all of them are zero, the element has no effect.
VectorX element_quantities(const Mechanism& mechanism, const std::string& section, const std::string& name) {
  const auto of_rotor = [](const auto& one) {
    VectorX all(10);
    all << one.mass, one.inertia.reshaped();
    return all;
  };
  if (section == "springs")
    for (const auto& spring : mechanism.springs)
      if (spring.name == name) return Vector2(spring.stiffness, spring.preload);
  if (section == "discs") {
    for (const auto& disc : mechanism.discs)
      if (disc.name == name) return of_rotor(disc);
    for (const auto& one : mechanism.attachments)
      if (one.name == name && model::is_eccentric_disc(mechanism, one)) return of_rotor(one);
  }
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

/// A point inside all bounds without zeros.
VectorX generic_design_point(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = numbers[static_cast<std::size_t>(i)];
    x[i] = number.lower + 0.37 * (number.upper - number.lower);
    if (x[i] == 0) x[i] = number.lower + 0.61 * (number.upper - number.lower);
  }
  return x;
}

/// Variables that make all quantities vanish when set to zero; std::nullopt if some quantity remains.
std::optional<std::vector<int>> find_vanishing_variables(const DesignSpace& space, const std::string& section,
                                                         const std::string& name) {
  const std::vector<FreeNumber>& free = space.start.free_numbers;
  const VectorX x = generic_design_point(free);
  VectorX remaining = element_quantities(space.instantiate(x).mechanism, section, name);
  std::vector<int> numbers;
  for (std::size_t i = 0; i < free.size() && !remaining.isZero(0); ++i) {
    if (!can_be_zero(free[i])) continue;
    VectorX zeroed = x;
    zeroed[static_cast<Eigen::Index>(i)] = 0;
    const VectorX zeroed_quantities = element_quantities(space.instantiate(zeroed).mechanism, section, name);
    bool makes_zero = false;
    for (Eigen::Index k = 0; k < remaining.size(); ++k)
      if (remaining[k] != 0 && zeroed_quantities[k] == 0) {
        remaining[k] = 0;
        makes_zero = true;
      }
    if (makes_zero) numbers.push_back(static_cast<int>(i));
  }
  if (!remaining.isZero(0) || numbers.empty()) return std::nullopt;
  return numbers;
}

/// For each node of the graph, whether its value depends on an input.
std::vector<bool> find_dependent_nodes(const expression::ExpressionGraph& graph, int input) {
  std::vector<bool> depends;
  for (const expression::ExpressionNode& node : graph.nodes())
    depends.push_back((node.operation == expression::Operation::input && node.input == input) ||
                      std::any_of(node.arguments.begin(), node.arguments.end(), [&](int argument) {
                        return argument >= 0 && depends[static_cast<std::size_t>(argument)];
                      }));
  return depends;
}

MechanismOf<Expression> without_element(MechanismOf<Expression> mechanism, const std::string& section,
                                        const std::string& name) {
  const auto has_name = [&](const auto& one) { return one.name == name; };
  if (section == "springs") std::erase_if(mechanism.springs, has_name);
  if (section == "discs") {
    std::erase_if(mechanism.discs, has_name);
    const auto eccentric =
        std::find_if(mechanism.attachments.begin(), mechanism.attachments.end(),
                     [&](const auto& one) { return one.name == name && model::is_eccentric_disc(mechanism, one); });
    if (eccentric != mechanism.attachments.end()) {
      model::make_shaft_constant(mechanism, *eccentric);
      mechanism.attachments.erase(eccentric);
    }
  }
  if (section == "counterweights")
    std::erase_if(mechanism.attachments,
                  [&](const auto& one) { return one.kind == AttachmentKind::counterweight && one.name == name; });
  return mechanism;
}

/// Variables that no number of the mechanism and of the trajectories depends on except those of the element.
std::vector<int> find_own_variables(const DesignSpace& space, const std::string& section, const std::string& name,
                                    const std::vector<int>& vanishing_variables) {
  const MechanismOf<Expression> others = without_element(space.recording->mechanism, section, name);
  std::vector<int> own;
  for (std::size_t i = 0; i < space.free_inputs.size(); ++i) {
    const int number = static_cast<int>(i);
    if (std::find(vanishing_variables.begin(), vanishing_variables.end(), number) != vanishing_variables.end())
      continue;
    const std::vector<bool> depends = find_dependent_nodes(space.recording->graph, space.free_inputs[i]);
    bool has_effect = false;
    const auto visit = [&](const Expression& x) {
      has_effect = has_effect || (!x.is_constant() && depends[static_cast<std::size_t>(x.node())]);
      return x.value();
    };
    model::convert_mechanism<double>(space.recording->mechanism, visit);
    if (!std::exchange(has_effect, false)) continue;
    model::convert_mechanism<double>(others, visit);
    for (const auto& trajectory : space.recording->trajectories) trajectory::cast_scalar<double>(trajectory, visit);
    if (!has_effect) own.push_back(number);
  }
  return own;
}

}  // namespace

std::vector<CardinalityConstraint> list_optional_elements(const DesignSpace& space) {
  std::vector<CardinalityConstraint> choices;
  for (const study::CardinalityRequest& request : space.start.design.cardinality) {
    CardinalityConstraint choice{request.section, {}, request.max_count};
    for (const study::OptionalElementText& element : request.elements) {
      const auto numbers = find_vanishing_variables(space, request.section, element.name);
      if (numbers)
        choice.elements.push_back(
            {element.name, *numbers, find_own_variables(space, request.section, element.name, *numbers)});
      else if (!request.is_whole_section)
        throw std::invalid_argument(
            fmt::format("design.choose.{}: {} cannot be left out: its mass, inertia, stiffness or preload must be a "
                        "free number that may be zero",
                        request.section, element.name));
    }
    if (choice.elements.empty())
      throw std::invalid_argument(
          fmt::format("design.choose.{}: none of them can be left out: a mass, inertia, stiffness or preload must be a "
                      "free number that may be zero",
                      request.section));
    choices.push_back(std::move(choice));
  }
  return choices;
}

}  // namespace balance::design
