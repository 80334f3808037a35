#include "balance/import/urdf_relations.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/rotation.hpp"

#include <fmt/format.h>

namespace balance::foreign {

namespace {

bool has_one_coordinate(const Robot& robot, int joint) {
  return joint >= 0 && freedom(robot.joints[static_cast<std::size_t>(joint)].joint.type) == 1;
}

/// A joint that mimics with the factor 0 stands still at its offset.
void hold(RobotJoint& one, double offset) {
  Joint& joint = one.joint;
  if (joint.type == JointType::prismatic)
    joint.point_first += offset * joint.axis;
  else
    joint.rotation = rotation_about(joint.axis, offset) * joint.rotation;
  joint.type = JointType::fixed;
  one.rpy.reset();
  one.viscous = one.coulomb = one.stiffness = 0;
}

std::string why_no_leader(const Robot& robot, const RobotCoupling& coupling) {
  if (coupling.leader < 0) return ", which is no joint here";
  if (coupling.leader == coupling.follower) return ", which is this joint itself";
  const int count = freedom(robot.joints[static_cast<std::size_t>(coupling.leader)].joint.type);
  return count == 0 ? ", which is fixed" : fmt::format(", which has {} coordinates", count);
}

void read_mimic(const XmlElement& element, const XmlElement& mimic, const ElementReader& read, Robot& robot) {
  RobotCoupling coupling;
  coupling.place = place_of(mimic);
  coupling.follower = robot.find_joint(*element.attribute("name"));
  const std::string leader = read.word(mimic, "joint");
  coupling.leader = robot.find_joint(leader);
  coupling.ratio = read.number(mimic, "multiplier", 1);
  coupling.offset = read.number(mimic, "offset", 0);
  if (leader.empty()) return;
  const std::string subject = fmt::format("joint {}", in_quotes(*element.attribute("name")));
  if (coupling.follower >= 0 && freedom(robot.joints[static_cast<std::size_t>(coupling.follower)].joint.type) == 0) {
    robot.findings.push_back({Level::note, place_of(element), "mimic", subject,
                              fmt::format("is fixed and mimics {}: nothing follows from that", in_quotes(leader))});
    return;
  }
  if (!has_one_coordinate(robot, coupling.leader) || coupling.leader == coupling.follower)
    return read.fault(mimic, "joint",
                      fmt::format("expected another joint with one coordinate, found {}{}", in_quotes(leader),
                                  why_no_leader(robot, coupling)));
  if (!has_one_coordinate(robot, coupling.follower))
    return read.fault(mimic, "", "only a joint with one coordinate can mimic");
  if (coupling.ratio == 0) {
    hold(robot.joints[static_cast<std::size_t>(coupling.follower)], coupling.offset);
    robot.findings.push_back(
        {Level::warning, place_of(element), "mimic", subject,
         fmt::format("mimics {} with the factor 0: held at {:g}", in_quotes(leader), coupling.offset)});
    return;
  }
  robot.findings.push_back({Level::note, place_of(element), "mimic", subject,
                            fmt::format("mimics {}: a coupling, ratio {:g}, offset {:g}", in_quotes(leader),
                                        coupling.ratio, coupling.offset)});
  robot.couplings.push_back(std::move(coupling));
}

}  // namespace

void read_urdf_mimics(const XmlElement& root, Faults& faults, Robot& robot) {
  const ElementReader read(faults);
  for (const XmlElement& element : root.children)
    if (const XmlElement* mimic = element.name == "joint" ? element.child("mimic") : nullptr)
      read_mimic(element, *mimic, read, robot);
}

void read_urdf_transmissions(const XmlElement& root, Robot& robot) {
  for (const XmlElement& part : root.children) {
    if (part.name != "transmission") continue;
    bool drives = false;
    for (const XmlElement& joint : part.children) {
      const std::string* name = joint.name == "joint" ? joint.attribute("name") : nullptr;
      const int found = name == nullptr ? -1 : robot.find_joint(*name);
      if (found < 0 || freedom(robot.joints[static_cast<std::size_t>(found)].joint.type) == 0) continue;
      robot.joints[static_cast<std::size_t>(found)].driven = robot.knows_motors = drives = true;
    }
    if (!drives) ++robot.ignored[part.name];
  }
}

}  // namespace balance::foreign
