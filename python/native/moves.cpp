#include "native.hpp"
#include "patience.hpp"

#include "balance/analysis/control.hpp"
#include "balance/base/error.hpp"
#include "balance/result/body_poses.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/simulation/simulate_natural.hpp"
#include "balance/spec/limits.hpp"
#include "balance/write/run_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <stdexcept>
#include <variant>

namespace balance::python {
namespace {

/// What a run is asked for besides its spec.
struct Wish {
  std::string trajectory, controller, formulation;
  std::optional<long> samples;
  std::optional<double> duration;            ///< [s]
  std::optional<std::vector<double>> about;  ///< [m]
  bool poses = false;
  double settle = 0;  ///< [s]
  long steps = 0;
};

void change_duration(Trajectory& trajectory, double duration) {
  if (!(duration > 0) || !std::isfinite(duration))
    throw std::invalid_argument("duration: must be a positive number of seconds");
  if (trajectory.law.kind == LawKind::fastest)
    throw std::invalid_argument("duration: does not go with '" + trajectory.name + "', whose law finds it");
  if (std::holds_alternative<TablePath>(trajectory.path) && !is_searched(trajectory.law.kind))
    throw std::invalid_argument("duration: does not go with '" + trajectory.name + "': its table has its own times");
  trajectory.duration = duration;
}

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

Trajectory choose_trajectory(const Spec& spec, const Wish& wish) {
  Trajectory trajectory = spec.trajectory(wish.trajectory);
  if (wish.samples && (*wish.samples < 2 || *wish.samples > most_samples))
    throw std::invalid_argument(fmt::format("samples: must be from 2 to {}, is {}", most_samples, *wish.samples));
  if (wish.samples) trajectory.samples = *wish.samples;
  if (wish.duration) change_duration(trajectory, *wish.duration);
  if (wish.about) trajectory.about = point_of(*wish.about, spec.study().mechanism.space);
  return trajectory;
}

/// As the program describes the same run, so that files have the same bytes.
FileDescription describe(const Spec& spec, const Trajectory& trajectory, const Wish& wish,
                         const std::string& controller) {
  return describe_simulation(spec.study(), trajectory,
                             {.spec_file = spec.file,
                              .trajectory = trajectory.name,
                              .samples = wish.samples,
                              .duration = wish.duration,
                              .about = wish.about ? fmt::format("{}", fmt::join(*wish.about, ",")) : "",
                              .set = spec.set(),
                              .poses = wish.poses,
                              .formulation = wish.formulation,
                              .controller = controller,
                              .settle = wish.settle,
                              .steps = wish.steps});
}

std::shared_ptr<Run> run_patiently(const std::shared_ptr<Spec>& spec, const Trajectory& trajectory, const Wish& wish,
                                   const std::optional<Controller>& controller, const py::object& progress) {
  auto run = std::make_shared<Run>();
  run->description = describe(*spec, trajectory, wish, controller ? controller->name : "");
  run->result = patiently(
      [spec, trajectory, wish, controller](Errand& errand) {
        const Mechanism& mechanism = spec->study().mechanism;
        const auto told = [&](double part) { errand.tell(part); };
        Result result = controller                      ? control(mechanism, trajectory, *controller,
                                                                  {.settle = wish.settle, .most_steps = wish.steps, .progress = told})
                        : wish.formulation == "natural" ? simulate_natural(mechanism, trajectory, told)
                                                        : simulate(mechanism, trajectory, told);
        if (wish.poses && result.time.size() > 0) add_body_poses(mechanism, result);
        return result;
      },
      progress);
  return run;
}

std::shared_ptr<Run> simulate_spec(const std::shared_ptr<Spec>& spec, const Wish& wish, const py::object& progress) {
  if (wish.formulation != "tree" && wish.formulation != "natural")
    throw std::invalid_argument("formulation: must be tree or natural, is '" + wish.formulation + "'");
  if (wish.formulation == "natural" && spec->study().mechanism.space == SpaceKind::spatial)
    throw std::invalid_argument(spec->file + " is spatial: the formulation natural is for planar mechanisms");
  return run_patiently(spec, choose_trajectory(*spec, wish), wish, std::nullopt, progress);
}

std::shared_ptr<Run> control_spec(const std::shared_ptr<Spec>& spec, const Wish& wish, const py::object& progress) {
  if (!(wish.settle >= 0) || !std::isfinite(wish.settle))
    throw std::invalid_argument("settle: must be a number of seconds that is not negative");
  if (wish.steps < 0) throw std::invalid_argument("steps: must not be negative");
  const Trajectory trajectory = choose_trajectory(*spec, wish);
  return run_patiently(spec, trajectory, wish, spec->controller(wish.controller), progress);
}

}  // namespace

void bind_moves(py::module_& m) {
  m.def(
      "simulate",
      [](const std::shared_ptr<Spec>& spec, const std::string& trajectory, std::optional<long> samples,
         std::optional<double> duration, std::optional<std::vector<double>> about, const std::string& formulation,
         bool poses, const py::object& progress) {
        const Wish wish{.trajectory = trajectory,
                        .formulation = formulation,
                        .samples = samples,
                        .duration = duration,
                        .about = std::move(about),
                        .poses = poses};
        return simulate_spec(spec, wish, progress);
      },
      py::arg("spec"), py::arg("trajectory"), py::arg("samples"), py::arg("duration"), py::arg("about"),
      py::arg("formulation"), py::arg("poses"), py::arg("progress"));
  m.def(
      "control",
      [](const std::shared_ptr<Spec>& spec, const std::string& controller, const std::string& trajectory,
         std::optional<long> samples, std::optional<double> duration, std::optional<std::vector<double>> about,
         double settle, long steps, bool poses, const py::object& progress) {
        const Wish wish{.trajectory = trajectory,
                        .controller = controller,
                        .formulation = "tree",
                        .samples = samples,
                        .duration = duration,
                        .about = std::move(about),
                        .poses = poses,
                        .settle = settle,
                        .steps = steps};
        return control_spec(spec, wish, progress);
      },
      py::arg("spec"), py::arg("controller"), py::arg("trajectory"), py::arg("samples"), py::arg("duration"),
      py::arg("about"), py::arg("settle"), py::arg("steps"), py::arg("poses"), py::arg("progress"));
}

}  // namespace balance::python
