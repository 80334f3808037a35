#include "arrays.hpp"
#include "native.hpp"
#include "parallel_rows.hpp"
#include "patience.hpp"

#include "balance/inverse/inverse_dynamics.hpp"
#include "balance/motion/names.hpp"

#include <mutex>

namespace balance::python {
namespace {

/// The library's way in, which goes from state to state; one thread at a time.
struct InverseDynamicsHandle {
  InverseDynamicsHandle(SharedMechanism its_mechanism, InverseDynamics its_inverse)
      : mechanism(std::move(its_mechanism)), inverse(std::move(its_inverse)) {}

  SharedMechanism mechanism;
  InverseDynamics inverse;
  std::mutex mutex;

  /// Without the interpreter's lock, and alone.
  template <class Work>
  auto with_lock(Work work) {
    const ScopedGilRelease free;
    const std::lock_guard lock(mutex);
    return work(inverse);
  }
};

InverseOptions options_of(const std::vector<std::string>& independent, const std::vector<double>& about) {
  InverseOptions options;
  options.independent = independent;
  for (std::size_t i = 0; i < about.size() && i < 3; ++i) options.about[static_cast<Eigen::Index>(i)] = about[i];
  return options;
}

std::shared_ptr<InverseDynamicsHandle> make_handle(const std::shared_ptr<Mechanism>& mechanism,
                                                   const std::vector<std::string>& independent,
                                                   const std::vector<double>& about) {
  const ScopedGilRelease free;
  return std::make_shared<InverseDynamicsHandle>(mechanism,
                                                 InverseDynamics(*mechanism, options_of(independent, about)));
}

/// (status, time, reason): how Python hears of an outcome.
py::tuple outcome_to_python(const MotionOutcome& outcome) {
  return py::make_tuple(name_of(outcome.status), outcome.time, outcome.reason);
}

py::list outcome_to_python(const std::vector<FailedRow>& failures) {
  py::list all;
  for (const FailedRow& one : failures) all.append(py::make_tuple(one.row, outcome_to_python(one.outcome)));
  return all;
}

/// Rows of numbers for every thread; what callers keep alive meanwhile.
EffortRequest question_of(const Numbers& q, const Numbers& dq, const Numbers& ddq, const Numbers& time) {
  return {rows_of(q), rows_of(dq), rows_of(ddq), vector_of(time)};
}

py::tuple efforts(const std::shared_ptr<Mechanism>& mechanism, const std::vector<std::string>& independent,
                  const Numbers& q, const Numbers& dq, const Numbers& ddq, const Numbers& time, unsigned threads) {
  EffortBatch answers;
  const EffortRequest question = question_of(q, dq, ddq, time);
  const InverseOptions options = options_of(independent, {});
  if (question.q.rows() <= 64) {
    const ScopedGilRelease free;  // done before a thread is made
    answers = InverseDynamics(*mechanism, options).effort_rows(question.q, question.dq, question.ddq, question.time);
  } else {
    answers = compute_in_background(
        [mechanism, options, question, threads](BackgroundTask& errand) {
          return effort_rows(*mechanism, options, question, threads, [&] { return errand.is_cancelled(); });
        },
        py::none(), DetachPolicy::never);  // the arrays are the caller's
  }
  return py::make_tuple(owned(std::move(answers.efforts)), outcome_to_python(answers.failures));
}

std::shared_ptr<Run> rows(InverseDynamicsHandle& door, const Numbers& q, const Numbers& dq, const Numbers& ddq,
                          const Numbers& time, py::list failures) {
  const EffortRequest question = question_of(q, dq, ddq, time);
  SampleBatch answers = door.with_lock(
      [&](InverseDynamics& inverse) { return inverse.at_rows(question.q, question.dq, question.ddq, question.time); });
  for (const py::handle one : outcome_to_python(answers.failures)) failures.append(one);
  auto run = std::make_shared<Run>();
  run->result = std::move(answers.result);
  run->description.title = door.mechanism->name;
  return run;
}

py::array matrix(const MatrixX& m) {
  Samples byrows = m;
  return owned(std::move(byrows));
}

py::tuple mass_matrix(InverseDynamicsHandle& door, const Numbers& q) {
  const VectorX at = vector_of(q);
  const auto found = door.with_lock([&](InverseDynamics& inverse) { return inverse.mass_matrix(at); });
  return py::make_tuple(outcome_to_python(found.outcome), matrix(found.value));
}

py::tuple bias(InverseDynamicsHandle& door, const Numbers& q, const Numbers& dq, double time) {
  const VectorX at = vector_of(q), rate = vector_of(dq);
  const auto found = door.with_lock([&](InverseDynamics& inverse) { return inverse.bias(at, rate, time); });
  return py::make_tuple(outcome_to_python(found.outcome), copied(found.value));
}

py::tuple regressor(InverseDynamicsHandle& door, const Numbers& q, const Numbers& dq, const Numbers& ddq, double time) {
  const VectorX at = vector_of(q), rate = vector_of(dq), acceleration = vector_of(ddq);
  const auto found =
      door.with_lock([&](InverseDynamics& inverse) { return inverse.regressor(at, rate, acceleration, time); });
  const EffortRegressor& r = found.value;
  py::dict all;
  py::list names;
  for (const Parameter& one : r.parameters) names.append(one.name);
  all["parameters"] = names;
  all["values"] = copied(r.values);
  all["effort"] = matrix(r.effort);
  all["shaking_force"] = matrix(r.shaking_force);
  all["shaking_moment"] = matrix(r.shaking_moment);
  all["other"] = copied(r.constant_effort);
  return py::make_tuple(outcome_to_python(found.outcome), all);
}

py::tuple assemble(InverseDynamicsHandle& door, const Numbers& q,
                   const std::vector<std::pair<std::string, double>>& near) {
  std::vector<CoordinateGuess> values;
  for (const auto& [name, value] : near) values.push_back({name, value});
  const VectorX at = vector_of(q);
  const auto found = door.with_lock([&](InverseDynamics& inverse) { return inverse.assemble(at, values); });
  return py::make_tuple(outcome_to_python(found.outcome), copied(found.value));
}

}  // namespace

void bind_states(py::module_& m) {
  m.def("efforts", &efforts, py::arg("mechanism"), py::arg("independent"), py::arg("q"), py::arg("dq"), py::arg("ddq"),
        py::arg("time"), py::arg("threads"));
  py::class_<InverseDynamicsHandle, std::shared_ptr<InverseDynamicsHandle>>(m, "Door")
      .def(py::init(&make_handle), py::arg("mechanism"), py::arg("independent"), py::arg("about"))
      .def_property_readonly("dof", [](const InverseDynamicsHandle& door) { return door.inverse.degrees_of_freedom(); })
      .def_property_readonly("independent",
                             [](const InverseDynamicsHandle& door) { return door.inverse.independent(); })
      .def_property_readonly("actuators", [](const InverseDynamicsHandle& door) { return door.inverse.actuators(); })
      .def_property_readonly("notes", [](const InverseDynamicsHandle& door) { return door.inverse.notes(); })
      .def("assemble", &assemble, py::arg("q"), py::arg("near"))
      .def("rows", &rows, py::arg("q"), py::arg("dq"), py::arg("ddq"), py::arg("time"), py::arg("failures"))
      .def("mass_matrix", &mass_matrix, py::arg("q"))
      .def("bias", &bias, py::arg("q"), py::arg("dq"), py::arg("time"))
      .def("regressor", &regressor, py::arg("q"), py::arg("dq"), py::arg("ddq"), py::arg("time"));
}

}  // namespace balance::python
