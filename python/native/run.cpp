#include "arrays.hpp"
#include "bindings.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/order_summary.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/result_summary.hpp"
#include "balance/interface/specification/include_expansion.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

namespace balance::python {

using results::ColumnKind;

namespace {

using SharedRun = std::shared_ptr<Run>;

/// Names of the dimensions after `time`, as in the result file.
std::vector<std::string> dimensions_of(ColumnKind columns) {
  switch (columns) {
    case ColumnKind::single: return {};
    case ColumnKind::coordinate: return {"coordinate"};
    case ColumnKind::actuator: return {"actuator"};
    case ColumnKind::axis: return {"axis"};
    case ColumnKind::quaternion: return {"quaternion"};
    case ColumnKind::joint: return {"joint"};
    case ColumnKind::joint_axis: return {"joint", "axis"};
    case ColumnKind::constraint: return {"constraint"};
    case ColumnKind::sliding: return {"sliding"};
    case ColumnKind::body: return {"body"};
    case ColumnKind::body_axis: return {"body", "axis"};
    case ColumnKind::body_quaternion: return {"body", "quaternion"};
  }
  return {};
}

std::vector<std::string> labels_of(const std::string& dimension, const RunResult& r) {
  if (dimension == "coordinate") return r.coordinate_names;
  if (dimension == "actuator") return r.actuator_names;
  if (dimension == "joint") return r.joint_names;
  if (dimension == "constraint") return r.constraint_names;
  if (dimension == "sliding") return r.sliding_names;
  if (dimension == "body") return r.body_names;
  if (dimension == "axis") return results::axis_labels(r.axes);
  return results::quaternion_labels();
}

py::list round_off_of(const RunResult& r, const Quantity& quantity) {
  py::list all;
  VectorX results::TermMagnitudes::*const size = results::term_magnitude_of(quantity.member);
  if (size == nullptr) return all;
  for (const double value : r.round_off.*size) all.append(value);
  return all;
}

/// The metadata of a quantity: name, units, dimensions and so on, without its values.
py::dict describe(const RunResult& r, const Quantity& quantity) {
  py::dict one;
  one["long_name"] = quantity.long_name;
  one["unit"] = results::common_unit(quantity.units);
  one["units"] = quantity.units;
  one["dimensions"] = dimensions_of(quantity.columns);
  one["round_off"] = round_off_of(r, quantity);
  if (quantity.has_moment_reference)
    one["about"] = std::vector<double>(r.moment_reference.data(), r.moment_reference.data() + r.axes);
  return one;
}

py::dict quantities_of(const Run& run) {
  py::dict all;
  for (const Quantity& quantity : list_sampled_quantities(run.result))
    all[py::str(quantity.name)] = describe(run.result, quantity);
  return all;
}

py::object values_of(const SharedRun& run, const std::string& name) {
  const RunResult& r = run->result;
  const py::object owner = py::cast(run);
  const py::ssize_t rows = r.time.size();
  if (name == "time") return read_only(r.time.data(), {rows}, owner);
  if (name == "newton_iterations" && r.newton_iterations.size() > 0)
    return read_only(r.newton_iterations.data(), {rows}, owner);
  for (const Quantity& quantity : list_sampled_quantities(r)) {
    if (quantity.name != name) continue;
    std::vector<py::ssize_t> shape{rows};
    for (const std::string& dimension : dimensions_of(quantity.columns))
      shape.push_back(static_cast<py::ssize_t>(labels_of(dimension, r).size()));
    return read_only(quantity.samples->data(), shape, owner);
  }
  return py::none();
}

py::dict labels_of_all(const Run& run) {
  py::dict all;
  for (const Quantity& quantity : list_sampled_quantities(run.result))
    for (const std::string& dimension : dimensions_of(quantity.columns))
      all[py::str(dimension)] = labels_of(dimension, run.result);
  return all;
}

py::list metrics_of(const Run& run) {
  py::list all;
  for (const Metric& one : run.result.metrics)
    all.append(
        py::make_tuple(one.quantity, one.unit, one.peak, one.peak_time, one.rms, one.mean, one.range, one.round_off));
  return all;
}

py::list payload_changes_of(const Run& run) {
  py::list all;
  for (const results::PayloadEvent& one : run.result.payload_events)
    all.append(py::make_tuple(one.payload, describe_payload_event(one), one.time, one.speed, one.angular_speed,
                              copied(one.effort_before), copied(one.effort_after), one.impact_loss));
  return all;
}

py::list adaptation_moves_of(const Run& run) {
  py::list all;
  for (const results::AdaptationMove& one : run.result.adaptation_moves)
    all.append(py::make_tuple(one.counterweight, one.start, one.end, one.from, one.to, one.work, one.energy,
                              copied(one.peak_effort)));
  return all;
}

py::dict description_of(const Run& run) {
  const files::Provenance& d = run.description;
  py::dict all;
  all["title"] = d.title;
  all["balance_version"] = d.version;
  all["spec"] = d.spec_text;
  all["command_line"] = d.command_line;
  if (!d.overrides.empty()) {
    py::list names, values;
    for (const auto& [name, value] : d.overrides) names.append(name), values.append(value);
    all["override_names"] = names, all["override_values"] = values;
  }
  all["trajectory"] = d.trajectory;
  all["law"] = d.law;
  all["drive"] = d.drive;
  all["formulation"] = d.formulation;
  if (!d.controller.empty()) all["controller"] = d.controller;
  if (!d.controller.empty()) all["controller_type"] = d.controller_type;
  return all;
}

/// Writing keeps the GIL: HDF5 is not thread-safe, and other modules that use it rely on the GIL.
files::WriteOptions write_options(bool force, bool compress) {
  files::WriteOptions options;
  options.existing = force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
  options.compression = compress ? files::Compression::gzip : files::Compression::none;
  options.is_cancelled = [] { return PyErr_CheckSignals() != 0; };
  return options;
}

}  // namespace

void check_overwrites_no_source(const std::string& path, const std::string& spec_text, const std::string& source) {
  if (source.empty()) return;
  std::vector<files::InputFile> inputs = {{source, ""}};
  for (std::string& file : specification::list_spec_files(spec_text, source)) inputs.push_back({std::move(file), ""});
  if (const files::InputFile* replaced = find_replaced_input(path, inputs))
    throw SystemError("cannot write " + path + ": it would replace its input: " + replaced->path);
}

void bind_run(py::module_& m) {
  py::class_<Run, SharedRun>(m, "Run")
      .def_property_readonly("status", [](const Run& run) { return name_of(run.result.outcome.status); })
      .def_property_readonly("end", [](const Run& run) { return run.result.outcome.time; })
      .def_property_readonly("reason", [](const Run& run) { return run.result.outcome.reason; })
      .def_property_readonly("notes", [](const Run& run) { return run.result.outcome.notes; })
      .def_property_readonly("rows", [](const Run& run) { return run.result.time.size(); })
      .def_property_readonly("energy", [](const Run& run) { return run.result.energy; })
      .def_property_readonly("axes", [](const Run& run) { return run.result.axes; })
      .def_property_readonly("coordinate_units", [](const Run& run) { return run.result.coordinate_units; })
      .def_property_readonly("actuator_units", [](const Run& run) { return run.result.actuator_units; })
      .def_property_readonly("sliding_units", [](const Run& run) { return run.result.sliding_units; })
      .def_property_readonly("quantities", &quantities_of)
      .def_property_readonly("labels", &labels_of_all)
      .def_property_readonly("metrics", &metrics_of)
      .def_property_readonly("payload_changes", &payload_changes_of)
      .def_property_readonly("adaptation_moves", &adaptation_moves_of)
      .def("orders_json",
           [](const Run& run, int highest, std::optional<double> fluctuation) {
             return files::format_json(files::orders_json(results::analyse_orders(run.result, highest, fluctuation)));
           })
      .def_property_readonly("description", &description_of)
      .def("values", &values_of, py::arg("name"))
      .def(
          "write_hdf5",
          [](const Run& run, const std::string& path, bool force, bool compress) {
            check_overwrites_no_source(path, run.description.spec_text, run.source);
            write_result_hdf5(path, run.result, run.description, write_options(force, compress));
          },
          py::arg("path"), py::arg("force"), py::arg("compress"))
      .def(
          "write_csv",
          [](const Run& run, const std::string& path, bool force) {
            check_overwrites_no_source(path, run.description.spec_text, run.source);
            write_result_csv(path, run.result, write_options(force, false));
          },
          py::arg("path"), py::arg("force"))
      .def("text",
           [](const Run& run) {
             return format_result_summary(run.result, run.description,
                                          files::make_text_options(run.description.spec_text));
           })
      .def("json", [](const Run& run) { return files::format_result_json(run.result, run.description, {}); });
}

}  // namespace balance::python
