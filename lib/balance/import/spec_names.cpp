#include "balance/import/spec_names.hpp"

#include "balance/base/nearest.hpp"
#include "balance/import/names.hpp"

#include <fmt/format.h>

namespace balance::foreign {

namespace {

/// Every joint, spring and frame has a point of its own on each of its bodies, but for what is at the body's origin.
class PointNames {
 public:
  PointNames(const ForeignModel& robot, GeneratedNames& names)
      : robot_(robot), names_(names), taken_(robot.bodies.size(), NameAllocator({"origin"})) {}

  void run() {
    names_.points.resize(robot_.bodies.size());
    names_.ends.resize(robot_.joints.size());
    for (std::size_t j = 0; j < robot_.joints.size(); ++j) {
      const Joint& joint = robot_.joints[j].joint;
      if (!robot_.joints[j].is_active) continue;
      names_.ends[j].first = add(joint.first, names_.joints[j], joint.point_first);
      names_.ends[j].second = add(joint.second, names_.joints[j], joint.point_second);
    }
    for (const Spring& spring : robot_.springs)
      names_.spring_ends.emplace_back(add(spring.first, spring.name, spring.point_first),
                                      add(spring.second, spring.name, spring.point_second));
    for (std::size_t b = 0; b < robot_.bodies.size(); ++b)
      if (robot_.bodies[b].is_active)
        for (const NamedPoint& frame : robot_.bodies[b].body.points)
          names_.points[b].push_back({taken_[b].allocate(frame.name), frame.position});
  }

 private:
  std::string add(int body, const std::string& wanted, const Vector3& position) {
    const auto b = static_cast<std::size_t>(body);
    if (position.isZero(0)) return names_.bodies[b] + ".origin";
    names_.points[b].push_back({taken_[b].allocate(wanted), position});
    return names_.bodies[b] + "." + names_.points[b].back().name;
  }

  const ForeignModel& robot_;
  GeneratedNames& names_;
  std::vector<NameAllocator> taken_;
};

}  // namespace

GeneratedNames spec_names(const ForeignModel& robot) {
  GeneratedNames names;
  const auto remember = [&](const char* kind, const std::string& before, const std::string& after) {
    if (before != after) names.renamed.emplace_back(fmt::format("{} {}", kind, quote_for_message(before)), after);
  };
  NameAllocator bodies({"ground"}), joints({});
  names.bodies.assign(robot.bodies.size(), "ground");
  for (std::size_t b = 1; b < robot.bodies.size(); ++b) {
    if (!robot.bodies[b].is_active) continue;
    names.bodies[b] = bodies.allocate(robot.bodies[b].body.name);
    remember("body", robot.bodies[b].body.name, names.bodies[b]);
  }
  names.joints.resize(robot.joints.size());
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    if (!robot.joints[j].is_active) continue;
    names.joints[j] = joints.allocate(robot.joints[j].joint.name);
    remember("joint", robot.joints[j].joint.name, names.joints[j]);
  }
  PointNames(robot, names).run();
  return names;
}

}  // namespace balance::foreign
