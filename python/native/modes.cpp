#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/interface/reports/modes_request.hpp"

namespace balance::python {
namespace {

/// Result of an analysis of vibrations; immutable.
struct ModesAnswer {
  reports::VibrationReportData view;
  files::Provenance description;
  files::TextOptions text_options = {};
  std::string source = {};  ///< file of the spec
};

std::shared_ptr<ModesAnswer> find_modes(const std::shared_ptr<Spec>& spec, const std::string& trajectory,
                                        const std::string& sweep, int orders, int exact, const py::object& progress) {
  if (orders < 1) throw std::invalid_argument("orders: must be 1 or more");
  if (exact < 0) throw std::invalid_argument("exact: cannot be negative");
  const reports::ModesRequest request{trajectory, sweep, orders, exact};
  return compute_in_background(
      [spec, request](BackgroundTask& task) {
        const Study& study = spec->study();
        auto result = std::make_shared<ModesAnswer>();
        result->text_options = files::make_text_options(study.spec_text);
        result->source = spec->file;
        result->view =
            reports::analyse_modes(study, request, files::find_display_unit("rad/s", result->text_options.units),
                                   [&](double fraction) { task.report_progress(fraction); });
        result->description = reports::make_modes_provenance(study, result->view.modes.trajectory, request);
        return result;
      },
      progress);
}

}  // namespace

void bind_modes(py::module_& m) {
  m.def("modes", &find_modes, py::arg("spec"), py::arg("trajectory"), py::arg("sweep"), py::arg("orders"),
        py::arg("exact"), py::arg("progress"));
  py::class_<ModesAnswer, std::shared_ptr<ModesAnswer>>(m, "Modes")
      .def_property_readonly("status",
                             [](const ModesAnswer& one) { return name_of(one.view.modes.motion.outcome.status); })
      .def_property_readonly("reason", [](const ModesAnswer& one) { return one.view.modes.motion.outcome.reason; })
      .def_property_readonly("end", [](const ModesAnswer& one) { return one.view.modes.motion.outcome.time; })
      .def("json", [](const ModesAnswer& one) { return files::format_json(vibration_report_json(one.view)); })
      .def("text", [](const ModesAnswer& one) { return vibration_report_text(one.view, one.text_options); })
      .def(
          "write",
          [](const ModesAnswer& one, const std::string& path, bool force) {
            files::WriteOptions options;
            options.existing = force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
            options.is_cancelled = [] { return PyErr_CheckSignals() != 0; };
            check_overwrites_no_source(path, one.description.spec_text, one.source);
            write_vibration_report(path, one.view, one.description, options);
          },
          py::arg("path"), py::arg("force"));
}

}  // namespace balance::python
