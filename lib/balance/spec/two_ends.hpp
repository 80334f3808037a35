#pragma once
/// What joints and springs between points connect.

#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

namespace balance::specification {

/// `[body.point, body.point]`, of two bodies: the ends of a joint or a spring.
template <class Connection>
void read_connection_points(const SpecCursor& at, StudyBuilder& draft, Connection& connection) {
  const auto ends = at.items("two points [body.point, body.point]", 2);
  PointReference first, second;
  const bool first_read = draft.problems.collect([&] { first = read_reference(ends[0], draft); });
  const bool second_read = draft.problems.collect([&] { second = read_reference(ends[1], draft); });
  if (!first_read || !second_read) return;
  if (first.body == second.body)
    at.fail({.expected = "points of two bodies",
             .found = "two points of " +
                      quote_for_message(draft.mechanism().bodies[static_cast<std::size_t>(first.body)].name)});
  connection.first = first.body;
  connection.second = second.body;
  connection.point_first = first.position;
  connection.point_second = second.position;
}

}  // namespace balance::specification
