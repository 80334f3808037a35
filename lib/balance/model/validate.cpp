#include "balance/model/validate.hpp"

#include "balance/model/fault_list.hpp"
#include "balance/model/leaders.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace balance {

namespace {

/// @return false if nothing else can be said
bool check_counts(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, all);
  if (mechanism.space != SpaceKind::planar && mechanism.space != SpaceKind::spatial) {
    faults.add(ValidationIssueKind::unknown_value, "its space must be planar or spatial");
    return false;
  }
  if (mechanism.bodies.empty())
    faults.add(ValidationIssueKind::no_ground, "it has no bodies; the first one is the ground");
  else if (mechanism.bodies.size() == 1)
    faults.add(ValidationIssueKind::no_moving_body, "it has no moving body");
  faults.check_position(mechanism.gravity, mechanism.space == SpaceKind::planar, "gravity");
  return true;
}

void check_coordinates(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  ElementValidator faults(ElementKind::mechanism, 0, mechanism.name, all);
  const std::vector<Coordinate> expected = list_coordinates(mechanism.space, mechanism.joints);
  const bool same =
      std::equal(expected.begin(), expected.end(), mechanism.coordinates.begin(), mechanism.coordinates.end(),
                 [](const Coordinate& a, const Coordinate& b) {
                   return a.name == b.name && a.joint == b.joint && a.index == b.index && a.kind == b.kind;
                 });
  if (!same)
    faults.add(ValidationIssueKind::coordinates_inconsistent,
               "its coordinates must be list_coordinates(space, joints): " + std::to_string(expected.size()) +
                   " of them; it has " + std::to_string(mechanism.coordinates.size()));
}

/// Every body is reached from the ground.
void check_connected(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  std::vector<bool> reached(mechanism.bodies.size(), false);
  const auto at = [](BodyId body) { return static_cast<std::size_t>(body); };
  const auto exists = [&](BodyId body) { return body >= 0 && at(body) < mechanism.bodies.size(); };
  if (!reached.empty()) reached[ground] = true;
  for (bool growing = true; growing;) {
    growing = false;
    for (const Joint& joint : mechanism.joints) {
      if (!exists(joint.first) || !exists(joint.second) || reached[at(joint.first)] == reached[at(joint.second)])
        continue;
      reached[at(joint.first)] = reached[at(joint.second)] = true;
      growing = true;
    }
  }
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (!reached[b])
      ElementValidator(ElementKind::body, b, mechanism.bodies[b].name, all)
          .add(ValidationIssueKind::not_connected, "no chain of joints leads from the ground to it");
}

void check_couplings(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  const std::size_t coordinates = mechanism.coordinates.size();
  CouplingGraph leaders(coordinates);
  for (std::size_t k = 0; k < mechanism.couplings.size(); ++k) {
    const Coupling& coupling = mechanism.couplings[k];
    ElementValidator faults(ElementKind::coupling, k, "", all);
    const bool follower = faults.check_index(coupling.follower, coordinates, "the coordinate that follows");
    const bool leader = check_followed(coupling.leader, coordinates, "the coordinate that leads", faults);
    faults.check_finite(coupling.offset, "the offset");
    if (faults.check_finite(coupling.ratio, "the ratio") && coupling.ratio == 0)
      faults.add(ValidationIssueKind::ratio_zero, "the ratio must not be zero: a joint that does not move is fixed");
    if (!follower || !leader) continue;
    const std::string name = mechanism.coordinates[static_cast<std::size_t>(coupling.follower)].name;
    std::vector<CoordinateId>& led_by = leaders[static_cast<std::size_t>(coupling.follower)];
    if (!led_by.empty())
      faults.add(ValidationIssueKind::duplicate_follower, "'" + name + "' follows another coordinate already");
    else if (creates_coupling_cycle(leaders, coupling.follower, coordinates_of(coupling.leader)))
      faults.add(ValidationIssueKind::coupling_cycle, "'" + name + "' follows itself in a circle");
    else
      led_by = coordinates_of(coupling.leader);
  }
}

void check_references(const Mechanism& mechanism, std::vector<ValidationIssue>& all) {
  std::set<CoordinateId> actuated;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    ElementValidator faults(ElementKind::actuator, a, "", all);
    if (faults.check_index(mechanism.actuators[a], mechanism.coordinates.size(), "its coordinate") &&
        !actuated.insert(mechanism.actuators[a]).second)
      faults.add(ValidationIssueKind::duplicate_reference, "another actuator drives the same coordinate");
  }
  if (mechanism.tool) {
    ElementValidator faults(ElementKind::tool, 0, "", all);
    faults.check_index(mechanism.tool->body, mechanism.bodies.size(), "its body");
    faults.check_position(mechanism.tool->position, mechanism.space == SpaceKind::planar, "its position");
  }
  for (std::size_t k = 0; k < mechanism.assembly.size(); ++k) {
    ElementValidator faults(ElementKind::assembly, k, "", all);
    faults.check_index(mechanism.assembly[k].coordinate, mechanism.coordinates.size(), "its coordinate");
    faults.check_finite(mechanism.assembly[k].value, "the value");
  }
}

}  // namespace

std::vector<ValidationIssue> validate(const Mechanism& mechanism) {
  std::vector<ValidationIssue> all;
  if (!check_counts(mechanism, all)) return all;
  check_bodies(mechanism, all);
  check_joints(mechanism, all);
  check_coordinates(mechanism, all);
  check_connected(mechanism, all);
  check_couplings(mechanism, all);
  check_constraints(mechanism, all);
  check_attachments(mechanism, all);
  check_discs(mechanism, all);
  check_loads(mechanism, all);
  check_springs(mechanism, all);
  check_friction(mechanism, all);
  check_references(mechanism, all);
  return all;
}

bool has_mass(const Mechanism& mechanism) {
  const auto heavy = [](const auto& part) { return part.mass > 0; };
  return std::any_of(mechanism.bodies.begin(), mechanism.bodies.end(), heavy) ||
         std::any_of(mechanism.attachments.begin(), mechanism.attachments.end(), heavy) ||
         std::any_of(mechanism.discs.begin(), mechanism.discs.end(), heavy);
}

void require_valid(const Mechanism& mechanism) {
  std::string sentences;
  for (const ValidationIssue& fault : validate(mechanism)) sentences += (sentences.empty() ? "" : "\n") + fault.message;
  if (!sentences.empty()) throw std::invalid_argument(sentences);
}

}  // namespace balance
