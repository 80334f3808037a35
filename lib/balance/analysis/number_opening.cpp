#include "balance/analysis/number_opening.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance {

void add_incompatible_parameters(const ClosureGaps& found, std::size_t number, const std::string& path,
                                 double deviation, const Mechanism& mechanism,
                                 std::vector<IncompatibleParameter>& openings) {
  if (deviation == 0) return;
  for (const ClosureGap& one : found)
    openings.push_back({number, path, mechanism.joints[static_cast<std::size_t>(one.joint)].name,
                        one.is_length ? "m" : "rad", one.gap * deviation});
}

Tolerances remove_incompatible_parameters(const Tolerances& numbers,
                                          const std::vector<IncompatibleParameter>& openings) {
  Tolerances rest;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::none_of(openings.begin(), openings.end(),
                     [i](const IncompatibleParameter& one) { return one.index == i; }))
      rest.push_back(numbers[i]);
  if (rest.empty()) throw std::invalid_argument("every number opens a joint, so that there is nothing to draw");
  return rest;
}

std::string format_incompatibility_note(const IncompatibleParameter& opening) {
  return fmt::format(
      "over-constrained loops cannot follow {} by itself: its deviation would open {} by {:.3g} {}, and has no part in "
      "what is said of deviations",
      opening.key_path, opening.joint, opening.gap, opening.unit);
}

}  // namespace balance
