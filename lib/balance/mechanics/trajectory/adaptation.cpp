#include "balance/mechanics/trajectory/adaptation.hpp"

#include "balance/mechanics/trajectory/path_offsets.hpp"

#include <stdexcept>
#include <string>

namespace balance::trajectory {

namespace {

constexpr double collinearity_tolerance = 1e-9;  ///< of the extent of the places: this near to a line, they are on it

[[noreturn]] void refuse(const std::string& name, const std::string& reason) {
  throw std::invalid_argument("counterweight '" + name + "' cannot be moved: " + reason);
}

/// Unit vector from the counterweight's place towards the first other one.
Vector3 find_slide_direction(const Attachment& counterweight, const Adaptation& adaptation) {
  Vector3 farthest = Vector3::Zero(), first = Vector3::Zero();
  for (const CounterweightMove& move : adaptation.moves) {
    const Vector3 way = move.to - counterweight.position;
    if (way.norm() > farthest.norm()) farthest = way;
    if (first.isZero(0)) first = way;
  }
  if (farthest.isZero(0)) return Vector3::UnitX();
  for (const CounterweightMove& move : adaptation.moves)
    if ((move.to - counterweight.position).cross(farthest.normalized()).norm() >
        collinearity_tolerance * farthest.norm())
      refuse(counterweight.name, "its places are not on one line");
  return (first.dot(farthest) < 0 ? -1 : 1) * farthest.normalized();
}

CoordinateCourse make_course(const Attachment& counterweight, const Adaptation& adaptation, const Vector3& direction,
                             CoordinateId coordinate, double duration) {
  CoordinateCourse course{coordinate, {}};
  double place = 0;
  for (const CounterweightMove& move : adaptation.moves) {
    const double next_place = direction.dot(move.to - counterweight.position);
    course.moves.push_back({move.start, move.duration, next_place - place, move.law});
    place = next_place;
  }
  if (const std::string issue = find_course_issue(course, duration); !issue.empty()) refuse(counterweight.name, issue);
  return course;
}

void add_slide(const Adaptation& adaptation, double duration, AdaptedMotion& adapted) {
  Mechanism& mechanism = adapted.mechanism;
  Attachment& counterweight = mechanism.attachments[static_cast<std::size_t>(adaptation.attachment)];
  const Vector3 direction = find_slide_direction(counterweight, adaptation);

  Joint slide;
  slide.name = counterweight.name;
  slide.type = JointType::prismatic;
  slide.first = counterweight.body;
  slide.second = static_cast<int>(mechanism.bodies.size());
  slide.point_first = counterweight.position;
  slide.axis = direction;
  slide.axis2 = direction.unitOrthogonal();
  const CoordinateId coordinate = static_cast<int>(mechanism.coordinates.size());
  adapted.trajectory.courses.push_back(make_course(counterweight, adaptation, direction, coordinate, duration));

  Body carriage;
  carriage.name = counterweight.name;
  mechanism.bodies.push_back(std::move(carriage));
  counterweight.body = slide.second;
  counterweight.position.setZero();
  mechanism.joints.push_back(std::move(slide));
  mechanism.coordinates = list_coordinates(mechanism.space, mechanism.joints);
  mechanism.actuators.push_back(coordinate);
  if (mechanism.torque_distribution) mechanism.torque_distribution->shares.emplace_back();
  mechanism.assembly.push_back({coordinate, 0});
  adapted.trajectory.from.joints.push_back({coordinate, 0});
  adapted.trajectory.to.joints.push_back({coordinate, 0});
}

}  // namespace

AdaptedMotion model_adaptations(const Mechanism& mechanism, const Trajectory& trajectory) {
  AdaptedMotion adapted{mechanism, trajectory};
  if (trajectory.adaptations.empty()) return adapted;
  if (is_mechanism_dependent(trajectory))
    throw std::invalid_argument(
        "counterweights that move with the payload cannot be combined with a law, a corridor or a momentum for which "
        "the motion is searched");
  adapted.trajectory.adaptations.clear();
  for (const Adaptation& adaptation : trajectory.adaptations)
    add_slide(adaptation, find_trajectory_duration(trajectory), adapted);
  return adapted;
}

}  // namespace balance::trajectory
