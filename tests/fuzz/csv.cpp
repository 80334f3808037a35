#include "memory_file.hpp"
#include "targets.hpp"

#include "balance/interface/specification/read_spec.hpp"

namespace balance::fuzz {

namespace {

std::string spec_with(const std::string& motion) {
  return R"(space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: 1, com: [0, 0], inertia: 1, points: {A: [1, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.origin]}}
actuators: [J]
tool: link.A
)" + motion;
}

}  // namespace

void csv(std::string_view bytes) {
  const MemoryFile file(bytes);
  const std::string path = "{file: " + file.path() + "}";
  const std::string all[] = {
      "trajectories: {t: {drive: joints, path: " + path + "}}",
      "trajectories: {t: {drive: tool, path: " + path + "}}",
      "loads: {l: {on: link, file: " + file.path() + "}}",
  };
  for (const std::string& use : all) complains_well([&] { read_spec(spec_with(use), "s.yaml"); });
}

}  // namespace balance::fuzz
