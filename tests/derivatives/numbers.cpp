#include "numbers.hpp"

#include <algorithm>

namespace gradients {

using namespace balance;
using namespace balance::derivatives;

namespace {

class List {
 public:
  explicit List(const Mechanism& mechanism) : length_(characteristic_length(mechanism)) {}

  template <class Place>
  void add(const std::string& name, double scale, Place place) {
    if (scale > 0)
      all.push_back({name, scale, [place](Mechanism& m) -> double& { return place(m); },
                     [place](MechanismOf<DualNumber>& m) -> DualNumber& { return place(m); }});
  }
  template <class Place>
  void add_place(const std::string& name, int dimensions, Place place) {
    for (int i = 0; i < dimensions; ++i)
      add(
          name + "." + "xyz"[i], length_, [ place, i ](auto& m) -> auto& { return place(m)[i]; });
  }

  std::vector<Number> all;

 private:
  double length_;
};

}  // namespace

std::vector<Number> some_numbers(const Mechanism& mechanism, std::size_t most, std::mt19937& random) {
  List list(mechanism);
  const bool planar = mechanism.space == SpaceKind::planar;
  const int dimensions = planar ? 2 : 3;
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    const Body& body = mechanism.bodies[b];
    list.add(
        body.name + ".mass", body.mass, [b](auto& m) -> auto& { return m.bodies[b].mass; });
    list.add_place(
        body.name + ".com", dimensions, [b](auto& m) -> auto& { return m.bodies[b].com; });
    list.add(
        body.name + ".Izz", body.inertia(2, 2), [b](auto& m) -> auto& { return m.bodies[b].inertia(2, 2); });
  }
  for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
    const std::string& name = mechanism.joints[j].name;
    list.add_place(
        name + ".first", dimensions, [j](auto& m) -> auto& { return m.joints[j].point_first; });
    list.add_place(
        name + ".second", dimensions, [j](auto& m) -> auto& { return m.joints[j].point_second; });
  }
  for (std::size_t i = 0; i < mechanism.attachments.size(); ++i) {
    const Attachment& extra = mechanism.attachments[i];
    list.add(
        extra.name + ".mass", extra.mass, [i](auto& m) -> auto& { return m.attachments[i].mass; });
    list.add_place(
        extra.name + ".at", dimensions, [i](auto& m) -> auto& { return m.attachments[i].position; });
  }
  for (std::size_t i = 0; i < mechanism.discs.size(); ++i)
    list.add(
        mechanism.discs[i].name + ".ratio", 1, [i](auto& m) -> auto& { return m.discs[i].ratio; });
  for (std::size_t i = 0; i < mechanism.discs.size(); ++i)
    if (mechanism.discs[i].follows.terms.size() > 1)
      list.add(
          mechanism.discs[i].name + ".follows", 1, [i](auto& m) -> auto& { return m.discs[i].follows.terms[1].ratio; });
  for (std::size_t i = 0; i < mechanism.couplings.size(); ++i)
    list.add(
        "coupling.ratio", 1, [i](auto& m) -> auto& { return m.couplings[i].ratio; });
  for (std::size_t i = 0; i < mechanism.springs.size(); ++i) {
    const Spring& spring = mechanism.springs[i];
    list.add(
        spring.name + ".stiffness", spring.stiffness, [i](auto& m) -> auto& { return m.springs[i].stiffness; });
    if (spring.is_joint_spring()) {
      list.add(
          spring.name + ".preload", 1, [i](auto& m) -> auto& { return m.springs[i].preload; });
      continue;
    }
    list.add(
        spring.name + ".free", spring.free_length, [i](auto& m) -> auto& { return m.springs[i].free_length; });
    list.add_place(
        spring.name + ".first", dimensions, [i](auto& m) -> auto& { return m.springs[i].point_first; });
  }
  for (std::size_t i = 0; i < mechanism.friction.size(); ++i)
    list.add(
        "friction.viscous", 1, [i](auto& m) -> auto& { return m.friction[i].viscous; });
  for (std::size_t i = 0; i < mechanism.loads.size(); ++i)
    list.add(
        mechanism.loads[i].name + ".x", 1, [i](auto& m) -> auto& { return m.loads[i].force[0].x(); });
  list.add(
      "gravity.y", 1, [](auto& m) -> auto& { return m.gravity.y(); });
  if (mechanism.tool)
    list.add_place(
        "tool", dimensions, [](auto& m) -> auto& { return m.tool->position; });
  std::shuffle(list.all.begin(), list.all.end(), random);
  if (list.all.size() > most) list.all.resize(most);
  return list.all;
}

}  // namespace gradients
