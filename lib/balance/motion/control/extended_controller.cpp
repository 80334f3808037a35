#include "balance/motion/control/extended_controller.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"

#include <limits>
#include <stdexcept>
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

[[noreturn]] void refuse(const std::string& what, const std::string& hint) {
  throw std::invalid_argument(what +
                              " of a controller says nothing of counterweights that move with the payload: " + hint);
}

/// Refuses numbers whose unit is that of an actuator.
void check_gains(const Controller& controller) {
  using enum study::ControllerType;
  const std::string hint = "leave it out, so that all gains follow from the motion";
  if (!controller.speeds.empty()) refuse("'speeds'", "leave it out");
  if (controller.type == pd && controller.kp.size() > 0) refuse("'kp'", hint);
  if (controller.type == pd && controller.kd.size() > 0) refuse("'kd'", hint);
  if (controller.type == sliding_mode && controller.switching_gain.size() > 0) refuse("'k'", hint);
  if (controller.type == sliding_mode && controller.boundary_layer.size() > 0)
    refuse("'boundary_layer'", "use 'extended-sliding-mode', whose layer is for all coordinates");
  if (controller.type == open_loop && !controller.efforts.time.empty())
    refuse("the efforts", "leave them out, and the model's efforts along the desired motion act");
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
  if (controller.model) {
    if (controller.model->attachments.size() != mechanism.attachments.size())
      refuse("the model", "let it keep these counterweights");
    controller.model = trajectory::model_adaptations(*controller.model, trajectory).mechanism;
  }
  return controller;
}

}  // namespace balance::control
