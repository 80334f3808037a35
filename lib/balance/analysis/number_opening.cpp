#include "balance/analysis/number_opening.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {

void add_openings(const JointOpenings& found, std::size_t number, const std::string& path, double deviation,
                  const Mechanism& mechanism, std::vector<NumberOpening>& openings) {
  if (deviation == 0) return;
  for (const JointOpening& one : found)
    openings.push_back({number, path, mechanism.joints[static_cast<std::size_t>(one.joint)].name,
                        one.is_length ? "m" : "rad", one.gap * deviation});
}

Tolerances without_openings(const Tolerances& numbers, const std::vector<NumberOpening>& openings) {
  Tolerances rest;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::none_of(openings.begin(), openings.end(), [i](const NumberOpening& one) { return one.number == i; }))
      rest.push_back(numbers[i]);
  if (rest.empty()) throw std::invalid_argument("every number opens a joint, so that there is nothing to draw");
  return rest;
}

std::string opening_note(const NumberOpening& opening) {
  return fmt::format(
      "over-constrained loops cannot follow {} by itself: its deviation would open {} by {:.3g} {}, and has no part in "
      "what is said of deviations",
      opening.path, opening.joint, opening.gap, opening.unit);
}

}  // namespace balance
