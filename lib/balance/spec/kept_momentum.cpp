#include "balance/spec/kept_momentum.hpp"

#include "balance/spec/table.hpp"

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

}  // namespace balance::specification
