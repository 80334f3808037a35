#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/check_sections.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/mechanics/trajectory/drive_quantities.hpp"
#include "balance/motion/study/controller_spec.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

std::shared_ptr<Spec> read(std::string text, std::string file, std::vector<std::pair<std::string, std::string>> set) {
  auto spec = std::make_shared<Spec>();
  spec->text = std::move(text);
  spec->file = std::move(file);
  spec->read.set = std::move(set);
  compute_in_background([spec](BackgroundTask&) {
    spec->space = std::make_shared<const DesignSpace>(read_design_space(spec->text, spec->file, spec->read));
    return true;
  });
  return spec;
}

py::list trajectories_of(const Spec& spec) {
  py::list all;
  for (const Trajectory& one : spec.study().trajectories) {
    py::dict entry;
    entry["name"] = one.name;
    entry["law"] = law_name(one);
    entry["drive"] = drive_name(one);
    entry["duration"] = one.duration;
    entry["samples"] = one.samples;
    all.append(entry);
  }
  return all;
}

py::list controllers_of(const Spec& spec) {
  py::list all;
  for (const Controller& one : spec.study().controllers) {
    py::dict entry;
    entry["name"] = one.name;
    entry["type"] = controller_type_name(one.type);
    entry["period"] = one.period;
    all.append(entry);
  }
  return all;
}

py::list free_numbers_of(const Spec& spec) {
  py::list all;
  const specification::NumberUnits units = specification::list_number_units(spec.study());
  for (const FreeNumber& one : spec.study().free_numbers) {
    py::dict entry;
    entry["path"] = one.key_path;
    entry["lower"] = one.lower;
    entry["upper"] = one.upper;
    entry["start"] = one.start;
    entry["unit"] = one.unit;
    const auto unit = units.find(one.key_path);
    entry["si_unit"] = unit == units.end() || unit->second == "1" ? "" : unit->second;
    all.append(entry);
  }
  return all;
}

struct Checked {
  CheckReport report;
  std::string json, text;
};

/// @return status ("done" or the failure), reason in one sentence, JSON and text
py::tuple check_spec(const std::shared_ptr<Spec>& spec, bool verified, const py::object& progress) {
  const Checked checked = compute_in_background(
      [spec, verified](BackgroundTask& task) {
        const Study& study = spec->study();
        Checked all;
        all.report = check_mechanism(study, [&](double fraction) { task.report_progress(fraction); });
        std::optional<verification::VerifyReport> verification;
        if (verified && all.report.outcome.status == MotionStatus::done) verification = verify_formulations(study);
        all.json = files::format_json(
            reports::check_json(all.report, study.mechanism, study.warnings, verification ? &*verification : nullptr));
        const files::TextOptions text = files::make_text_options(study.spec_text);
        all.text = reports::check_text(all.report, study.mechanism, text);
        if (verification) all.text += "\n" + reports::verify_text(*verification, text);
        return all;
      },
      progress);
  return py::make_tuple(name_of(checked.report.outcome.status), checked.report.outcome.reason, checked.json,
                        checked.text);
}

py::list goal_words(const Spec& spec) {
  py::list all;
  for (const Goal& goal : spec.study().design.goals) all.append(goal_name(goal));
  return all;
}

}  // namespace

void bind_spec(py::module_& m) {
  py::class_<Spec, std::shared_ptr<Spec>>(m, "Spec")
      .def(py::init(&read), py::arg("text"), py::arg("file"), py::arg("set"))
      .def_readonly("text", &Spec::text)
      .def_readonly("file", &Spec::file)
      .def_property_readonly("set", [](const Spec& spec) { return spec.read.set; })
      .def_property_readonly("name", [](const Spec& spec) { return spec.study().mechanism.name; })
      .def_property_readonly("warnings", [](const Spec& spec) { return spec.study().warnings; })
      .def_property_readonly("trajectories", &trajectories_of)
      .def_property_readonly("controllers", &controllers_of)
      .def_property_readonly("free_numbers", &free_numbers_of)
      .def_property_readonly("goals", &goal_words)
      .def_property_readonly(
          "mechanism",
          [](const std::shared_ptr<Spec>& spec) {
            // pybind11 does not support holders of const objects
            return std::const_pointer_cast<Mechanism>(SharedMechanism(spec->space, &spec->study().mechanism));
          })
      .def("check", &check_spec, py::arg("verify"), py::arg("progress"));
}

}  // namespace balance::python
