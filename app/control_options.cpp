#include "control_options.hpp"

#include "failure.hpp"
#include "value_check.hpp"

#include "balance/base/nearest.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <limits>

namespace balance::app {

void add_control_options(CLI::App& parser, ControlCommandOptions& o) {
  add_run_options(parser, o.run);
  CLI::Option* controller =
      parser.add_option("-c,--controller", o.controller, "which controller; the first of the spec if not given");
  controller->type_name("NAME");
  parser.add_option("--settle", o.settle, "hold the last pose so much longer, in seconds")
      ->type_name("T")
      ->check(number_range_validator(0, max_duration));
  parser.add_option("--steps", o.steps, "how many steps the integration may take before the run is given up")
      ->type_name("N")
      ->check(integer_range_validator(1));
}

Controller choose_controller(const ControlCommandOptions& options, const Study& study) {
  return find_controller(options.controller, study);
}

Provenance describe(const ControlCommandOptions& options, const Study& study, const Trajectory& trajectory,
                    const Controller& controller) {
  const SimulateOptions& o = options.run;
  return make_simulation_provenance(study, trajectory,
                                    {.spec_file = o.spec.spec,
                                     .trajectory = trajectory.name,
                                     .samples = o.samples,
                                     .duration = o.duration,
                                     .about = o.about,
                                     .set = o.spec.overrides,
                                     .compress = o.compress,
                                     .poses = o.poses,
                                     .controller = controller.name,
                                     .settle = options.settle,
                                     .steps = options.steps});
}

Controller find_controller(const std::string& name, const Study& study) {
  std::vector<std::string> names;
  for (const Controller& controller : study.controllers) {
    names.push_back(controller.name);
    if (controller.name == name) return controller;
  }
  if (!name.empty())
    throw UsageError(fmt::format("{} has no controller {}, only {}{}", study.spec_file, quote_for_message(name),
                                 fmt::join(names, ", "), append_nearest_name(name, names)));
  // The built-in ones stand behind those of the spec.
  const bool listed = study.controllers.size() > built_in_controllers().size() ||
                      study.controllers.front().name != built_in_controllers().front().name;
  if (listed) return study.controllers.front();
  return find_controller(controller_type_name(ControllerType::computed_torque), study);
}

}  // namespace balance::app
