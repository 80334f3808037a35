#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "arrays.hpp"
#include "background_task.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "bindings.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <mutex>
#include <numbers>
#include <optional>
#include <thread>

namespace balance::python {

// Efforts of many states in several threads, the same as in one.

/// N states, one a row; the memory is the caller's.
struct EffortRequest {
  Eigen::Map<const Samples> q, dq, ddq;
  VectorX time;  ///< per state; empty: 0 for all
};

/// InverseDynamics::effort_rows, the rows cut into as many parts as there are threads. Mechanisms with loops reach a state from the one
/// before: each part begins anew, and is computed again behind the part before where it began in another assembly mode.
/// @param is_stopped asked now and then; true: the rest is left as it is
/// @throws std::invalid_argument as InverseDynamics
EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question,
                        unsigned threads, const std::function<bool()>& is_stopped);

namespace {

constexpr Eigen::Index rows_per_poll = 8192;       // between two looks whether somebody still waits
constexpr Eigen::Index min_rows_per_thread = 512;  // a thread is not worth less

class RowRange {
 public:
  RowRange(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question, Eigen::Index begin,
           Eigen::Index end)
      : mechanism_(mechanism), question_(question), begin_(begin), end_(end), door_(mechanism, options) {}

  /// Whether the mechanism has loops and this is not the first part: then it matters how its first state was reached.
  void note_first_state() { first_ = state(begin_); }

  void run(Samples& efforts, const std::function<bool()>& is_stopped) {
    failures_.clear();
    for (Eigen::Index at = begin_; at < end_ && !is_stopped(); at += rows_per_poll) {
      const Eigen::Index count = std::min(rows_per_poll, end_ - at);
      const VectorX time = question_.time.size() == 0 ? VectorX() : VectorX(question_.time.segment(at, count));
      EffortBatch answers = door_.effort_rows(question_.q.middleRows(at, count), question_.dq.middleRows(at, count),
                                              question_.ddq.middleRows(at, count), time);
      efforts.middleRows(at, count) = answers.efforts;
      for (FailedRow& one : answers.failures) failures_.push_back({one.row + at, std::move(one.outcome)});
    }
  }

  /// Whether the part before, going on, comes to this part's first state as this part did.
  bool follows(RowRange& before) {
    const std::optional<VectorX> reached = before.state(begin_);
    return first_ && reached && is_same(*first_, *reached);
  }

  void go_on_from(RowRange& before) { door_ = std::move(before.door_); }

  std::vector<FailedRow> take_failures() { return std::move(failures_); }

 private:
  std::optional<VectorX> state(Eigen::Index row) {
    const auto found = door_.at(question_.q.row(row), question_.dq.row(row), question_.ddq.row(row),
                                question_.time.size() == 0 ? 0 : question_.time[row]);
    return found ? std::optional(found.value.position) : std::nullopt;
  }

  /// Newton's iteration leaves 1e-12; modes are as far apart as the mechanism is large.
  bool is_same(const VectorX& a, const VectorX& b) const {
    constexpr double same_mode_tolerance = 1e-6;
    const double length = characteristic_length(mechanism_);
    for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
      const double apart = a[static_cast<Eigen::Index>(i)] - b[static_cast<Eigen::Index>(i)];
      const bool angle = mechanism_.coordinates[i].kind == CoordinateKind::angle;
      if (std::abs(angle ? std::remainder(apart, 2 * std::numbers::pi) : apart / length) > same_mode_tolerance)
        return false;
    }
    return true;
  }

  const Mechanism& mechanism_;
  const EffortRequest& question_;
  Eigen::Index begin_, end_;
  InverseDynamics door_;
  std::optional<VectorX> first_;
  std::vector<FailedRow> failures_;
};

/// Runs the parts side by side, the first one here.
void run_all(std::vector<RowRange>& parts, bool loops, Samples& efforts, const std::function<bool()>& is_stopped) {
  std::vector<std::exception_ptr> troubles(parts.size());
  const auto run = [&](std::size_t k) {
    try {
      if (loops && k > 0) parts[k].note_first_state();
      parts[k].run(efforts, is_stopped);
    } catch (...) {
      troubles[k] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < parts.size(); ++k) threads.emplace_back(run, k);
    run(0);
  }
  for (const std::exception_ptr& trouble : troubles)
    if (trouble) std::rethrow_exception(trouble);
}

}  // namespace

EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& question,
                        unsigned threads, const std::function<bool()>& is_stopped) {
  const Eigen::Index rows = question.q.rows();
  const Eigen::Index count = std::clamp<Eigen::Index>(rows / min_rows_per_thread, 1, std::max(1U, threads));
  if (question.dq.rows() != rows || question.ddq.rows() != rows || (count == 1 && rows <= rows_per_poll))
    return InverseDynamics(mechanism, options).effort_rows(question.q, question.dq, question.ddq, question.time);
  const bool loops = mechanism.joints.size() + 1 > mechanism.bodies.size();
  std::vector<RowRange> parts;
  parts.reserve(static_cast<std::size_t>(count));
  for (Eigen::Index k = 0; k < count; ++k)
    parts.emplace_back(mechanism, options, question, rows * k / count, rows * (k + 1) / count);
  EffortBatch all;
  all.efforts.resize(rows, static_cast<Eigen::Index>(mechanism.actuators.size()));
  run_all(parts, loops, all.efforts, is_stopped);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (loops && k > 0 && !parts[k].follows(parts[k - 1])) {
      parts[k].go_on_from(parts[k - 1]);
      parts[k].run(all.efforts, is_stopped);
    }
    for (FailedRow& one : parts[k].take_failures()) all.failures.push_back(std::move(one));
  }
  return all;
}

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
