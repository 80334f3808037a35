#include "arrays.hpp"
#include "background_task.hpp"
#include "bindings.hpp"

#include "balance/interface/reports/identification_request.hpp"
#include "balance/interface/reports/identification_sections.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::python {
namespace {

using identification::ChannelReport;
using identification::ChannelSeries;

/// Result of an identification; immutable.
struct IdentificationAnswer {
  std::shared_ptr<Spec> spec;
  reports::IdentificationRequest request;
  reports::RequestedIdentification found;
  std::string json = {}, text = {};

  const identification::Identification& answer() const { return found.answer; }
};

/// Options of the program are arguments with underscores here.
[[noreturn]] void refuse_argument(const reports::IdentificationRequestError& error) {
  std::string name = error.option;
  std::replace(name.begin(), name.end(), '-', '_');
  throw std::invalid_argument(name + ": " + error.reason);
}

void compute(IdentificationAnswer& result) {
  const Study& study = result.spec->study();
  try {
    result.found = reports::identify_from_records(study, result.request);
  } catch (const reports::IdentificationRequestError& error) {
    refuse_argument(error);
  }
  if (result.found.refusal) return;
  const std::string& title = study.mechanism.name;
  result.json = files::format_json(reports::identification_json(result.answer(), title, {}));
  result.text = reports::identification_text(result.answer(), title, files::make_text_options(study.spec_text));
}

using Range = std::pair<double, double>;

std::shared_ptr<IdentificationAnswer> identify(const std::shared_ptr<Spec>& spec, std::vector<std::string> records,
                                               std::vector<std::string> validation,
                                               std::vector<std::pair<std::string, std::string>> columns,
                                               std::optional<std::pair<long, long>> rows, std::optional<Range> time,
                                               const py::dict& numbers,
                                               std::vector<std::pair<std::string, double>> gains, bool finds_gains,
                                               std::vector<std::pair<std::string, std::string>> loaded,
                                               std::vector<std::string> payloads, std::string passive_friction) {
  auto result = std::make_shared<IdentificationAnswer>();
  result->spec = spec;
  reports::IdentificationRequest& request = result->request;
  request.records = std::move(records), request.validation = std::move(validation);
  request.reading = {std::move(columns), rows, time, ""};
  request.cutoff = numbers["cutoff"].cast<double>();
  request.rest_rate = numbers["rest"].cast<double>();
  request.prior_weight = numbers["prior_weight"].cast<double>();
  request.correlation_time = numbers["correlation"].cast<double>();
  request.hold_out = numbers["hold_out"].cast<double>();
  request.gains = std::move(gains), request.loaded = std::move(loaded), request.payloads = std::move(payloads);
  request.finds_gains = finds_gains;
  request.passive_friction = std::move(passive_friction);
  compute_in_background([result](BackgroundTask&) {
    compute(*result);
    return true;
  });
  if (result->found.refusal) refuse(result->found.refusal);
  return result;
}

template <class T>
py::array array_of(const std::vector<T>& values, const py::object& owner) {
  return read_only(values.data(), {static_cast<py::ssize_t>(values.size())}, owner);
}

py::object series_of(const ChannelSeries& series, const py::object& owner) {
  if (series.time.empty()) return py::none();
  py::array_t<bool> moving(static_cast<py::ssize_t>(series.moving.size()));
  std::copy(series.moving.begin(), series.moving.end(), moving.mutable_data());
  return py::make_tuple(array_of(series.record, owner), array_of(series.time, owner), array_of(series.measured, owner),
                        array_of(series.predicted, owner), array_of(series.friction, owner),
                        array_of(series.rate, owner), moving);
}

/// Per channel: name, unit, gain, its deviation, series of the records that were fitted and of those that were not.
py::list channels_of(const std::shared_ptr<IdentificationAnswer>& one) {
  const py::object owner = py::cast(one);
  py::list all;
  for (const ChannelReport& channel : one->answer().channels)
    all.append(py::make_tuple(channel.name, channel.unit, channel.gain, channel.gain_deviation,
                              series_of(channel.training_series, owner), series_of(channel.validation_series, owner)));
  return all;
}

py::array covariance_of(const IdentificationAnswer& one) { return owned(Samples(one.answer().base_covariance)); }

/// @throws SystemError if writing to this path would replace the spec, a part of it or a record
void check_overwrites_no_input(const IdentificationAnswer& one, const std::string& path) {
  check_overwrites_no_source(path, one.spec->text, one.spec->file);
  const std::vector<files::InputFile> records = reports::list_record_files(one.request);
  if (const files::InputFile* replaced = find_replaced_input(path, records))
    throw SystemError("cannot write " + path + ": it would replace its input: " + replaced->path);
}

files::OverwritePolicy policy_of(bool force) {
  return force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid;
}

std::vector<std::string> write_spec(const IdentificationAnswer& one, const std::string& path, bool force) {
  check_overwrites_no_input(one, path);
  return reports::write_identified_spec(path, one.spec->study(), one.answer(), policy_of(force));
}

void write(const IdentificationAnswer& one, const std::string& path, bool force) {
  check_overwrites_no_input(one, path);
  files::WriteOptions options;
  options.existing = policy_of(force);
  options.is_cancelled = [] { return PyErr_CheckSignals() != 0; };
  reports::write_identification(path, one.answer(),
                                reports::make_identification_provenance(one.spec->study(), one.request), options);
}

}  // namespace

void bind_identification(py::module_& m) {
  m.def("identify", &identify, py::arg("spec"), py::arg("records"), py::arg("validate"), py::arg("columns"),
        py::arg("rows"), py::arg("time"), py::arg("numbers"), py::arg("gain"), py::arg("find_gains"), py::arg("loaded"),
        py::arg("find_payload"), py::arg("passive_friction"));
  py::class_<IdentificationAnswer, std::shared_ptr<IdentificationAnswer>>(m, "Identification")
      .def_readonly("json", &IdentificationAnswer::json)
      .def_readonly("text", &IdentificationAnswer::text)
      .def_property_readonly("channels", &channels_of)
      .def_property_readonly("covariance", &covariance_of)
      .def_property_readonly("mechanism",
                             [](const std::shared_ptr<IdentificationAnswer>& one) {
                               // pybind11 does not support holders of const objects
                               return std::shared_ptr<Mechanism>(one, &one->found.answer.mechanism);
                             })
      .def("write_spec", &write_spec, py::arg("path"), py::arg("force"))
      .def("write", &write, py::arg("path"), py::arg("force"));
}

}  // namespace balance::python
