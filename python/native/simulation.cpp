#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/control/closed_loop_run.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/motion/simulation/feasible_assembly_modes.hpp"
#include "balance/motion/simulation/prediction.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

namespace balance::python {
namespace {

/// Options of a run besides its spec.
struct RunRequest {
  std::string trajectory, controller, formulation;
  std::optional<long> samples;
  std::optional<double> duration;            ///< [s]
  std::optional<std::vector<double>> about;  ///< [m]
  bool poses = false;
  double settle = 0;  ///< [s]
  long steps = 0;
};

Vector3 point_of(const std::vector<double>& about, SpaceKind space) {
  const std::size_t axes = space == SpaceKind::planar ? 2 : 3;
  Vector3 point = Vector3::Zero();
  if (about.size() != axes) throw std::invalid_argument(fmt::format("about: must be {} numbers [m]", axes));
  for (std::size_t i = 0; i < axes; ++i) {
    if (!std::isfinite(about[i])) throw std::invalid_argument("about: must be finite");
    point[static_cast<Eigen::Index>(i)] = about[i];
  }
  return point;
}

Trajectory choose_trajectory(const Spec& spec, const RunRequest& request) {
  Trajectory trajectory = study::choose_trajectory(spec.study(), request.trajectory);
  if (request.samples) change_argument("samples", [&] { change_samples(trajectory, *request.samples); });
  if (request.duration) change_argument("duration", [&] { change_duration(trajectory, *request.duration); });
  if (request.about) trajectory.about = point_of(*request.about, spec.study().mechanism.space);
  return trajectory;
}

/// The same provenance as in the program, so that files are identical byte by byte.
files::Provenance describe(const Spec& spec, const Trajectory& trajectory, const RunRequest& request,
                           const std::string& controller) {
  return files::make_simulation_provenance(
      spec.study(), trajectory,
      {.spec_file = spec.file,
       .trajectory = trajectory.name,
       .samples = request.samples,
       .duration = request.duration,
       .about = request.about ? fmt::format("{}", fmt::join(*request.about, ",")) : "",
       .poses = request.poses,
       .formulation = request.formulation,
       .controller = controller,
       .settle = request.settle,
       .steps = request.steps});
}

std::shared_ptr<Run> run_request(const std::shared_ptr<Spec>& spec, const Trajectory& trajectory,
                                 const RunRequest& request, const std::optional<Controller>& controller,
                                 const py::object& progress) {
  auto run = std::make_shared<Run>();
  run->description = describe(*spec, trajectory, request, controller ? controller->name : "");
  run->source = spec->file;
  run->result = compute_in_background(
      [spec, trajectory, request, controller](BackgroundTask& task) {
        const Mechanism& mechanism = spec->study().mechanism;
        const auto report = [&](double fraction) { task.report_progress(fraction); };
        RunResult result =
            controller
                ? simulate_closed_loop(mechanism, trajectory, *controller,
                                       {.hold_time = request.settle, .max_steps = request.steps, .progress = report})
            : request.formulation == "natural" ? verification::simulate_natural(mechanism, trajectory, report)
                                               : simulate(mechanism, trajectory, report);
        if (!controller) simulation::add_measured_efforts(spec->study(), trajectory, result);
        if (!controller && result.outcome.status != MotionStatus::done)
          result.outcome.reason += simulation::describe_feasible_modes(mechanism, trajectory, result.outcome);
        if (request.poses && result.time.size() > 0)
          add_body_poses(trajectory::model_adaptations(mechanism, trajectory).mechanism, result);
        return result;
      },
      progress);
  return run;
}

std::shared_ptr<Run> simulate_spec(const std::shared_ptr<Spec>& spec, const RunRequest& request,
                                   const py::object& progress) {
  if (request.formulation != "tree" && request.formulation != "natural")
    throw std::invalid_argument("formulation: must be tree or natural, is '" + request.formulation + "'");
  if (request.formulation == "natural" && spec->study().mechanism.space == SpaceKind::spatial)
    throw std::invalid_argument(spec->file + " is spatial: the formulation natural is for planar mechanisms");
  return run_request(spec, choose_trajectory(*spec, request), request, std::nullopt, progress);
}

using NamedValues = std::vector<std::pair<std::string, double>>;

/// Options of a single state: `start` or `end` of the trajectory, the text of a pose in the spec's units, or
/// coordinates.
struct StateRequest {
  std::string trajectory, at;
  NamedValues joints, rates, accelerations;  ///< SI units
  double time = 0;                           ///< [s]
  std::vector<std::string> independent;
  std::optional<std::vector<double>> about;  ///< [m]
  bool poses = false;
};

/// Coordinates in the syntax of the program's options, in the spec's units of length and angle.
std::string format_coordinate_option(const NamedValues& numbers, const Study& study) {
  std::string text;
  for (const auto& [name, value] : numbers) {
    const auto& all = study.mechanism.coordinates;
    const auto one =
        std::find_if(all.begin(), all.end(), [&, &name = name](const Coordinate& c) { return c.name == name; });
    const bool length = one != all.end() && one->kind == CoordinateKind::length;
    text += fmt::format("{}{}={}", text.empty() ? "" : ",", name,
                        value / (length ? study.mechanism.units.length : study.mechanism.units.angle));
  }
  return text;
}

kinematics::ConfigurationResult find_state_configuration(const files::StateCommand& command,
                                                         const Trajectory* trajectory, const Study& study) {
  if (command.at != "start" && command.at != "end")
    return kinematics::solve_configuration(study.mechanism, specification::read_pose(command.at, study));
  if (trajectory == nullptr) throw std::invalid_argument("at: " + study.spec_file + " has no motion");
  return command.at == "start" ? simulation::find_start_configuration(study.mechanism, *trajectory)
                               : simulation::find_end_configuration(study.mechanism, *trajectory);
}

RunResult evaluate_requested_state(const Spec& spec, const files::StateCommand& command, const StateRequest& request) {
  const Study& study = spec.study();
  const bool moves = !study.trajectories.empty() || !request.trajectory.empty();
  const Trajectory* trajectory = moves ? &choose_trajectory(spec.study(), request.trajectory) : nullptr;
  kinematics::ConfigurationResult configuration = find_state_configuration(command, trajectory, study);
  if (configuration.outcome.status != MotionStatus::done) return {.outcome = std::move(configuration.outcome)};
  dynamics::SingleState state{std::move(configuration.coordinates), {}, {}, request.time};
  if (!command.rates.empty()) state.rates = specification::read_coordinate_rates(command.rates, "rates", study);
  if (!command.accelerations.empty())
    state.accelerations = specification::read_coordinate_rates(command.accelerations, "accelerations", study);
  InverseOptions options = dynamics::make_state_options(trajectory);
  options.independent = request.independent;
  if (request.about) options.about = point_of(*request.about, study.mechanism.space);
  RunResult result = evaluate_single_state(study.mechanism, state, options);
  if (request.poses && result.time.size() > 0) add_body_poses(study.mechanism, result);
  return result;
}

std::shared_ptr<Run> evaluate_spec_state(const std::shared_ptr<Spec>& spec, const StateRequest& request) {
  const Study& study = spec->study();
  const files::StateCommand command{
      .spec_file = spec->file,
      .at = request.joints.empty() ? request.at : format_coordinate_option(request.joints, study),
      .rates = format_coordinate_option(request.rates, study),
      .accelerations = format_coordinate_option(request.accelerations, study),
      .trajectory = request.trajectory,
      .independent = request.independent,
      .time = request.time,
      .about = request.about ? fmt::format("{}", fmt::join(*request.about, ",")) : "",
      .poses = request.poses};
  auto run = std::make_shared<Run>();
  run->description = describe_state(study, command);
  run->source = study.spec_file;
  run->result = compute_in_background(
      [spec, command, request](BackgroundTask&) { return evaluate_requested_state(*spec, command, request); });
  return run;
}

std::shared_ptr<Run> control_spec(const std::shared_ptr<Spec>& spec, const RunRequest& request,
                                  const py::object& progress) {
  if (!(request.settle >= 0 && request.settle <= trajectory::max_duration))
    throw std::invalid_argument(
        fmt::format("settle: must be from 0 to {} s, is {}", trajectory::max_duration, request.settle));
  if (request.steps < 0) throw std::invalid_argument("steps: must not be negative");
  const Trajectory trajectory = choose_trajectory(*spec, request);
  return run_request(spec, trajectory, request, choose_controller(spec->study(), request.controller), progress);
}

}  // namespace

void bind_moves(py::module_& m) {
  m.def(
      "simulate",
      [](const std::shared_ptr<Spec>& spec, const std::string& trajectory, std::optional<long> samples,
         std::optional<double> duration, std::optional<std::vector<double>> about, const std::string& formulation,
         bool poses, const py::object& progress) {
        const RunRequest request{.trajectory = trajectory,
                                 .formulation = formulation,
                                 .samples = samples,
                                 .duration = duration,
                                 .about = std::move(about),
                                 .poses = poses};
        return simulate_spec(spec, request, progress);
      },
      py::arg("spec"), py::arg("trajectory"), py::arg("samples"), py::arg("duration"), py::arg("about"),
      py::arg("formulation"), py::arg("poses"), py::arg("progress"));
  m.def(
      "observe",
      [](const std::shared_ptr<Spec>& spec, const std::string& trajectory, const std::string& at, NamedValues joints,
         NamedValues rates, NamedValues accelerations, double time, std::vector<std::string> independent,
         std::optional<std::vector<double>> about, bool poses) {
        return evaluate_spec_state(spec, {trajectory, at, std::move(joints), std::move(rates), std::move(accelerations),
                                          time, std::move(independent), std::move(about), poses});
      },
      py::arg("spec"), py::arg("trajectory"), py::arg("at"), py::arg("joints"), py::arg("rates"),
      py::arg("accelerations"), py::arg("time"), py::arg("independent"), py::arg("about"), py::arg("poses"));
  m.def(
      "control",
      [](const std::shared_ptr<Spec>& spec, const std::string& controller, const std::string& trajectory,
         std::optional<long> samples, std::optional<double> duration, std::optional<std::vector<double>> about,
         double settle, long steps, bool poses, const py::object& progress) {
        const RunRequest request{.trajectory = trajectory,
                                 .controller = controller,
                                 .formulation = "tree",
                                 .samples = samples,
                                 .duration = duration,
                                 .about = std::move(about),
                                 .poses = poses,
                                 .settle = settle,
                                 .steps = steps};
        return control_spec(spec, request, progress);
      },
      py::arg("spec"), py::arg("controller"), py::arg("trajectory"), py::arg("samples"), py::arg("duration"),
      py::arg("about"), py::arg("settle"), py::arg("steps"), py::arg("poses"), py::arg("progress"));
}

}  // namespace balance::python
