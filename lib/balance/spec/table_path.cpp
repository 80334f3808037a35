#include "balance/base/nearest.hpp"
#include "balance/spec/directions.hpp"
#include "balance/spec/path.hpp"
#include "balance/spec/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace balance::specification {

namespace {

/// A spline needs that many.
constexpr std::size_t min_table_rows = 4;

constexpr Component space_components[]{Component::x,  Component::y,  Component::z,
                                       Component::rx, Component::ry, Component::rz};
constexpr Component plane_components[]{Component::x, Component::y, Component::rz};

Component component_at(int column, const StudyBuilder& draft) {
  const auto i = static_cast<std::size_t>(column);
  return draft.planar() ? plane_components[i] : space_components[i];
}

/// What a table may prescribe.
std::vector<TableColumn> possible_columns(const StudyBuilder& draft, DriveKind drive) {
  const bool planar = draft.planar();
  std::vector<TableColumn> columns;
  if (drive == DriveKind::joints) {
    for (const Coordinate& c : draft.mechanism().coordinates) columns.push_back({c.name, dimension_of(c.kind)});
    return columns;
  }
  columns = {{"x", dimension::length}, {"y", dimension::length}};
  if (!planar) columns.push_back({"z", dimension::length});
  if (drive == DriveKind::com) return columns;
  if (planar)
    columns.push_back({"angle", dimension::angle});
  else
    for (const char* name : {"rx", "ry", "rz"}) columns.push_back({name, dimension::angle});
  return columns;
}

/// The pose that one row of the table prescribes.
PoseTargetOf<Expression> pose_of(const std::vector<Expression>& row, const std::vector<int>& columns,
                                 const StudyBuilder& draft, DriveKind drive) {
  PoseTargetOf<Expression> pose;
  Vector3E position = Vector3E::Zero(), turn = Vector3E::Zero();
  bool moves = false, turns = false;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (drive == DriveKind::joints) {
      pose.joints.push_back({columns[i], row[i]});
      continue;
    }
    const int component = static_cast<int>(component_at(columns[i], draft));
    (component < 3 ? moves : turns) = true;
    (component < 3 ? position : turn)[component % 3] = row[i];
  }
  if (moves) (drive == DriveKind::tool ? pose.tool : pose.com) = position;
  if (turns && draft.planar())
    pose.angle = turn[2];
  else if (turns)
    pose.orientation = rotation_from_vector(turn);
  return pose;
}

void assign_path_table(const SpecCursor& at, const TimeTable& table, StudyBuilder& draft,
                       TrajectoryOf<Expression>& trajectory) {
  if (table.time.size() < min_table_rows)
    at.fail(
        {.expected = fmt::format("at least {} rows", min_table_rows), .found = fmt::format("{}", table.time.size())});
  const auto possible = possible_columns(draft, trajectory.drive);
  if (trajectory.drive != DriveKind::joints) {
    std::vector<Component> components;
    for (const int column : table.columns) components.push_back(component_at(column, draft));
    if (!trajectory.components.empty() && trajectory.components != components)
      at.fail({.expected = fmt::format("the trajectory's {} components in their order", trajectory.components.size()),
               .found = fmt::format("{} columns", components.size())});
    trajectory.components = components;
  }
  trajectory.from = pose_of(table.values.front(), table.columns, draft, trajectory.drive);
  trajectory.to = pose_of(table.values.back(), table.columns, draft, trajectory.drive);
  trajectory.duration = table.time.back() - table.time.front();
  check_duration(at, trajectory.duration.value());
  trajectory.path = TablePathOf<Expression>{table.time, table.values};
}

/// The columns in the order of Component, as the drive expects them. A file may have them in any order.
TimeTable sort_columns(TimeTable table) {
  std::vector<std::size_t> order(table.columns.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return table.columns[a] < table.columns[b]; });
  const auto rearrange = [&](auto& row) {
    auto copy = row;
    for (std::size_t i = 0; i < order.size(); ++i) row[i] = copy[order[i]];
  };
  for (auto& row : table.values) rearrange(row);
  rearrange(table.columns);
  return table;
}

/// The columns of a table in the spec, where it does not name them.
std::vector<int> default_columns(const SpecCursor& table, std::size_t count, const StudyBuilder& draft,
                                 const TrajectoryOf<Expression>& trajectory) {
  std::vector<int> columns;
  if (trajectory.drive == DriveKind::joints) {
    for (const auto& value : trajectory.from.joints) columns.push_back(value.coordinate);
    if (columns.empty()) columns.assign(draft.mechanism().actuators.begin(), draft.mechanism().actuators.end());
  } else if (!trajectory.components.empty()) {
    for (const Component c : trajectory.components) {
      const int space = static_cast<int>(c);
      columns.push_back(draft.planar() && c == Component::rz ? 2 : space);
    }
  } else {
    const std::size_t most = possible_columns(draft, trajectory.drive).size();
    const bool positions_only = trajectory.drive == DriveKind::com || count < most;
    columns.resize(positions_only ? (draft.planar() ? 2 : 3) : most);
    std::iota(columns.begin(), columns.end(), 0);
  }
  if (columns.empty()) table.fail({.expected = "'columns: […]' to name the table's columns", .found = "none"});
  return columns;
}

std::vector<int> read_columns(const SpecCursor& at, const std::vector<TableColumn>& possible) {
  std::vector<std::string> names;
  for (const TableColumn& column : possible) names.push_back(column.name);
  std::vector<int> columns;
  read_each(at.items("a list of the columns after the time"), [&](const SpecCursor& item) {
    const int column = static_cast<int>(item.read_choice("a column", names));
    if (std::find(columns.begin(), columns.end(), column) != columns.end())
      item.fail({.expected = "every column once", .found = fmt::format("{} again", item.describe_found())});
    columns.push_back(column);
  });
  if (columns.empty()) at.fail_expected("at least one column");
  return columns;
}

}  // namespace

void read_table_path(const SpecCursor& at, const std::optional<SpecCursor>& columns, StudyBuilder& draft,
                     TrajectoryOf<Expression>& trajectory) {
  const auto rows = at.items("a list of rows [time, …]");
  if (rows.empty()) at.fail_expected("a list of rows [time, …]");
  const auto possible = possible_columns(draft, trajectory.drive);
  const std::size_t count = rows[0].node().items.empty() ? 0 : rows[0].node().items.size() - 1;
  const std::vector<int> chosen =
      columns ? read_columns(*columns, possible) : default_columns(at, count, draft, trajectory);
  std::vector<TableColumn> wanted;
  for (const int column : chosen) wanted.push_back(possible[static_cast<std::size_t>(column)]);
  TimeTable table = read_inline_table(at, draft, wanted);
  table.columns = chosen;
  const bool order_given = trajectory.drive == DriveKind::joints || !trajectory.components.empty();
  assign_path_table(at, order_given ? table : sort_columns(std::move(table)), draft, trajectory);
}

void read_file_path(const SpecCursor& file, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  const auto possible = possible_columns(draft, trajectory.drive);
  TimeTable table = read_table_file(file, draft, possible);
  assign_path_table(file, sort_columns(std::move(table)), draft, trajectory);
}

}  // namespace balance::specification
