#pragma once
/// What the sources of the Python module share: its classes, and how work is done while the interpreter goes on. The classes that users see
/// are written in Python on top of these (python/balance_mechanisms).

#include "balance/interface/files/result_file.hpp"
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

/// A spec that was read, never changed.
struct Spec {
  std::string text;  ///< as read
  std::string file;  ///< what messages call it
  ReadOptions read;
  std::shared_ptr<const DesignSpace> space;

  const Study& study() const { return space->start; }
  const Trajectory& trajectory(
      const std::string& name) const;  ///< "": the first @throws SpecError, std::invalid_argument
  const Controller& controller(
      const std::string& name) const;  ///< "": as `balance control` @throws std::invalid_argument
};

/// A run, never changed: arrays that Python sees are its own memory.
struct Run {
  RunResult result;
  Provenance description;
  std::string source = {};  ///< the file that it comes from, a spec or a result; empty: none
};

/// A design with everything that is told of it, never changed.
struct Design {
  DesignReportData view;
  std::string spec_text;  ///< balanced
  Provenance description;
  std::string source = {};  ///< the spec's file; empty: none
};

/// A mechanism that keeps alive what it is a part of.
using SharedMechanism = std::shared_ptr<const Mechanism>;

/// Python's keyword arguments that say what is asked for conditions and designs.
struct GoalArguments {
  std::vector<std::string> goals, without;
  std::string strategy;
  std::optional<std::uint64_t> seed;
};

/// @throws std::invalid_argument for names that do not exist
BalanceRequest question_of(const GoalArguments& words, const Study& study);

/// @throws std::invalid_argument, with the argument's name before what `change` finds wrong with it
template <class Change>
void change_argument(const char* name, const Change& change) {
  try {
    change();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string(name) + ": " + error.what());
  }
}

/// @throws SystemError if a file of this path would replace the source, or a table or a part that the spec in it is read with
void check_overwrites_no_source(const std::string& path, const std::string& spec_text, const std::string& source);

void bind_errors(py::module_& m);
void bind_patience(py::module_& m);
void bind_spec(py::module_& m);
void bind_mechanism(py::module_& m);
void bind_states(py::module_& m);
void bind_run(py::module_& m);
void bind_moves(py::module_& m);
void bind_balancing(py::module_& m);
void bind_tolerance(py::module_& m);
void bind_comparing(py::module_& m);
void bind_foreign(py::module_& m);

}  // namespace balance::python
