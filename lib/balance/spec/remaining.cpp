#include "balance/spec/remaining.hpp"

#include "balance/base/nearest.hpp"
#include "balance/spec/kept_momentum.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::read {

namespace {

using Course = CourseOf<Expression>;
using AddedSpline = AddedSplineOf<Expression>;

Dimension course_dimension(const Course& course, const Draft& draft) {
  if (course.coordinate < 0) return dimension::angle;
  return dimension_of(draft.mechanism().coordinates[static_cast<std::size_t>(course.coordinate)].kind);
}

struct CourseText {
  std::optional<Cursor> spline, over, jump, momentum, axis;
};

bool read_jump(const Cursor& at) { return at.choice("whether the acceleration may jump", {"false", "true"}) == 1; }

/// With a jump a spline has a knot in the middle, which counts twice.
long coefficients_for(const Cursor& at, long knots, bool jump) {
  if (jump && knots % 2 == 0)
    at.fail({.expected = "an odd number of knots, one of them in the middle where the acceleration may jump",
             .found = fmt::format("{}", knots)});
  return jump ? knots + 1 : knots;
}

AddedSpline read_spline(const CourseText& text, Dimension dimension, Draft& draft) {
  AddedSpline spline;
  if (text.jump) spline.jump = read_jump(*text.jump);
  if (text.over) spline.over_time = text.over->choice("what a spline is over", {"time", "way"}) == 0;
  if (spline.jump && !spline.over_time)
    text.jump->fail({.expected = "no 'jump' with 'over: way': where on the way the law jumps is not known before"});
  const Cursor& at = *text.spline;
  if (at.is_map()) {
    spline.coefficients = read_free_list(at, draft, dimension, "knots", [&](const Cursor& knots, long n) {
      return coefficients_for(knots, n, spline.jump);
    });
    return spline;
  }
  spline.coefficients = read_numbers(at, draft, dimension, "coefficients, or {free: [lower, upper], knots: n}");
  if (spline.coefficients.empty()) at.expected("at least one coefficient");
  if (spline.jump && spline.coefficients.size() % 2 != 0)
    at.fail({.expected = "an even number of coefficients with a jump in the middle",
             .found = fmt::format("{}", spline.coefficients.size())});
  return spline;
}

/// Nothing if the quantity goes straight.
void read_course(const Cursor& at, Course course, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  const std::string what = "line, {spline: …} or {momentum: …}";
  if (at.is_scalar() && at.node().text == "line") return;
  if (!at.is_map()) at.expected(what);
  CourseText text;
  const auto keep = [](std::optional<Cursor>& slot) { return [&slot](const Cursor& c) { slot = c; }; };
  if (!read_fields(at, what,
                   {{"spline", Need::optional, keep(text.spline)},
                    {"over", Need::optional, keep(text.over)},
                    {"jump", Need::optional, keep(text.jump)},
                    {"momentum", Need::optional, keep(text.momentum)},
                    {"axis", Need::optional, keep(text.axis)}}))
    return;
  if (text.spline.has_value() == text.momentum.has_value())
    at.fail({.expected = "'spline' or 'momentum'", .found = text.spline ? "both" : "neither"});
  if (text.spline) {
    if (text.axis) text.axis->fail({.expected = "no such key beside 'spline': only a momentum has it"});
    course.kind = read_spline(text, course_dimension(course, draft), draft);
    const auto& spline = std::get<AddedSpline>(course.kind);
    if (is_searched(trajectory.law.kind) && spline.over_time)
      text.spline->fail({.expected = "'over: way' with a law that is searched for: it decides when things happen"});
  } else {
    for (const auto& key : {text.over, text.jump})
      if (key) key->fail({.expected = "no such key beside 'momentum': only a spline has it"});
    course.kind = read_momentum(*text.momentum, text.axis, draft);
  }
  trajectory.courses.push_back(std::move(course));
}

/// The quantity of a name: −1 is the planar tool's angle.
int read_quantity(const Cursor& at, const std::string& name, Draft& draft) {
  if (name != "angle" || !draft.planar()) return find_coordinate(at, name, draft);
  if (!draft.mechanism().tool)
    at.fail_unless_doubtful(
        "tool", {.expected = "a spec with a tool ('tool: body.point'), whose angle this is", .found = "none"});
  return -1;
}

int add_quantity(const Cursor& at, const std::string& name, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  const int quantity = read_quantity(at, name, draft);
  auto& all = trajectory.remaining;
  const bool known =
      quantity < 0 ? trajectory.remaining_angle : std::find(all.begin(), all.end(), quantity) != all.end();
  if (known) at.fail({.expected = "every coordinate once", .found = fmt::format("{} again", in_quotes(name))});
  if (quantity < 0)
    trajectory.remaining_angle = true;
  else
    all.push_back(quantity);
  return quantity;
}

}  // namespace

void read_remaining(const Cursor& at, Draft& draft, TrajectoryOf<Expression>& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail({.expected = "no 'remaining' with 'drive: joints', which names its coordinates itself"});
  if (at.is_map()) {
    for (const Member& member : members(at, "a mapping of coordinates to how they go"))
      at.problems().guard([&] {
        const int quantity = add_quantity(member.key, member.name, draft, trajectory);
        read_course(member.value, {quantity, {}}, draft, trajectory);
      });
    assign_components(at, draft, trajectory);
    return;
  }
  read_each(at.items("a list of joint coordinates, or a mapping of them to how they go"),
            [&](const Cursor& item) { add_quantity(item, item.word("a joint coordinate's name"), draft, trajectory); });
}

bool keeps_momentum(const TrajectoryOf<Expression>& trajectory) {
  return std::any_of(trajectory.courses.begin(), trajectory.courses.end(), [](const Course& course) {
    return course.coordinate < 0 && std::holds_alternative<KeptMomentumE>(course.kind);
  });
}

}  // namespace balance::read
