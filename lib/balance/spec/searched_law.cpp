#include "balance/spec/searched_law.hpp"

#include "balance/base/nearest.hpp"
#include "balance/result/limited.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace balance::specification {

namespace {

/// A number that is never free: the law is no part of a design.
Expression read_bound(const SpecCursor& at, StudyBuilder& draft, Dimension dimension, SignConstraint sign) {
  if (!at.is_scalar()) at.fail_expected("a number or an expression");
  return read_number(at, draft, dimension, sign);
}

bool can_lack_quantities(const SpecErrorCollector& problems) {
  return problems.is_uncertain("joints") || problems.is_uncertain("actuators") || problems.is_uncertain("tool");
}

/// The quantities that a name stands for.
std::vector<LimitableQuantity> find_quantities(const SpecCursor& at, const std::string& name,
                                               const StudyBuilder& draft) {
  std::vector<LimitableQuantity> found = find_limitable_quantities(draft.study.mechanism, name);
  if (!found.empty()) return found;
  if (can_lack_quantities(at.problems())) throw CascadingError();
  if (name == "power" || name.starts_with("power["))
    at.fail({.expected = "a quantity that is affine in the path's acceleration and squared rate",
             .found = fmt::format("{}, a product with the rate", quote_for_message(name))});
  fail_expected_one_of(at, "a quantity that a law can limit", list_limitable_names(draft.study.mechanism));
}

/// `[least, most]` of a scalar.
MotionLimitOf<Expression> read_interval(const SpecCursor& at, const std::string& name,
                                        const std::vector<LimitableQuantity>& quantities, StudyBuilder& draft,
                                        Dimension dimension) {
  if (std::any_of(quantities.begin(), quantities.end(), [](const LimitableQuantity& one) { return one.count > 1; }))
    at.fail({.expected = "one positive number for the magnitude of a vector; a component, such as " + name +
                         "[x], can have [least, most]"});
  const auto both = at.items("a number, or [least, most]", 2);
  MotionLimitOf<Expression> limit{name, read_bound(both[1], draft, dimension, SignConstraint::none),
                                  read_bound(both[0], draft, dimension, SignConstraint::none)};
  if (!(limit.lower_bound->value() < limit.upper_bound.value()))
    at.fail({.expected = "a least value below the largest one",
             .found = fmt::format("{} and {}", both[0].node().text, both[1].node().text)});
  return limit;
}

void read_limits(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  for (const Member& member : list_members(at, "a mapping of quantities to limits"))
    at.problems().collect([&] {
      const auto quantities = find_quantities(member.key, member.name, draft);
      const Dimension dimension = dimension_of_unit(quantities.front().unit);
      if (member.value.is_list())
        trajectory.limits.push_back(read_interval(member.value, member.name, quantities, draft, dimension));
      else
        trajectory.limits.push_back(
            {member.name, read_bound(member.value, draft, dimension, SignConstraint::positive), {}});
    });
  if (at.node().items.empty()) at.fail_expected("at least one limit");
}

/// Of the point along the path; where coordinates are driven the root of the sum of their squared rates.
Dimension speed_dimension(const SpecCursor& at, const TrajectoryOf<Expression>& trajectory, const StudyBuilder& draft) {
  if (trajectory.drive != DriveKind::joints) return dimension::length / dimension::time;
  bool turns = false, slides = false;
  for (const auto& value : trajectory.from.joints) {
    const auto c = static_cast<std::size_t>(value.coordinate);
    (draft.study.mechanism.coordinates[c].kind == CoordinateKind::angle ? turns : slides) = true;
  }
  if (turns && slides)
    at.fail({.expected = "no 'speeds' with a drive of turning and sliding joints, whose rates add up to nothing"});
  return (slides ? dimension::length : dimension::angle) / dimension::time;
}

void read_speeds(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const Dimension dimension = speed_dimension(at, trajectory, draft);
  const auto both = at.items("[speed at the start, speed at the end]", 2);
  trajectory.start_speed = read_bound(both[0], draft, dimension, SignConstraint::not_negative);
  trajectory.end_speed = read_bound(both[1], draft, dimension, SignConstraint::not_negative);
}

void read_peak_quantities(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  trajectory.min_peak_quantity = at.read_word("a quantity's name");
  find_quantities(at, trajectory.min_peak_quantity, draft);
}

}  // namespace

void read_optimised_law(const SpecCursor& at, const OptimisedLawKeys& text, bool corridor, StudyBuilder& draft,
                        TrajectoryOf<Expression>& trajectory) {
  const MotionLawKind law = trajectory.law.kind;
  SpecErrorCollector& problems = draft.problems;
  if (!is_mechanism_dependent(law) || law == MotionLawKind::constant_momentum) {
    if (text.speeds) text.speeds->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.of && !corridor)
      text.of->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.limits) problems.collect([&] { read_limits(*text.limits, draft, trajectory); });
    if (!corridor || law == MotionLawKind::constant_momentum) return;
    if (!text.of) at.fail_missing({"of"});
    return read_peak_quantities(*text.of, draft, trajectory);
  }
  if (text.limits) problems.collect([&] { read_limits(*text.limits, draft, trajectory); });
  if (text.speeds) problems.collect([&] { read_speeds(*text.speeds, draft, trajectory); });
  if (law == MotionLawKind::time_optimal) {
    if (text.of) text.of->fail({.expected = "no 'of' with the law 'fastest', which has limits"});
    if (!text.limits) at.fail_missing({"limits"});
    return;
  }
  if (!text.of) at.fail_missing({"of"});
  read_peak_quantities(*text.of, draft, trajectory);
}

}  // namespace balance::specification
