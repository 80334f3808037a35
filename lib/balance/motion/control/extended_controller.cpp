#include "balance/motion/control/extended_controller.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"
#include "balance/motion/control/controller_error.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace balance::control {

namespace {

void extend(VectorX& values, Eigen::Index count, double value) {
  if (values.size() == 0) return;
  values.conservativeResize(values.size() + count);
  values.tail(count).setConstant(value);
}

void extend_by_largest(VectorX& gains, Eigen::Index count) {
  if (gains.size() > 0) extend(gains, count, numerics::max_coefficient(gains));
}

[[noreturn]] void refuse(const std::string& key, const std::string& what, const std::string& hint) {
  throw ControllerError(key,
                        what + " of a controller says nothing of counterweights that move with the payload: " + hint);
}

/// Refuses numbers whose unit is that of an actuator.
void check_gains(const Controller& controller) {
  using enum study::ControllerType;
  const std::string hint = "leave it out, so that all gains follow from the motion";
  if (!controller.speeds.empty()) refuse("speeds", "'speeds'", "leave it out");
  if (controller.type == pd && controller.kp.size() > 0) refuse("kp", "'kp'", hint);
  if (controller.type == pd && controller.kd.size() > 0) refuse("kd", "'kd'", hint);
  if (controller.type == sliding_mode && controller.switching_gain.size() > 0) refuse("k", "'k'", hint);
  if (controller.type == sliding_mode && controller.boundary_layer.size() > 0)
    refuse("switching", "'boundary_layer'", "use 'extended-sliding-mode', whose layer is for all coordinates");
  if (controller.type == open_loop && !controller.efforts.time.empty())
    refuse("", "the efforts", "leave them out, and the model's efforts along the desired motion act");
}

/// The trajectory with the places that its counterweights have among the model's elements, some of which may be missing.
Trajectory find_adaptations(const Mechanism& model, const Mechanism& mechanism, Trajectory trajectory) {
  for (trajectory::Adaptation& adaptation : trajectory.adaptations) {
    const std::string& name = mechanism.attachments[static_cast<std::size_t>(adaptation.attachment)].name;
    const auto found = std::find_if(model.attachments.begin(), model.attachments.end(),
                                    [&](const Attachment& one) { return one.name == name; });
    if (found == model.attachments.end())
      throw ControllerError("model.without", "the model of a controller needs counterweight '" + name +
                                                 "', whose motor it drives: let it keep this counterweight");
    adaptation.attachment = static_cast<int>(found - model.attachments.begin());
  }
  return trajectory;
}

}  // namespace

Controller extend_controller(Controller controller, const Mechanism& mechanism, const Trajectory& trajectory) {
  check_gains(controller);
  const auto count = static_cast<Eigen::Index>(trajectory.adaptations.size());
  if (controller.type == study::ControllerType::computed_torque) {
    extend_by_largest(controller.kp, count);
    extend_by_largest(controller.kd, count);
  }
  if (controller.type == study::ControllerType::sliding_mode) extend_by_largest(controller.lambda, count);
  extend(controller.torque_limit, count, std::numeric_limits<double>::infinity());
  extend(controller.measurement.position_step, count, 0);
  extend(controller.measurement.position_noise, count, 0);
  extend(controller.measurement.velocity_noise, count, 0);
  if (controller.model)
    controller.model =
        trajectory::model_adaptations(*controller.model, find_adaptations(*controller.model, mechanism, trajectory))
            .mechanism;
  return controller;
}

}  // namespace balance::control
