// Dampers, and springs whose force is a table.

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/study_builder.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

namespace {

/// Where an element acts, and the dimensions that follow from it.
struct ElementPlace {
  std::optional<SpecCursor> between, joint;
  Dimension displacement = dimension::length, force = dimension::force;
};

Field place_field(const char* key, std::optional<SpecCursor>& slot) {
  return {key, Presence::optional, [&slot](const SpecCursor& c) { slot = c; }};
}

/// Reads the points or the coordinate. @return false if there is a mistake
bool read_place(const SpecCursor& at, StudyBuilder& draft, ElementPlace& place,
                model::ForceElementOf<Expression>& element) {
  if (!at.is_map()) return false;
  const auto check_form = [&] {
    if (place.between.has_value() != place.joint.has_value()) return;
    const std::string expected = "one of: 'between' (two points), 'joint' (a coordinate)";
    const std::string found = place.between ? "both" : "neither";
    at.fail_unless_uncertain(
        at.path() + ".between",
        {.message = fmt::format("expected {}; found {}", expected, found), .expected = expected, .found = found});
  };
  if (!draft.problems.collect(check_form)) return false;
  if (place.between) return draft.problems.collect([&] { read_connection_points(*place.between, draft, element); });
  return draft.problems.collect([&] {
    element.coordinate = read_coordinate(*place.joint, draft);
    const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(element.coordinate)].kind;
    place.displacement = dimension_of(kind);
    if (kind == CoordinateKind::angle) place.force = dimension::moment;
  });
}

/// Between points an element of its own, in a joint viscous friction.
void add_damper(model::ForceElementOf<Expression> element, const SpecCursor& damping, const ElementPlace& place,
                StudyBuilder& draft) {
  draft.problems.collect([&] {
    element.table = {};
    element.damping =
        read_number(damping, draft, place.force / place.displacement * dimension::time, SignConstraint::not_negative);
    if (element.is_in_joint())
      draft.dampers.push_back({element.coordinate, element.damping, 0, {}, {}, {}});
    else
      draft.mechanism().force_elements.push_back(element);
  });
}

void check_increasing(const SpecCursor& at, const std::vector<Expression>& displacement) {
  for (std::size_t k = 1; k < displacement.size(); ++k)
    if (!(displacement[k].value() > displacement[k - 1].value()))
      at.fail({.expected = "increasing lengths or coordinates",
               .found = fmt::format("{:.9g} after {:.9g} in row {} (SI units)", displacement[k].value(),
                                    displacement[k - 1].value(), k + 1)});
}

/// `[[displacement, force], …]`.
void read_force_table(const SpecCursor& at, const ElementPlace& place, StudyBuilder& draft,
                      model::ForceTableOf<Expression>& table) {
  const bool is_between = place.between.has_value();
  const std::string row_form = is_between ? "a row [length, tension]" : "a row [coordinate, effort]";
  const auto rows = at.items("a list of rows, " + row_form.substr(2));
  read_each(rows, [&](const SpecCursor& row) {
    const auto numbers = row.items(row_form, 2);
    const Expression displacement = read_number(numbers[0], draft, place.displacement,
                                                is_between ? SignConstraint::not_negative : SignConstraint::none);
    table.force.push_back(read_number(numbers[1], draft, place.force));
    table.displacement.push_back(displacement);
  });
  const std::size_t min_rows = table.interpolation == model::TableInterpolation::spline ? 4 : 2;
  if (rows.size() < min_rows)
    at.fail({.expected = min_rows == 2 ? "at least two rows" : "at least four rows for a spline, or 'linear'",
             .found = fmt::format("{} row{}", rows.size(), rows.size() == 1 ? "" : "s")});
  if (table.force.size() == rows.size()) check_increasing(at, table.displacement);
}

}  // namespace

void read_dampers(const SpecCursor& section, StudyBuilder& draft) {
  for (const Member& member : list_named_members(section, "a mapping of dampers {between or joint, damping}")) {
    const SpecCursor& at = member.value;
    ElementPlace place;
    model::ForceElementOf<Expression> element;
    element.name = member.name;
    std::optional<SpecCursor> damping;
    draft.problems.collect([&] {
      const bool is_complete =
          read_fields(at, "a damper {between or joint, damping}",
                      {place_field("between", place.between),
                       place_field("joint", place.joint),
                       {"damping", Presence::required, [&](const SpecCursor& c) { damping = c; }}});
      if (read_place(at, draft, place, element) && is_complete) add_damper(element, *damping, place, draft);
    });
  }
}

void read_tabulated_spring(const SpecCursor& at, const std::string& name, StudyBuilder& draft) {
  ElementPlace place;
  model::ForceElementOf<Expression> element;
  element.name = name;
  std::optional<SpecCursor> table, damping;
  const auto read_interpolation = [&](const SpecCursor& c) {
    if (c.read_choice("an interpolation between rows", {"linear", "spline"}) == 1)
      element.table.interpolation = model::TableInterpolation::spline;
  };
  const bool is_complete = read_fields(at, "a spring {between or joint, table}",
                                       {place_field("between", place.between),
                                        place_field("joint", place.joint),
                                        {"table", Presence::required, [&](const SpecCursor& c) { table = c; }},
                                        {"interpolation", Presence::optional, read_interpolation},
                                        {"damping", Presence::optional, [&](const SpecCursor& c) { damping = c; }}});
  if (!read_place(at, draft, place, element) || !is_complete) return;
  draft.problems.collect([&] { read_force_table(*table, place, draft, element.table); });
  draft.mechanism().force_elements.push_back(element);
  if (damping) add_damper(element, *damping, place, draft);
}

void add_spring_damper(const SpecCursor& damping, const model::SpringOf<Expression>& spring, StudyBuilder& draft) {
  ElementPlace place;
  place.between = damping;
  add_damper({spring.name, spring.first, spring.second, spring.point_first, spring.point_second, -1, {}, 0}, damping,
             place, draft);
}

}  // namespace balance::specification
