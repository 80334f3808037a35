#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/tolerance_sections.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

/// Result of a tolerance analysis; immutable.
struct ToleranceAnswer {
  reports::ToleranceReportData view;
  files::Provenance description;
  MotionOutcome outcome;
  files::TextOptions text_options = {};
  std::string source = {};  ///< file of the spec
};

/// Options of the analysis. Without a trajectory: efforts at rest.
struct ToleranceRequest {
  std::optional<Trajectory> trajectory;
  std::vector<std::string> of;
  tolerance::MonteCarloOptions draws;
};

void require_quantities(const std::vector<std::string>& of, const Mechanism& mechanism) {
  const std::vector<std::string> names = results::list_metric_names(mechanism);
  for (const std::string& name : of)
    if (std::find(names.begin(), names.end(), results::resolve_quantity_name(name, names)) == names.end())
      throw std::invalid_argument(fmt::format("of {}: expected {}{}", quote_for_message(name), join_alternatives(names),
                                              append_nearest_name(name, names)));
}

Trajectory trajectory_of(const Spec& spec, const std::string& name, std::optional<long> samples) {
  Trajectory trajectory = choose_trajectory(spec.study(), name);
  if (samples) change_argument("samples", [&] { change_samples(trajectory, *samples); });
  return trajectory;
}

void analyse_along_trajectory(const specification::TolerancedDesignSpace& toleranced, const ToleranceRequest& request,
                              BackgroundTask& task, ToleranceAnswer& result) {
  const Trajectory& trajectory = *request.trajectory;
  tolerance::ToleranceReport report =
      tolerance::analyse_tolerance(toleranced.space, toleranced.tolerances, trajectory, request.of);
  result.outcome = report.outcome;
  if (report.outcome.status != MotionStatus::done) return;
  result.view.trajectory = trajectory.name;
  result.view.report = std::move(report);
  if (request.draws.count == 0) return;
  const Tolerances drawn =
      remove_incompatible_parameters(toleranced.tolerances, result.view.report->incompatible_parameters);
  result.view.sampling = sample_tolerance(toleranced.space, drawn, trajectory, request.of, request.draws,
                                          [&](double fraction) { task.report_progress(fraction); });
}

void analyse_at_rest(const specification::TolerancedDesignSpace& toleranced, ToleranceAnswer& result) {
  result.view.at_rest = tolerance::analyse_static_tolerance(toleranced.space, toleranced.tolerances);
  result.outcome = result.view.at_rest->outcome;
}

std::shared_ptr<ToleranceAnswer> compute_tolerance_data(const Spec& spec, const ToleranceRequest& request,
                                                        BackgroundTask& task) {
  const specification::TolerancedDesignSpace toleranced = read_toleranced_space(spec.text, spec.file, spec.read);
  const SourceLocation location{.file = spec.file, .key = "tolerances"};
  if (toleranced.tolerances.empty())
    throw SpecError({.place = location, .message = "missing: expected the numbers that may deviate"});
  auto result = std::make_shared<ToleranceAnswer>();
  result->text_options = files::make_design_text_options(spec.study());
  result->source = spec.file;
  result->view.mechanism = spec.study().mechanism.name;
  result->view.numbers = toleranced.tolerances;
  result->view.draws = request.draws;
  try {
    request.trajectory ? analyse_along_trajectory(toleranced, request, task, *result)
                       : analyse_at_rest(toleranced, *result);
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = location, .message = error.what()});
  }
  return result;
}

std::shared_ptr<ToleranceAnswer> find_tolerance(const std::shared_ptr<Spec>& spec, const std::string& trajectory,
                                                const std::vector<std::string>& of, std::optional<long> samples,
                                                long draws, std::optional<std::uint64_t> seed, bool at_rest,
                                                const py::object& progress) {
  if (at_rest && (!trajectory.empty() || draws != 0))
    throw std::invalid_argument("at_rest: cannot be combined with a trajectory or monte_carlo");
  if (seed && draws == 0) throw std::invalid_argument("seed: applies only with monte_carlo");
  if (draws != 0 && (draws < 2 || draws > tolerance::max_tolerance_draws))
    throw std::invalid_argument(
        fmt::format("monte_carlo: must be 0 or from 2 to {}, is {}", tolerance::max_tolerance_draws, draws));
  require_quantities(of, spec->study().mechanism);
  ToleranceRequest request{.trajectory = std::nullopt, .of = of, .draws = {draws, seed.value_or(1)}};
  if (!at_rest) request.trajectory = trajectory_of(*spec, trajectory, samples);
  auto result = compute_in_background(
      [spec, request](BackgroundTask& task) { return compute_tolerance_data(*spec, request, task); }, progress);
  if (request.trajectory)
    result->description =
        reports::make_tolerance_provenance(spec->study(), *request.trajectory, {.of = of, .samples = samples});
  return result;
}

}  // namespace

void bind_tolerance(py::module_& m) {
  m.def("tolerance", &find_tolerance, py::arg("spec"), py::arg("trajectory"), py::arg("of"), py::arg("samples"),
        py::arg("monte_carlo"), py::arg("seed"), py::arg("at_rest"), py::arg("progress"));
  py::class_<ToleranceAnswer, std::shared_ptr<ToleranceAnswer>>(m, "Tolerance")
      .def_property_readonly("status", [](const ToleranceAnswer& one) { return name_of(one.outcome.status); })
      .def_property_readonly("reason", [](const ToleranceAnswer& one) { return one.outcome.reason; })
      .def_property_readonly("end", [](const ToleranceAnswer& one) { return one.outcome.time; })
      .def("json", [](const ToleranceAnswer& one) { return tolerance_json(one.view); })
      .def("text", [](const ToleranceAnswer& one) { return tolerance_text(one.view, one.text_options); })
      .def(
          "write",
          [](const ToleranceAnswer& one, const std::string& path, bool force) {
            files::WriteOptions options;
            options.existing = force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
            options.is_cancelled = [] { return PyErr_CheckSignals() != 0; };
            check_overwrites_no_source(path, one.description.spec_text, one.source);
            write_tolerance(path, one.view, one.description, options);
          },
          py::arg("path"), py::arg("force"));
}

}  // namespace balance::python
