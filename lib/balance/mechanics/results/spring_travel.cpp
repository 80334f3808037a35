#include "balance/mechanics/results/spring_travel.hpp"

#include "balance/mechanics/results/body_poses.hpp"

#include <algorithm>
#include <cstdio>

namespace balance::results {

namespace {

/// Relative to the length: excesses below this are round-off.
constexpr double travel_tolerance = 1e-9;

Vector3 in_world(const BodyPoses& poses, long row, BodyId body, const Vector3& point) {
  const double* origin = &poses.position(row, 3 * body);
  const double* q = &poses.orientation(row, 4 * body);
  return Vector3(origin[0], origin[1], origin[2]) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * point;
}

}  // namespace

std::vector<TravelExcess> find_travel_excesses(const Mechanism& mechanism, const RunResult& result) {
  std::vector<TravelExcess> excesses;
  const bool has_travel = std::any_of(mechanism.springs.begin(), mechanism.springs.end(),
                                      [](const Spring& spring) { return spring.has_travel(); });
  if (!has_travel || result.time.size() == 0) return excesses;
  const BodyPoses poses = body_poses(mechanism, result);
  for (std::size_t s = 0; s < mechanism.springs.size(); ++s) {
    const Spring& spring = mechanism.springs[s];
    if (!spring.has_travel() || spring.is_joint_spring()) continue;
    TravelExcess slack, stretched;
    slack.spring = stretched.spring = static_cast<int>(s);
    stretched.is_long = true;
    for (long row = 0; row < result.time.size(); ++row) {
      const double length = (in_world(poses, row, spring.second, spring.point_second) -
                             in_world(poses, row, spring.first, spring.point_first))
                                .norm();
      TravelExcess& worst = spring.longest_length && length > *spring.longest_length ? stretched : slack;
      const double excess = -spring.travel_margin(length);
      if (excess <= worst.excess || excess <= travel_tolerance * length) continue;
      worst.excess = excess, worst.length = length, worst.time = result.time[row];
      worst.position = result.joint_position.row(row);
    }
    for (const TravelExcess* worst : {&slack, &stretched})
      if (worst->excess > 0) excesses.push_back(*worst);
  }
  return excesses;
}

std::string describe_travel_excess(const Mechanism& mechanism, const TravelExcess& excess) {
  constexpr Eigen::Index max_coordinates = 6;
  const Spring& spring = mechanism.springs[static_cast<std::size_t>(excess.spring)];
  std::string end;
  if (excess.is_long) {
    end = "longer than its longest length " + format_length(*spring.longest_length, mechanism.units);
  } else {
    const double shortest = std::max(spring.shortest_length.value_or(0), spring.slack_length.value_or(0));
    end = "shorter than its shortest length " + format_length(shortest, mechanism.units);
  }
  char time[40];
  std::snprintf(time, sizeof time, " at %.6g s (", excess.time);
  std::string pose;
  for (Eigen::Index c = 0; c < std::min(excess.position.size(), max_coordinates); ++c)
    pose += (c == 0 ? "" : ", ") + mechanism.coordinates[static_cast<std::size_t>(c)].name + " " +
            format_coordinate(mechanism, static_cast<int>(c), excess.position[c], model::pose_round_off);
  if (excess.position.size() > max_coordinates) pose += ", …";
  const bool is_slack = spring.slack_length && excess.length <= *spring.slack_length;
  return "spring " + spring.name + " is " + format_length(excess.excess, mechanism.units) + " " + end + time + pose +
         (is_slack ? "): it hangs slack there, without a force" : "): its force there is not what the results assume");
}

void add_travel_notes(const Mechanism& mechanism, RunResult& result) {
  for (const TravelExcess& excess : find_travel_excesses(mechanism, result))
    result.outcome.notes.push_back(describe_travel_excess(mechanism, excess));
}

}  // namespace balance::results
