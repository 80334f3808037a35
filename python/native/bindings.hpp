#pragma once
/// Declarations shared by the sources of the Python module. The classes that users see are implemented in Python on top
/// of these (python/balance_mechanisms).

#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/report_data.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace balance::python {

namespace py = pybind11;

/// A spec after reading; immutable.
struct Spec {
  std::string text;  ///< as read
  std::string file;  ///< name in messages
  ReadOptions read;
  std::shared_ptr<const DesignSpace> space;

  const Study& study() const { return space->start; }
};

/// A run; immutable. Arrays seen from Python share its memory.
struct Run {
  RunResult result;
  files::Provenance description;
  std::string source = {};  ///< the file it was created from, a spec or a result; empty: none
};

/// A design with all report data; immutable.
struct Design {
  reports::DesignReportData view;
  files::TextOptions text_options;
  std::string spec_text;  ///< of the design
  files::Provenance description;
  std::string source = {};  ///< the spec's file; empty: none
};

/// Shares ownership of the object that contains the mechanism.
using SharedMechanism = std::shared_ptr<const Mechanism>;

/// Keyword arguments in Python that specify conditions and designs.
struct GoalArguments {
  std::vector<std::string> goals, without;
  std::string strategy;
  std::optional<std::uint64_t> seed;
};

/// @throws std::invalid_argument if the argument `what` is none of the names
void require_one_of(const std::vector<std::string>& names, const std::string& name, const char* what);

/// @throws std::invalid_argument for unknown names
reports::BalanceRequest question_of(const GoalArguments& arguments, const Study& study);

/// Raises a MechanismError.
[[noreturn]] void refuse(const reports::RequestFailure& refusal);

/// Calls `change`. @throws std::invalid_argument with the message of `change`, prefixed by the name of the argument
template <class Change>
void change_argument(const char* name, const Change& change) {
  try {
    change();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string(name) + ": " + error.what());
  }
}

/// @throws SystemError if writing to this path would replace the source, or a table or part of the spec in it
void check_overwrites_no_source(const std::string& path, const std::string& spec_text, const std::string& source);

void bind_errors(py::module_& m);
void bind_background_tasks(py::module_& m);
void bind_spec(py::module_& m);
void bind_mechanism(py::module_& m);
void bind_states(py::module_& m);
void bind_run(py::module_& m);
void bind_moves(py::module_& m);
void bind_balancing(py::module_& m);
void bind_equations(py::module_& m);
void bind_modes(py::module_& m);
void bind_tolerance(py::module_& m);
void bind_identification(py::module_& m);
void bind_comparing(py::module_& m);
void bind_foreign(py::module_& m);

}  // namespace balance::python
