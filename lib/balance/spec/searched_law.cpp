#include "balance/spec/searched_law.hpp"

#include "balance/base/nearest.hpp"
#include "balance/result/limited.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace balance::read {

namespace {

/// Of a unit that results are in: "N m", "rad/s".
Dimension dimension_of_unit(const std::string& unit) {
  const std::size_t slash = unit.find('/');
  const std::string base = unit.substr(0, slash);
  Dimension dimension = dimension::length;
  if (base == "N m" || base == "J") dimension = dimension::moment;
  if (base == "N") dimension = dimension::force;
  if (base == "rad") dimension = dimension::angle;
  if (slash == std::string::npos) return dimension;
  return unit.ends_with("^2") ? dimension / (dimension::time * dimension::time) : dimension / dimension::time;
}

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

void read_limits(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  for (const Member& member : members(at, "a mapping of quantities to limits"))
    at.problems().guard([&] {
      const auto quantities = find_quantities(member.key, member.name, draft);
      const Dimension dimension = dimension_of_unit(quantities.front().unit);
      trajectory.limits.push_back({member.name, read_bound(member.value, draft, dimension, Sign::positive)});
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

}  // namespace

void read_searched_law(const Cursor& at, const SearchedLawText& text, Draft& draft,
                       TrajectoryOf<Expression>& trajectory) {
  const LawKind law = trajectory.law.kind;
  if (!is_searched(law) || law == LawKind::steady_momentum) {
    for (const auto& one : {text.limits, text.of, text.speeds})
      if (one) one->fail({.expected = "no such key: only the laws 'fastest' and 'gentlest' have it"});
    return;
  }
  Problems& problems = draft.problems;
  if (text.limits) problems.guard([&] { read_limits(*text.limits, draft, trajectory); });
  if (text.speeds) problems.guard([&] { read_speeds(*text.speeds, draft, trajectory); });
  if (law == LawKind::fastest) {
    if (text.of) text.of->fail({.expected = "no 'of' with the law 'fastest', which has limits"});
    if (!text.limits) at.missing({"limits"});
    return;
  }
  if (!text.of) at.missing({"of"});
  trajectory.gentlest_of = text.of->word("a quantity's name");
  find_quantities(*text.of, trajectory.gentlest_of, draft);
}

}  // namespace balance::read
