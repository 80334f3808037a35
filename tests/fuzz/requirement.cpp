#include "balance/interface/comparison/requirement.hpp"

#include "targets.hpp"

#include "balance/interface/specification/read_spec.hpp"

namespace balance::fuzz {

namespace {

const Study& arm() {
  static const Study study = read_spec(R"(space: planar
ground: {points: {O: [0, 0]}}
bodies: {link: {mass: {free: [1, 2]}, com: [0, 0], inertia: 1, points: {A: [1, 0]}}}
joints: {J: {type: revolute, connects: [ground.O, link.origin]}}
actuators: [J]
tool: link.A
motion: {duration: 1, from: {joints: {J: 0}}, to: {joints: {J: 1}}}
)",
                                       "arm.yaml");
  return study;
}

comparison::MetricTable table(const char* name) {
  return {name, {{"torque", "N m", 1, 2, 3, 4, 5}, {"shaking_force", "N", 0, 0, 0, 0, 0}}, 7};
}

}  // namespace

void requirement(std::string_view bytes) {
  const std::string text(bytes.substr(0, bytes.find('\n')));
  const comparison::RunNames names{{"base", "other", "3"}, "base"};
  try {
    const comparison::Requirement read = parse_requirement(text, names);
    comparison::check_quantities(read, {"torque", "shaking_force"});
    comparison::judge_requirement(read, {table("base"), table("other"), table("3")}, 1);
  } catch (const comparison::RequirementError& wrong) {
    demand(wrong.column >= 1 && wrong.column <= text.size() + 1, "a column outside of the requirement");
  }
  if (text.size() < bytes.size()) {
    complains_well([&] { specification::read_objective(std::string(bytes.substr(text.size() + 1)), arm()); });
  }
}

}  // namespace balance::fuzz
