#include "balance/interface/specification/read_bushings.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

namespace {

/// Numbers of one kind for the three or six coordinates of a bushing, or for those of its slides or rotations.
struct BushingNumbers {
  std::vector<Expression> stiffness, damping;  ///< empty: not given
};

/// One number for all directions, or one for each.
std::vector<Expression> read_directions(const SpecCursor& at, StudyBuilder& draft, std::size_t count,
                                        const Dimension& dimension) {
  if (!at.is_list())
    return std::vector<Expression>(count, read_number(at, draft, dimension, SignConstraint::not_negative));
  std::vector<Expression> numbers;
  const std::string form =
      count == 1 ? "a number" : "a number, or one for each of " + std::to_string(count) + " directions";
  for (const SpecCursor& item : at.items(form, static_cast<int>(count)))
    numbers.push_back(read_number(item, draft, dimension, SignConstraint::not_negative));
  return numbers;
}

void add_elements(const std::string& joint, std::size_t first, bool is_angle, const BushingNumbers& numbers,
                  StudyBuilder& draft) {
  const int x = draft.coordinates.find(draft.mechanism().coordinates, joint + ".x");
  if (x < 0) throw CascadingError();  // another joint has the name
  const auto start = static_cast<std::size_t>(x);
  for (std::size_t k = 0; k < std::max(numbers.stiffness.size(), numbers.damping.size()); ++k) {
    const auto coordinate = static_cast<CoordinateId>(static_cast<int>(start + first + k));
    if (k < numbers.stiffness.size()) {
      model::SpringOf<Expression> spring;
      spring.name = joint + (is_angle ? (numbers.stiffness.size() > 1 ? "_r" + std::string(1, "xyz"[k]) : "_angle")
                                      : "_" + std::string(1, "xyz"[k]));
      spring.stiffness = numbers.stiffness[k];
      spring.coordinate = coordinate;
      draft.added_springs.push_back(std::move(spring));
    }
    if (k < numbers.damping.size()) {
      model::FrictionOf<Expression> damper;
      damper.coordinate = coordinate;
      damper.viscous = numbers.damping[k];
      draft.dampers.push_back(damper);
    }
  }
}

/// The joint must have been added, with its coordinates.
void read_elements(const SpecCursor& at, const std::string& name, StudyBuilder& draft) {
  const std::size_t slides = draft.planar() ? 2 : 3, rotations = draft.planar() ? 1 : 3;
  BushingNumbers linear, angular;
  const Dimension per_length = dimension::force / dimension::length, per_angle = dimension::moment / dimension::angle;
  std::optional<SpecCursor> rotation;
  const auto read = [&](std::vector<Expression>& numbers, std::size_t count, const Dimension& dimension) {
    return [&numbers, &draft, count, dimension](const SpecCursor& c) {
      numbers = read_directions(c, draft, count, dimension);
    };
  };
  read_fields(at, "a bushing {between, stiffness}",
              {{"between", Presence::required, [](const SpecCursor&) {}},
               {"stiffness", Presence::required, read(linear.stiffness, slides, per_length)},
               {"damping", Presence::optional, read(linear.damping, slides, per_length * dimension::time)},
               {"angular", Presence::optional, [&](const SpecCursor& c) { rotation = c; }}});
  if (rotation)
    read_fields(*rotation, "{stiffness, damping} of the rotation",
                {{"stiffness", Presence::optional, read(angular.stiffness, rotations, per_angle)},
                 {"damping", Presence::optional, read(angular.damping, rotations, per_angle * dimension::time)}});
  add_elements(name, 0, false, linear, draft);
  add_elements(name, slides, true, angular, draft);
}

}  // namespace

void read_bushings(const SpecCursor& section, StudyBuilder& draft) {
  auto& mechanism = draft.mechanism();
  const auto members = list_named_members(section, "a mapping of bushings {between, stiffness}");
  for (const Member& member : members) {
    const auto& joints = mechanism.joints;
    if (std::any_of(joints.begin(), joints.end(), [&](const auto& joint) { return joint.name == member.name; }))
      draft.problems.collect([&] {
        member.key.fail({.expected = "a bushing with a name of its own: it is listed among the joints",
                         .found = "the name of a joint"});
      });
    model::JointOf<Expression> joint;
    joint.name = member.name;
    joint.type = draft.planar() ? JointType::planar : JointType::free;
    joint.axis = Vector3E::UnitZ();
    joint.axis2 = Vector3E::UnitX();
    draft.problems.collect([&] {
      if (!member.value.is_map()) return;
      for (const Member& part : list_members(member.value, "a bushing {between, stiffness}"))
        if (part.name == "between") read_connection_points(part.value, draft, joint);
    });
    mechanism.joints.push_back(std::move(joint));
  }
  list_joint_coordinates(draft);
  for (const Member& member : members) draft.problems.collect([&] { read_elements(member.value, member.name, draft); });
}

void add_dampers(StudyBuilder& draft) {
  auto& mechanism = draft.mechanism();
  for (auto& spring : draft.added_springs) mechanism.springs.push_back(std::move(spring));
  for (const auto& damper : draft.dampers) {
    const auto same = std::find_if(mechanism.friction.begin(), mechanism.friction.end(),
                                   [&](const auto& friction) { return friction.coordinate == damper.coordinate; });
    if (same == mechanism.friction.end())
      mechanism.friction.push_back(damper);
    else
      same->viscous = same->viscous + damper.viscous;
  }
}

}  // namespace balance::specification
