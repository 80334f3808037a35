#include "bindings.hpp"

#include "balance/foundation/base/version.hpp"

PYBIND11_MODULE(_native, m) {
  m.doc() = "Implementation of balance_mechanisms; use that module.";
  m.attr("version") = balance::version();
  balance::python::bind_errors(m);
  balance::python::bind_background_tasks(m);
  balance::python::bind_mechanism(m);
  balance::python::bind_run(m);
  balance::python::bind_spec(m);
  balance::python::bind_states(m);
  balance::python::bind_moves(m);
  balance::python::bind_balancing(m);
  balance::python::bind_equations(m);
  balance::python::bind_modes(m);
  balance::python::bind_tolerance(m);
  balance::python::bind_identification(m);
  balance::python::bind_comparing(m);
  balance::python::bind_foreign(m);
}
