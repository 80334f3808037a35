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

void assign_momentum_table(const SpecCursor& at, const TimeTable& table, KeptMomentumE& momentum) {
  if (table.time.size() < min_momentum_rows)
    at.fail({.expected = fmt::format("at least {} rows", min_momentum_rows),
             .found = fmt::format("{}", table.time.size())});
  momentum.time = table.time;
  for (const auto& row : table.values) momentum.value.push_back(row.front());
}

bool has_free_key(const SpecCursor& at) {
  const std::vector<Member> members = list_members(at, momentum_forms);
  return std::any_of(members.begin(), members.end(), [](const Member& member) { return member.name == "free"; });
}

void read_momenta(const SpecCursor& at, StudyBuilder& draft, KeptMomentumE& momentum) {
  std::optional<SpecCursor> table, file;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  if (!read_fields(at, momentum_forms,
                   {{"table", Presence::optional, store_in(table)}, {"file", Presence::optional, store_in(file)}}))
    throw CascadingError();
  if (table.has_value() == file.has_value())
    at.fail({.expected = "'table' or 'file'", .found = table ? "both" : "neither"});
  const std::vector<TableColumn> columns{{"momentum", angular_momentum_dimension}};
  if (table)
    assign_momentum_table(*table, read_inline_table(*table, draft, columns), momentum);
  else
    assign_momentum_table(*file, read_table_file(*file, draft, columns), momentum);
}

std::vector<KeptMomentumE*> kept_momenta(TrajectoryOf<Expression>& trajectory) {
  std::vector<KeptMomentumE*> momenta;
  for (auto& task : trajectory.secondary_tasks)
    if (auto* momentum = std::get_if<KeptMomentumE>(&task.kind)) momenta.push_back(momentum);
  return momenta;
}

}  // namespace

KeptMomentumE read_momentum_task(const SpecCursor& at, const std::optional<SpecCursor>& axis, StudyBuilder& draft) {
  KeptMomentumE momentum{.axis = draft.planar() ? 2 : -1, .time = {}, .value = {}, .solution = {}};
  if (axis && draft.planar())
    axis->fail({.expected = "no 'axis' in the plane, where the angular momentum has one component"});
  if (axis) momentum.axis = static_cast<int>(axis->read_choice("a component of the angular momentum", {"x", "y", "z"}));
  if (at.is_scalar() && at.node().text == "zero") return momentum;
  if (at.is_list()) at.fail_expected(momentum_forms);
  if (at.is_map() && !has_free_key(at))
    read_momenta(at, draft, momentum);
  else
    momentum.value.push_back(read_number(at, draft, angular_momentum_dimension));
  return momentum;
}

void assign_momentum_components(const SpecCursor& at, const StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const std::vector<KeptMomentumE*> momenta = kept_momenta(trajectory);
  if (momenta.empty()) return;
  if (draft.planar() && momenta.size() > 1)
    at.fail({.expected = "one quantity that keeps the angular momentum, which has one component in the plane",
             .found = fmt::format("{}", momenta.size())});
  const auto has_no_axis = [](const KeptMomentumE* momentum) { return momentum->axis < 0; };
  const auto is_zero = [](const KeptMomentumE* momentum) { return momentum->value.empty(); };
  if (momenta.size() == 3 && std::all_of(momenta.begin(), momenta.end(), has_no_axis) &&
      std::all_of(momenta.begin(), momenta.end(), is_zero))
    for (int axis = 0; axis < 3; ++axis) momenta[static_cast<std::size_t>(axis)]->axis = axis;
  std::vector<int> axes;
  for (const KeptMomentumE* momentum : momenta) {
    if (momentum->axis < 0)
      at.fail(
          {.expected = "'axis: x', y or z with every 'momentum' in space, except for three that keep all of it at zero",
           .found = "none"});
    if (std::find(axes.begin(), axes.end(), momentum->axis) != axes.end())
      at.fail({.expected = "a different component for each quantity that keeps the angular momentum",
               .found = fmt::format("{} again", "xyz"[momentum->axis])});
    axes.push_back(momentum->axis);
  }
  if (is_mechanism_dependent(trajectory.law.kind) && !std::all_of(momenta.begin(), momenta.end(), is_zero))
    at.fail({.expected =
                 "'momentum: zero' with a law that is searched for: it determines when the momentum takes each value",
             .found = "another one"});
}

namespace {

using SecondaryTaskE = trajectory::SecondaryTaskOf<Expression>;
using SplineTaskE = trajectory::SplineTaskOf<Expression>;

Dimension task_dimension(const SecondaryTaskE& task, const StudyBuilder& draft) {
  if (task.coordinate < 0) return dimension::angle;
  return dimension_of(draft.mechanism().coordinates[static_cast<std::size_t>(task.coordinate)].kind);
}

struct SecondaryTaskKeys {
  std::optional<SpecCursor> spline, over, jump, momentum, axis;
};

bool read_jump(const SpecCursor& at) { return at.read_choice("a truth value", {"false", "true"}) == 1; }

/// Number of coefficients of a spline. With a jump, its middle knot counts twice.
long coefficients_for(const SpecCursor& at, long knots, bool jump) {
  if (jump && knots % 2 == 0)
    at.fail({.expected = "an odd number of knots, one of them in the middle where the acceleration may jump",
             .found = fmt::format("{}", knots)});
  return jump ? knots + 1 : knots;
}

SplineTaskE read_spline(const SecondaryTaskKeys& keys, Dimension dimension, StudyBuilder& draft) {
  SplineTaskE spline;
  if (keys.jump) spline.has_middle_jump = read_jump(*keys.jump);
  if (keys.over) spline.over_time = keys.over->read_choice("a variable of the spline", {"time", "way"}) == 0;
  if (spline.has_middle_jump && !spline.over_time)
    keys.jump->fail({.expected = "no 'jump' with 'over: way': where on the way the law jumps is not known in advance"});
  const SpecCursor& at = *keys.spline;
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

/// A quantity that moves along a `line` needs no task.
void read_secondary_task(const SpecCursor& at, SecondaryTaskE task, StudyBuilder& draft,
                         TrajectoryOf<Expression>& trajectory) {
  const std::string what = "line, {spline: …} or {momentum: …}";
  if (at.is_scalar() && at.node().text == "line") return;
  if (!at.is_map()) at.fail_expected(what);
  SecondaryTaskKeys keys;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  if (!read_fields(at, what,
                   {{"spline", Presence::optional, store_in(keys.spline)},
                    {"over", Presence::optional, store_in(keys.over)},
                    {"jump", Presence::optional, store_in(keys.jump)},
                    {"momentum", Presence::optional, store_in(keys.momentum)},
                    {"axis", Presence::optional, store_in(keys.axis)}}))
    return;
  if (keys.spline.has_value() == keys.momentum.has_value())
    at.fail({.expected = "'spline' or 'momentum'", .found = keys.spline ? "both" : "neither"});
  if (keys.spline) {
    if (keys.axis) keys.axis->fail({.expected = "no such key with 'spline': only a momentum has it"});
    task.kind = read_spline(keys, task_dimension(task, draft), draft);
    const auto& spline = std::get<SplineTaskE>(task.kind);
    if (is_mechanism_dependent(trajectory.law.kind) && spline.over_time)
      keys.spline->fail({.expected = "'over: way' with a law that is searched for: it determines when things happen"});
  } else {
    for (const auto& entry : {keys.over, keys.jump})
      if (entry) entry->fail({.expected = "no such key with 'momentum': only a spline has it"});
    task.kind = read_momentum_task(*keys.momentum, keys.axis, draft);
  }
  trajectory.secondary_tasks.push_back(std::move(task));
}

/// Index of the coordinate with that name; −1 for the planar tool's angle.
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
  auto& coordinates = trajectory.remaining_coordinates;
  const bool is_listed = quantity < 0
                             ? trajectory.remaining_angle
                             : std::find(coordinates.begin(), coordinates.end(), quantity) != coordinates.end();
  if (is_listed)
    at.fail({.expected = "each coordinate only once", .found = fmt::format("{} again", quote_for_message(name))});
  if (quantity < 0)
    trajectory.remaining_angle = true;
  else
    coordinates.push_back(quantity);
  return quantity;
}

}  // namespace

void read_secondary_tasks(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  if (trajectory.drive == DriveKind::joints)
    at.fail({.expected = "no 'remaining' with 'drive: joints', which names its coordinates itself"});
  if (at.is_map()) {
    for (const Member& member : list_members(at, "a mapping of coordinates to their motions"))
      at.problems().collect([&] {
        const int quantity = add_quantity(member.key, member.name, draft, trajectory);
        read_secondary_task(member.value, {quantity, {}}, draft, trajectory);
      });
    assign_momentum_components(at, draft, trajectory);
    return;
  }
  read_each(at.items("a list of joint coordinates, or a mapping of them to their motions"),
            [&](const SpecCursor& item) {
              add_quantity(item, item.read_word("a joint coordinate's name"), draft, trajectory);
            });
}

bool has_momentum_task(const TrajectoryOf<Expression>& trajectory) {
  return std::any_of(trajectory.secondary_tasks.begin(), trajectory.secondary_tasks.end(),
                     [](const SecondaryTaskE& task) {
                       return task.coordinate < 0 && std::holds_alternative<KeptMomentumE>(task.kind);
                     });
}

}  // namespace balance::specification
