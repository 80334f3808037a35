#include "balance/import/urdf_relations.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"

#include <fmt/format.h>

namespace balance::foreign {

namespace {

bool has_one_coordinate(const ForeignModel& robot, int joint) {
  return joint >= 0 && joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(joint)].joint.type) == 1;
}

/// A joint that mimics with the factor 0 stands still at its offset.
void lock_joint(ForeignJoint& one, double offset) {
  Joint& joint = one.joint;
  if (joint.type == JointType::prismatic)
    joint.point_first += offset * joint.axis;
  else
    joint.rotation = rotation_about(joint.axis, offset) * joint.rotation;
  joint.type = JointType::fixed;
  one.rpy.reset();
  one.viscous = one.coulomb = one.stiffness = 0;
}

std::string format_leader_error(const ForeignModel& robot, const ForeignCoupling& coupling) {
  if (coupling.leader < 0) return ", which is no joint here";
  if (coupling.leader == coupling.follower) return ", which is this joint itself";
  const int count = joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(coupling.leader)].joint.type);
  return count == 0 ? ", which is fixed" : fmt::format(", which has {} coordinates", count);
}

void read_mimic(const XmlElement& element, const XmlElement& mimic, const XmlAttributeReader& read,
                ForeignModel& robot) {
  ForeignCoupling coupling;
  coupling.place = place_of(mimic);
  coupling.follower = robot.find_joint(*element.attribute("name"));
  const std::string leader = read.required_text(mimic, "joint");
  coupling.leader = robot.find_joint(leader);
  coupling.ratio = read.number(mimic, "multiplier", 1);
  coupling.offset = read.number(mimic, "offset", 0);
  if (leader.empty()) return;
  const std::string subject = fmt::format("joint {}", quote_for_message(*element.attribute("name")));
  if (coupling.follower >= 0 &&
      joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(coupling.follower)].joint.type) == 0) {
    robot.findings.push_back(
        {Severity::note, place_of(element), "mimic", subject,
         fmt::format("is fixed and mimics {}: nothing follows from that", quote_for_message(leader))});
    return;
  }
  if (!has_one_coordinate(robot, coupling.leader) || coupling.leader == coupling.follower)
    return read.report(mimic, "joint",
                       fmt::format("expected another joint with one coordinate, found {}{}", quote_for_message(leader),
                                   format_leader_error(robot, coupling)));
  if (!has_one_coordinate(robot, coupling.follower))
    return read.report(mimic, "", "only a joint with one coordinate can mimic");
  if (coupling.ratio == 0) {
    lock_joint(robot.joints[static_cast<std::size_t>(coupling.follower)], coupling.offset);
    robot.findings.push_back(
        {Severity::warning, place_of(element), "mimic", subject,
         fmt::format("mimics {} with the factor 0: held at {:g}", quote_for_message(leader), coupling.offset)});
    return;
  }
  robot.findings.push_back({Severity::note, place_of(element), "mimic", subject,
                            fmt::format("mimics {}: a coupling, ratio {:g}, offset {:g}", quote_for_message(leader),
                                        coupling.ratio, coupling.offset)});
  robot.couplings.push_back(std::move(coupling));
}

}  // namespace

void read_urdf_mimics(const XmlElement& root, ForeignDiagnostics& faults, ForeignModel& robot) {
  const XmlAttributeReader read(faults);
  for (const XmlElement& element : root.children)
    if (const XmlElement* mimic = element.name == "joint" ? element.child("mimic") : nullptr)
      read_mimic(element, *mimic, read, robot);
}

void read_urdf_transmissions(const XmlElement& root, ForeignModel& robot) {
  for (const XmlElement& part : root.children) {
    if (part.name != "transmission") continue;
    bool drives = false;
    for (const XmlElement& joint : part.children) {
      const std::string* name = joint.name == "joint" ? joint.attribute("name") : nullptr;
      const int found = name == nullptr ? -1 : robot.find_joint(*name);
      if (found < 0 || joint_degrees_of_freedom(robot.joints[static_cast<std::size_t>(found)].joint.type) == 0)
        continue;
      robot.joints[static_cast<std::size_t>(found)].is_actuated = robot.declares_actuators = drives = true;
    }
    if (!drives) ++robot.ignored[part.name];
  }
}

}  // namespace balance::foreign
