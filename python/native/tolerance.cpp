#include "native.hpp"
#include "patience.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/motion/names.hpp"
#include "balance/motion/timing_bounds.hpp"
#include "balance/present/tolerance_hdf5.hpp"
#include "balance/present/tolerance_json.hpp"
#include "balance/present/tolerance_text.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/tracks.hpp"
#include "balance/spec/read_tolerances.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

/// What is told of a spec whose numbers may be off, never changed.
struct Told {
  ToleranceView view;
  FileDescription description;
  MotionOutcome outcome;
  std::string source = {};  ///< the spec's file
};

/// What is asked for. No trajectory: efforts at rest.
struct ToleranceWish {
  std::optional<Trajectory> trajectory;
  std::vector<std::string> of;
  ToleranceDraws draws;
};

void require_quantities(const std::vector<std::string>& of, const Mechanism& mechanism) {
  const std::vector<std::string> names = figure_names(mechanism);
  for (const std::string& name : of)
    if (std::find(names.begin(), names.end(), known_quantity(name, names)) == names.end())
      throw std::invalid_argument(
          fmt::format("of {}: expected {}{}", in_quotes(name), one_of(names), nearest_hint(name, names)));
}

Trajectory trajectory_of(const Spec& spec, const std::string& name, std::optional<long> samples) {
  Trajectory trajectory = spec.trajectory(name);
  if (samples) change_argument("samples", [&] { change_samples(trajectory, *samples); });
  return trajectory;
}

void look_along(const TolerancedSpace& toleranced, const ToleranceWish& wish, Errand& errand, Told& told) {
  const Trajectory& trajectory = *wish.trajectory;
  ToleranceReport report = tolerance(toleranced.space, toleranced.tolerances, trajectory, wish.of);
  told.outcome = report.outcome;
  if (report.outcome.status != MotionStatus::done) return;
  told.view.trajectory = trajectory.name;
  told.view.report = std::move(report);
  if (wish.draws.count == 0) return;
  const Tolerances drawn = without_openings(toleranced.tolerances, told.view.report->openings);
  told.view.sampling = sample_tolerance(toleranced.space, drawn, trajectory, wish.of, wish.draws,
                                        [&](double part) { errand.tell(part); });
}

void look_at_rest(const TolerancedSpace& toleranced, Told& told) {
  told.view.at_rest = tolerance_at_rest(toleranced.space, toleranced.tolerances);
  told.outcome = told.view.at_rest->outcome;
}

std::shared_ptr<Told> look(const Spec& spec, const ToleranceWish& wish, Errand& errand) {
  const TolerancedSpace toleranced = read_toleranced(spec.text, spec.file, spec.read);
  const SpecPlace place{.file = spec.file, .key = "tolerances"};
  if (toleranced.tolerances.empty())
    throw SpecError({.place = place, .message = "missing: it says which numbers may be off"});
  auto told = std::make_shared<Told>();
  told->source = spec.file;
  told->view.mechanism = spec.study().mechanism.name;
  told->view.numbers = toleranced.tolerances;
  told->view.draws = wish.draws;
  try {
    wish.trajectory ? look_along(toleranced, wish, errand, *told) : look_at_rest(toleranced, *told);
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = place, .message = error.what()});
  }
  return told;
}

std::shared_ptr<Told> find_tolerance(const std::shared_ptr<Spec>& spec, const std::string& trajectory,
                                     const std::vector<std::string>& of, std::optional<long> samples, long draws,
                                     std::optional<std::uint64_t> seed, bool at_rest, const py::object& progress) {
  if (at_rest && (!trajectory.empty() || draws != 0))
    throw std::invalid_argument("at_rest: goes neither with a trajectory nor with monte_carlo");
  if (seed && draws == 0) throw std::invalid_argument("seed: is of the draws, and goes with monte_carlo");
  if (draws != 0 && (draws < 2 || draws > most_tolerance_draws))
    throw std::invalid_argument(
        fmt::format("monte_carlo: must be 0 or from 2 to {}, is {}", most_tolerance_draws, draws));
  require_quantities(of, spec->study().mechanism);
  ToleranceWish wish{.trajectory = std::nullopt, .of = of, .draws = {draws, seed.value_or(1)}};
  if (!at_rest) wish.trajectory = trajectory_of(*spec, trajectory, samples);
  auto told = patiently([spec, wish](Errand& errand) { return look(*spec, wish, errand); }, progress);
  if (wish.trajectory)
    told->description =
        describe_tolerance(spec->study(), *wish.trajectory, {.of = of, .samples = samples, .set = spec->set()});
  return told;
}

}  // namespace

void bind_tolerance(py::module_& m) {
  m.def("tolerance", &find_tolerance, py::arg("spec"), py::arg("trajectory"), py::arg("of"), py::arg("samples"),
        py::arg("monte_carlo"), py::arg("seed"), py::arg("at_rest"), py::arg("progress"));
  py::class_<Told, std::shared_ptr<Told>>(m, "Tolerance")
      .def_property_readonly("status", [](const Told& one) { return name_of(one.outcome.status); })
      .def_property_readonly("reason", [](const Told& one) { return one.outcome.reason; })
      .def_property_readonly("end", [](const Told& one) { return one.outcome.time; })
      .def("json", [](const Told& one) { return tolerance_json(one.view); })
      .def("text", [](const Told& one) { return tolerance_text(one.view); })
      .def(
          "write",
          [](const Told& one, const std::string& path, bool force) {
            WriteOptions options;
            options.existing = force ? Existing::replace : Existing::keep;
            options.cancelled = [] { return PyErr_CheckSignals() != 0; };
            keep_sources(path, one.description.spec_text, one.source);
            write_tolerance(path, one.view, one.description, options);
          },
          py::arg("path"), py::arg("force"));
}

}  // namespace balance::python
