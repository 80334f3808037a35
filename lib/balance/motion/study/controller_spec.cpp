#include "balance/motion/study/controller_spec.hpp"

#include <numbers>

namespace balance::study {

namespace {

constexpr ControllerType controller_types[] = {ControllerType::none,         ControllerType::open_loop,
                                               ControllerType::pd,           ControllerType::computed_torque,
                                               ControllerType::sliding_mode, ControllerType::extended_sliding_mode};

}  // namespace

double Controller::natural_frequency() const { return 2 * std::numbers::pi * bandwidth.value_or(0.01 / period); }

const char* controller_type_name(ControllerType type) {
  switch (type) {
    case ControllerType::none: return "none";
    case ControllerType::open_loop: return "open-loop";
    case ControllerType::pd: return "pd";
    case ControllerType::computed_torque: return "computed-torque";
    case ControllerType::sliding_mode: return "sliding-mode";
    case ControllerType::extended_sliding_mode: return "extended-sliding-mode";
  }
  return "";
}

std::string why_not_a_rate(const model::GeneralisedSpeed& speed, SpaceKind space) {
  using enum model::GeneralisedSpeedTerm::Kind;
  for (const model::GeneralisedSpeedTerm& term : speed.terms) {
    if (term.pose_factor) return "its factors depend on the pose";
    if (term.kind == velocity_body || term.kind == angular_velocity_body)
      return "it has components along axes that turn with a body";
    if (term.kind == angular_velocity && space == SpaceKind::spatial)
      return "it has components of an angular velocity in space";
  }
  return "";
}

std::string why_no_speeds(ControllerType type) {
  switch (type) {
    case ControllerType::none:
    case ControllerType::open_loop: return std::string(controller_type_name(type)) + " controls no errors";
    case ControllerType::extended_sliding_mode:
      return "the redundant quantities of extended-sliding-mode are the coordinates of the spanning tree, in whose "
             "inertia it projects";
    case ControllerType::pd:
    case ControllerType::computed_torque:
    case ControllerType::sliding_mode: return "";
  }
  return "";
}

std::vector<std::string> controller_type_names() {
  std::vector<std::string> names;
  for (const ControllerType type : controller_types) names.emplace_back(controller_type_name(type));
  return names;
}

std::vector<Controller> built_in_controllers() {
  std::vector<Controller> controllers;
  for (const ControllerType type : controller_types) {
    controllers.emplace_back().name = controller_type_name(type);
    controllers.back().type = type;
  }
  return controllers;
}

}  // namespace balance::study
