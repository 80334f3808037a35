#pragma once
/// What the user asks of `balance control`: what `balance simulate` is asked, and a controller.

#include "simulate_options.hpp"

namespace balance::app {

struct ControlCommandOptions {
  SimulateOptions run;
  std::string controller;  ///< empty: the first of the spec, or computed torque
  double settle = 0;       ///< [s]
  long steps = 0;          ///< that the integration may take; 0: the default
};

void add_control_options(CLI::App& parser, ControlCommandOptions& options);

/// The study's controller of this name; without a name the spec's first or, if it lists none, computed torque.
/// @throws UsageError if there is none of that name
Controller find_controller(const std::string& name, const Study& study);

/// The controller that the options name.
/// @throws UsageError if there is none of that name
Controller choose_controller(const ControlCommandOptions& options, const Study& study);

Provenance describe(const ControlCommandOptions& options, const Study& study, const Trajectory& trajectory,
                    const Controller& controller);

}  // namespace balance::app
