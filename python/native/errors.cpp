#include "bindings.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/file_error.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/atomic_file.hpp"

namespace balance::python {
namespace {

/// Options of the program such as `--minimize` are called arguments here, without dashes.
std::string as_argument(const SourceLocation& place) { return place.is_option() ? place.file.substr(2) : place.file; }

py::dict diagnostic_to_python(const Diagnostic& diagnostic) {
  py::dict all;
  all["file"] = as_argument(diagnostic.place);
  all["line"] = diagnostic.place.line;
  all["column"] = diagnostic.place.column;
  all["key"] = diagnostic.place.key;
  all["message"] = diagnostic.message;
  all["expected"] = diagnostic.expected;
  all["found"] = diagnostic.found;
  all["hint"] = diagnostic.hint;
  return all;
}

std::string text_of(const SpecError& error) {
  const std::string text = error.what();
  return error.diagnostics().front().place.is_option() ? text.substr(2) : text;
}

void raise(const SpecError& error) {
  py::list diagnostics;
  for (const Diagnostic& diagnostic : error.diagnostics()) diagnostics.append(diagnostic_to_python(diagnostic));
  const py::object type = py::module_::import("balance_mechanisms._errors").attr("SpecError");
  PyErr_SetObject(type.ptr(), type(text_of(error), diagnostics).ptr());
}

/// The message in a form for Python, where options are called arguments.
std::string text_of(const SystemError& error) {
  std::string text = escape_for_terminal(error.what());
  const std::string option = "; --force ";
  if (const std::size_t place = text.rfind(option); place != std::string::npos)
    text.replace(place, option.size(), "; force=True ");
  return text;
}

/// The class that Python has for the error's number, such as FileNotFoundError, with our sentence as its text.
void raise(const FileError& error) {
  const py::object system = py::reinterpret_borrow<py::object>(PyExc_OSError);
  const py::object type = py::type::of(system(error.error_number(), ""));
  const py::object raised = type(text_of(error));
  raised.attr("errno") = error.error_number();
  PyErr_SetObject(type.ptr(), raised.ptr());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const SpecError& error) {
    raise(error);
  } catch (const DeadlineExceeded& error) {
    PyErr_SetString(PyExc_TimeoutError, error.what());
  } catch (const FileError& error) {
    raise(error);
  } catch (const SystemError& error) {
    PyErr_SetString(PyExc_OSError, text_of(error).c_str());
  } catch (const files::Cancelled& error) {
    if (PyErr_Occurred() == nullptr) PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
  }
}

}  // namespace

void refuse(const reports::RequestFailure& refusal) {
  const py::object type = py::module_::import("balance_mechanisms._errors").attr("MechanismError");
  PyErr_SetObject(type.ptr(), type(refusal.reason, refusal.status).ptr());
  throw py::error_already_set();
}

void bind_errors(py::module_&) { py::register_local_exception_translator(&translate); }

}  // namespace balance::python
