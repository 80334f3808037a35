#include "background_task.hpp"
#include "bindings.hpp"
#include "starters.hpp"

#include "balance/interface/import/import.hpp"
#include "balance/interface/import/mass_export.hpp"
#include "balance/interface/import/robot_export.hpp"
#include "balance/interface/specification/text_file.hpp"

namespace balance::python {
namespace {

foreign::ImportOptions options_of(const std::string& loops, bool fixed_base, const std::vector<std::string>& actuate) {
  return {.loops = loops, .fixed_base = fixed_base, .actuate = actuate};
}

py::list findings_of(const foreign::ImportResult& imported) {
  py::list all;
  for (const foreign::Finding& one : imported.findings) {
    py::dict finding;
    finding["level"] = one.level == foreign::Severity::warning ? "warning" : "note";
    finding["code"] = one.code;
    finding["file"] = one.place.file;
    finding["line"] = one.place.line;
    finding["subject"] = one.subject;
    finding["message"] = one.message;
    all.append(finding);
  }
  return all;
}

py::dict import_robot(const std::string& path, const std::string& loops, bool fixed_base,
                      const std::vector<std::string>& actuate) {
  const foreign::ImportOptions options = options_of(loops, fixed_base, actuate);
  const foreign::ImportResult imported =
      compute_in_background([path, options](BackgroundTask&) { return import_file(path, options); });
  py::dict all;
  all["format"] = imported.format;
  all["spec_text"] = imported.spec;
  all["findings"] = findings_of(imported);
  all["ignored"] = imported.ignored;
  all["renamed"] = py::dict(py::cast(imported.renamed));
  all["bodies"] = imported.bodies;
  all["joints"] = imported.joints;
  all["loops"] = imported.loops;
  all["total_mass"] = imported.total_mass;
  all["dof"] = imported.degrees_of_freedom;
  all["actuators"] = imported.actuators;
  all["assembly"] = py::dict(py::cast(imported.assembly));
  all["not_assembled"] = imported.assembly_failure_reason;
  return all;
}

py::tuple export_robot(const std::shared_ptr<Spec>& spec, const std::string& text, const std::string& file,
                       const std::string& loops, bool fixed_base, const std::vector<std::string>& actuate) {
  const foreign::MassExport exported = export_masses(spec->study(), text, file, options_of(loops, fixed_base, actuate));
  return py::make_tuple(exported.text, exported.changed, exported.notes);
}

/// @param path may be empty
py::tuple export_model(const std::shared_ptr<Spec>& spec, const std::string& format, const std::string& path,
                       const std::string& trajectory) {
  const foreign::RobotExport exported =
      foreign::export_robot(spec->study(), foreign::choose_robot_format(format, path), trajectory);
  return py::make_tuple(exported.text, exported.notes, exported.missing);
}

}  // namespace

void bind_foreign(py::module_& m) {
  m.def(
      "read_text", [](const std::string& path) { return specification::read_text_file(path, "spec"); },
      py::arg("path"));
  py::list starters;
  for (const app::Starter& one : app::starters())
    starters.append(py::make_tuple(std::string(one.kind), std::string(one.text)));
  m.attr("starters") = starters;
  m.def("import_robot", &import_robot, py::arg("path"), py::arg("loops"), py::arg("fixed_base"), py::arg("actuate"));
  m.def("export_robot", &export_robot, py::arg("spec"), py::arg("text"), py::arg("file"), py::arg("loops"),
        py::arg("fixed_base"), py::arg("actuate"));
  m.def("export_model", &export_model, py::arg("spec"), py::arg("format"), py::arg("path"), py::arg("trajectory"));
  m.def(
      "parts_csv", [](const Spec& spec) { return foreign::format_balancing_elements_csv(spec.study().mechanism); },
      py::arg("spec"));
}

}  // namespace balance::python
