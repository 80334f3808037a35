#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/reports/check_sections.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/controller_spec.hpp"
#include "balance/synthesis/verification/formulation_check.hpp"
#include "balance/synthesis/verification/mechanism_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

/// The one of this name. @throws std::invalid_argument with the names that there are
template <class T>
const T& find_named(const std::vector<T>& all, const std::string& name, const char* what, const std::string& file) {
  std::vector<std::string> names;
  for (const T& one : all) {
    if (one.name == name) return one;
    names.push_back(one.name);
  }
  throw std::invalid_argument(fmt::format("{} has no {} {}, only {}{}", file, what, quote_for_message(name),
                                          fmt::join(names, ", "), append_nearest_name(name, names)));
}

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
    entry["drive"] = name_of(one.drive);
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
  for (const FreeNumber& one : spec.study().free_numbers) {
    py::dict entry;
    entry["path"] = one.key_path;
    entry["lower"] = one.lower;
    entry["upper"] = one.upper;
    entry["start"] = one.start;
    entry["unit"] = one.unit;
    all.append(entry);
  }
  return all;
}

struct Checked {
  CheckReport report;
  std::string json, text;
};

/// @return how it ended ("done", or why not), one sentence, JSON and text
py::tuple check_spec(const std::shared_ptr<Spec>& spec, bool verified, const py::object& progress) {
  const Checked checked = compute_in_background(
      [spec, verified](BackgroundTask& errand) {
        const Study& study = spec->study();
        Checked all;
        all.report = check_mechanism(study, [&](double part) { errand.report_progress(part); });
        std::optional<VerifyReport> twice;
        if (verified && all.report.outcome.status == MotionStatus::done) twice = verify_formulations(study);
        all.json = check_json(all.report, study.mechanism, study.warnings, twice ? &*twice : nullptr);
        all.text = check_text(all.report, study.mechanism);
        if (twice) all.text += "\n" + verify_text(*twice);
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

const Trajectory& Spec::trajectory(const std::string& name) const {
  const std::vector<Trajectory>& all = study().trajectories;
  if (all.empty()) throw SpecError({.place = {.file = file}, .message = "there is no motion to simulate"});
  return name.empty() ? all.front() : find_named(all, name, "trajectory", file);
}

const Controller& Spec::controller(const std::string& name) const {
  const std::vector<Controller>& all = study().controllers;
  if (!name.empty()) return find_named(all, name, "controller", file);
  // The built-in ones stand behind those of the spec.
  const std::vector<Controller> built_in = built_in_controllers();
  const bool listed = all.size() > built_in.size() || all.front().name != built_in.front().name;
  return listed ? all.front()
                : find_named(all, controller_type_name(ControllerType::computed_torque), "controller", file);
}

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
            // pybind11 keeps no holders of constants
            return std::const_pointer_cast<Mechanism>(SharedMechanism(spec->space, &spec->study().mechanism));
          })
      .def("check", &check_spec, py::arg("verify"), py::arg("progress"));
}

}  // namespace balance::python
