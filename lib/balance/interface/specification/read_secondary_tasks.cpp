#include "balance/interface/specification/read_secondary_tasks.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/spec_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

constexpr Dimension angular_momentum_dimension = dimension::moment * dimension::time;
constexpr const char* momentum_forms = "zero, a number, {table: [[time, momentum], …]} or {file: …}";
constexpr std::size_t min_momentum_rows = 2;

void assign_momentum_table(const SpecCursor& at, const TimeTable& table, KeptMomentumE& kept) {
  if (table.time.size() < min_momentum_rows)
    at.fail({.expected = fmt::format("at least {} rows", min_momentum_rows),
             .found = fmt::format("{}", table.time.size())});
  kept.time = table.time;
  for (const auto& row : table.values) kept.value.push_back(row.front());
}

bool has_free_key(const SpecCursor& at) {
  const std::vector<Member> all = list_members(at, momentum_forms);
  return std::any_of(all.begin(), all.end(), [](const Member& member) { return member.name == "free"; });
}

void read_momenta(const SpecCursor& at, StudyBuilder& draft, KeptMomentumE& kept) {
  std::optional<SpecCursor> table, file;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  if (!read_fields(at, momentum_forms,
                   {{"table", Presence::optional, keep(table)}, {"file", Presence::optional, keep(file)}}))
    throw CascadingError();
  if (table.has_value() == file.has_value())
    at.fail({.expected = "'table' or 'file'", .found = table ? "both" : "neither"});
  const std::vector<TableColumn> columns{{"momentum", angular_momentum_dimension}};
  if (table)
    assign_momentum_table(*table, read_inline_table(*table, draft, columns), kept);
  else
    assign_momentum_table(*file, read_table_file(*file, draft, columns), kept);
}

std::vector<KeptMomentumE*> kept_momenta(TrajectoryOf<Expression>& trajectory) {
  std::vector<KeptMomentumE*> all;
  for (auto& course : trajectory.secondary_tasks)
    if (auto* kept = std::get_if<KeptMomentumE>(&course.kind)) all.push_back(kept);
  return all;
}

}  // namespace

KeptMomentumE read_momentum_task(const SpecCursor& at, const std::optional<SpecCursor>& axis, StudyBuilder& draft) {
  KeptMomentumE kept{.axis = draft.planar() ? 2 : -1, .time = {}, .value = {}, .solution = {}};
  if (axis && draft.planar())
    axis->fail({.expected = "no 'axis' in the plane, where the angular momentum has one component"});
  if (axis) kept.axis = static_cast<int>(axis->read_choice("a component of the angular momentum", {"x", "y", "z"}));
  if (at.is_scalar() && at.node().text == "zero") return kept;
  if (at.is_list()) at.fail_expected(momentum_forms);
  if (at.is_map() && !has_free_key(at))
    read_momenta(at, draft, kept);
  else
    kept.value.push_back(read_number(at, draft, angular_momentum_dimension));
  return kept;
}

void assign_momentum_components(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const std::vector<KeptMomentumE*> all = kept_momenta(trajectory);
  if (all.empty()) return;
  if (draft.planar() && all.size() > 1)
    at.fail({.expected = "one quantity that keeps the angular momentum, which has one component in the plane",
             .found = fmt::format("{}", all.size())});
  const auto unsaid = [](const KeptMomentumE* kept) { return kept->axis < 0; };
  const auto zero = [](const KeptMomentumE* kept) { return kept->value.empty(); };
  if (all.size() == 3 && std::all_of(all.begin(), all.end(), unsaid) && std::all_of(all.begin(), all.end(), zero))
    for (int axis = 0; axis < 3; ++axis) all[static_cast<std::size_t>(axis)]->axis = axis;
  std::vector<int> axes;
  for (const KeptMomentumE* kept : all) {
    if (kept->axis < 0)
      at.fail(
          {.expected = "'axis: x', y or z beside every 'momentum' in space, but for three that keep all of it at zero",
           .found = "none"});
    if (std::find(axes.begin(), axes.end(), kept->axis) != axes.end())
      at.fail({.expected = "a component of its own for every quantity that keeps the angular momentum",
               .found = fmt::format("{} again", "xyz"[kept->axis])});
    axes.push_back(kept->axis);
  }
  if (is_mechanism_dependent(trajectory.law.kind) && !std::all_of(all.begin(), all.end(), zero))
    at.fail(
        {.expected = "'momentum: zero' with a law that is searched for: it decides when the momentum has which value",
         .found = "another one"});
}

namespace {

using Course = SecondaryTaskOf<Expression>;
using AddedSpline = SplineTaskOf<Expression>;

Dimension course_dimension(const Course& course, const StudyBuilder& draft) {
  if (course.coordinate < 0) return dimension::angle;
  return dimension_of(draft.mechanism().coordinates[static_cast<std::size_t>(course.coordinate)].kind);
}

struct SecondaryTaskKeys {
  std::optional<SpecCursor> spline, over, jump, momentum, axis;
};

bool read_jump(const SpecCursor& at) {
  return at.read_choice("whether the acceleration may jump", {"false", "true"}) == 1;
}

/// With a jump a spline has a knot in the middle, which counts twice.
long coefficients_for(const SpecCursor& at, long knots, bool jump) {
  if (jump && knots % 2 == 0)
    at.fail({.expected = "an odd number of knots, one of them in the middle where the acceleration may jump",
             .found = fmt::format("{}", knots)});
  return jump ? knots + 1 : knots;
}

AddedSpline read_spline(const SecondaryTaskKeys& text, Dimension dimension, StudyBuilder& draft) {
  AddedSpline spline;
  if (text.jump) spline.has_middle_jump = read_jump(*text.jump);
  if (text.over) spline.over_time = text.over->read_choice("what a spline is over", {"time", "way"}) == 0;
  if (spline.has_middle_jump && !spline.over_time)
    text.jump->fail({.expected = "no 'jump' with 'over: way': where on the way the law jumps is not known before"});
  const SpecCursor& at = *text.spline;
  if (at.is_map()) {
    spline.coefficients = read_free_list(at, draft, dimension, "knots", [&](const SpecCursor& knots, long n) {
      return coefficients_for(knots, n, spline.has_middle_jump);
    });
    return spline;
  }
  spline.coefficients = read_numbers(at, draft, dimension, "coefficients, or {free: [lower, upper], knots: n}");
  if (spline.coefficients.empty()) at.fail_expected("at least one coefficient");
  if (spline.has_middle_jump && spline.coefficients.size() % 2 != 0)
    at.fail({.expected = "an even number of coefficients with a jump in the middle",
             .found = fmt::format("{}", spline.coefficients.size())});
  return spline;
}

/// Nothing if the quantity goes straight.
void read_secondary_task(const SpecCursor& at, Course course, StudyBuilder& draft,
                         TrajectoryOf<Expression>& trajectory) {
  const std::string what = "line, {spline: …} or {momentum: …}";
  if (at.is_scalar() && at.node().text == "line") return;
  if (!at.is_map()) at.fail_expected(what);
  SecondaryTaskKeys text;
  const auto keep = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  if (!read_fields(at, what,
                   {{"spline", Presence::optional, keep(text.spline)},
                    {"over", Presence::optional, keep(text.over)},
                    {"jump", Presence::optional, keep(text.jump)},
                    {"momentum", Presence::optional, keep(text.momentum)},
                    {"axis", Presence::optional, keep(text.axis)}}))
    return;
  if (text.spline.has_value() == text.momentum.has_value())
    at.fail({.expected = "'spline' or 'momentum'", .found = text.spline ? "both" : "neither"});
  if (text.spline) {
    if (text.axis) text.axis->fail({.expected = "no such key beside 'spline': only a momentum has it"});
    course.kind = read_spline(text, course_dimension(course, draft), draft);
    const auto& spline = std::get<AddedSpline>(course.kind);
    if (is_mechanism_dependent(trajectory.law.kind) && spline.over_time)
      text.spline->fail({.expected = "'over: way' with a law that is searched for: it decides when things happen"});
  } else {
    for (const auto& key : {text.over, text.jump})
      if (key) key->fail({.expected = "no such key beside 'momentum': only a spline has it"});
    course.kind = read_momentum_task(*text.momentum, text.axis, draft);
  }
  trajectory.secondary_tasks.push_back(std::move(course));
}

/// The quantity of a name: −1 is the planar tool's angle.
int read_quantity(const SpecCursor& at, const std::string& name, StudyBuilder& draft) {
  if (name != "angle" || !draft.planar()) return find_coordinate(at, name, draft);
  if (!draft.mechanism().tool)
    at.fail_unless_uncertain(
        "tool", {.expected = "a spec with a tool ('tool: body.point'), whose angle this is", .found = "none"});
  return -1;
}

int add_quantity(const SpecCursor& at, const std::string& name, StudyBuilder& draft,
                 TrajectoryOf<Expression>& trajectory) {
  const int quantity = read_quantity(at, name, draft);
  auto& all = trajectory.remaining_coordinates;
  const bool known =
      quantity < 0 ? trajectory.remaining_angle : std::find(all.begin(), all.end(), quantity) != all.end();
  if (known) at.fail({.expected = "every coordinate once", .found = fmt::format("{} again", quote_for_message(name))});
  if (quantity < 0)
    trajectory.remaining_angle = true;
  else
    all.push_back(quantity);
  return quantity;
}

}  // namespace

void read_secondary_tasks(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail({.expected = "no 'remaining' with 'drive: joints', which names its coordinates itself"});
  if (at.is_map()) {
    for (const Member& member : list_members(at, "a mapping of coordinates to how they go"))
      at.problems().collect([&] {
        const int quantity = add_quantity(member.key, member.name, draft, trajectory);
        read_secondary_task(member.value, {quantity, {}}, draft, trajectory);
      });
    assign_momentum_components(at, draft, trajectory);
    return;
  }
  read_each(at.items("a list of joint coordinates, or a mapping of them to how they go"), [&](const SpecCursor& item) {
    add_quantity(item, item.read_word("a joint coordinate's name"), draft, trajectory);
  });
}

bool has_momentum_task(const TrajectoryOf<Expression>& trajectory) {
  return std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(), [](const Course& course) {
    return course.coordinate < 0 && std::holds_alternative<KeptMomentumE>(course.kind);
  });
}

}  // namespace balance::specification
