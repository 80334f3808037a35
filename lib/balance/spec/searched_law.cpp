#include "balance/spec/searched_law.hpp"

#include "balance/base/nearest.hpp"
#include "balance/result/limited.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

namespace balance::read {

namespace {

/// A number that is never free: the law is no part of a design.
Expression read_bound(const Cursor& at, Draft& draft, Dimension dimension, Sign sign) {
  if (!at.is_scalar()) at.expected("a number or an expression");
  return read_number(at, draft, dimension, sign);
}

bool some_may_be_missing(const Problems& problems) {
  return problems.doubtful("joints") || problems.doubtful("actuators") || problems.doubtful("tool");
}

/// The quantities that a name stands for.
std::vector<LimitedQuantity> find_quantities(const Cursor& at, const std::string& name, const Draft& draft) {
  std::vector<LimitedQuantity> found = find_limited(draft.study.mechanism, name);
  if (!found.empty()) return found;
  if (some_may_be_missing(at.problems())) throw Consequence();
  if (name == "power" || name.starts_with("power["))
    at.fail({.expected = "a quantity that is affine in the path's acceleration and squared rate",
             .found = fmt::format("{}, a product with the rate", in_quotes(name))});
  expected_one_of(at, "a quantity that a law can limit", limited_names(draft.study.mechanism));
}

/// `[least, most]` of a scalar.
MotionLimitOf<Expression> read_interval(const Cursor& at, const std::string& name,
                                        const std::vector<LimitedQuantity>& quantities, Draft& draft,
                                        Dimension dimension) {
  if (std::any_of(quantities.begin(), quantities.end(), [](const LimitedQuantity& one) { return one.count > 1; }))
    at.fail({.expected = "one positive number for the magnitude of a vector; a component, such as " + name +
                         "[x], can have [least, most]"});
  const auto both = at.items("a number, or [least, most]", 2);
  MotionLimitOf<Expression> limit{name, read_bound(both[1], draft, dimension, Sign::any),
                                  read_bound(both[0], draft, dimension, Sign::any)};
  if (!(limit.least->value() < limit.bound.value()))
    at.fail({.expected = "a least value below the largest one",
             .found = fmt::format("{} and {}", both[0].node().text, both[1].node().text)});
  return limit;
}

void read_limits(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  for (const Member& member : members(at, "a mapping of quantities to limits"))
    at.problems().guard([&] {
      const auto quantities = find_quantities(member.key, member.name, draft);
      const Dimension dimension = dimension_of_unit(quantities.front().unit);
      if (member.value.is_list())
        trajectory.limits.push_back(read_interval(member.value, member.name, quantities, draft, dimension));
      else
        trajectory.limits.push_back({member.name, read_bound(member.value, draft, dimension, Sign::positive), {}});
    });
  if (at.node().items.empty()) at.expected("at least one limit");
}

/// Of the point along the path; where coordinates are driven the root of the sum of their squared rates.
Dimension speed_dimension(const Cursor& at, const TrajectoryOf<Expression>& trajectory, const Draft& draft) {
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

void read_speeds(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  const Dimension dimension = speed_dimension(at, trajectory, draft);
  const auto both = at.items("[speed at the start, speed at the end]", 2);
  trajectory.start_speed = read_bound(both[0], draft, dimension, Sign::not_negative);
  trajectory.end_speed = read_bound(both[1], draft, dimension, Sign::not_negative);
}

void read_of(const Cursor& at, const Draft& draft, TrajectoryOf<Expression>& trajectory) {
  trajectory.gentlest_of = at.word("a quantity's name");
  find_quantities(at, trajectory.gentlest_of, draft);
}

}  // namespace

void read_searched_law(const Cursor& at, const SearchedLawText& text, bool corridor, Draft& draft,
                       TrajectoryOf<Expression>& trajectory) {
  const LawKind law = trajectory.law.kind;
  Problems& problems = draft.problems;
  if (!is_searched(law) || law == LawKind::steady_momentum) {
    if (text.speeds) text.speeds->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.of && !corridor)
      text.of->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    if (text.limits) problems.guard([&] { read_limits(*text.limits, draft, trajectory); });
    if (!corridor || law == LawKind::steady_momentum) return;
    if (!text.of) at.missing({"of"});
    return read_of(*text.of, draft, trajectory);
  }
  if (text.limits) problems.guard([&] { read_limits(*text.limits, draft, trajectory); });
  if (text.speeds) problems.guard([&] { read_speeds(*text.speeds, draft, trajectory); });
  if (law == LawKind::fastest) {
    if (text.of) text.of->fail({.expected = "no 'of' with the law 'fastest', which has limits"});
    if (!text.limits) at.missing({"limits"});
    return;
  }
  if (!text.of) at.missing({"of"});
  read_of(*text.of, draft, trajectory);
}

}  // namespace balance::read
