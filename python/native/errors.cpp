#include "bindings.hpp"

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/atomic_file.hpp"

namespace balance::python {
namespace {

/// `--minimize` is an option of the program; here it is an argument.
std::string as_argument(const SourceLocation& place) { return place.is_option() ? place.file.substr(2) : place.file; }

py::dict mistake_of(const Diagnostic& mistake) {
  py::dict all;
  all["file"] = as_argument(mistake.place);
  all["line"] = mistake.place.line;
  all["column"] = mistake.place.column;
  all["key"] = mistake.place.key;
  all["message"] = mistake.message;
  all["expected"] = mistake.expected;
  all["found"] = mistake.found;
  all["hint"] = mistake.hint;
  return all;
}

std::string text_of(const SpecError& error) {
  const std::string text = error.what();
  return error.diagnostics().front().place.is_option() ? text.substr(2) : text;
}

void raise(const SpecError& error) {
  py::list mistakes;
  for (const Diagnostic& mistake : error.diagnostics()) mistakes.append(mistake_of(mistake));
  const py::object type = py::module_::import("balance_mechanisms._errors").attr("SpecError");
  PyErr_SetObject(type.ptr(), type(text_of(error), mistakes).ptr());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const SpecError& error) {
    raise(error);
  } catch (const DeadlineExceeded& error) {
    PyErr_SetString(PyExc_TimeoutError, error.what());
  } catch (const SystemError& error) {
    PyErr_SetString(PyExc_OSError, escape_for_terminal(error.what()).c_str());
  } catch (const Cancelled& error) {
    if (PyErr_Occurred() == nullptr) PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
  }
}

}  // namespace

void bind_errors(py::module_&) { py::register_local_exception_translator(&translate); }

}  // namespace balance::python
