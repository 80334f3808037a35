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

// Efforts of many states, computed in parallel with the same result as in one thread.

/// N states, one per row; the caller owns the memory.
struct EffortRequest {
  Eigen::Map<const Samples> q, dq, ddq;
  VectorX time;  ///< of each state; empty: 0 for all
};

/// InverseDynamics::effort_rows in parallel: the rows are split into one range per thread. Mechanisms with loops solve
/// each state from the previous one. If a range starts in another assembly mode than the preceding range leads to, it
/// is computed again as its continuation.
/// @param is_stopped called from time to time; if true, the remaining rows stay uninitialized
/// @throws std::invalid_argument as InverseDynamics
EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& request,
                        unsigned threads, const std::function<bool()>& is_stopped);

namespace {

constexpr Eigen::Index rows_per_poll = 8192;       // between two checks for cancellation
constexpr Eigen::Index min_rows_per_thread = 512;  // fewer do not justify a thread

class RowRange {
 public:
  RowRange(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& request, Eigen::Index begin,
           Eigen::Index end)
      : mechanism_(mechanism), request_(request), begin_(begin), end_(end), inverse_dynamics_(mechanism, options) {}

  /// Records the assembly mode of the first state. Needed with loops, except in the first range.
  void note_first_state() { first_ = state(begin_); }

  void run(Samples& efforts, const std::function<bool()>& is_stopped) {
    failures_.clear();
    for (Eigen::Index at = begin_; at < end_ && !is_stopped(); at += rows_per_poll) {
      const Eigen::Index count = std::min(rows_per_poll, end_ - at);
      const VectorX time = request_.time.size() == 0 ? VectorX() : VectorX(request_.time.segment(at, count));
      EffortBatch result =
          inverse_dynamics_.effort_rows(request_.q.middleRows(at, count), request_.dq.middleRows(at, count),
                                        request_.ddq.middleRows(at, count), time);
      efforts.middleRows(at, count) = result.efforts;
      for (dynamics::FailedRow& one : result.failures) failures_.push_back({one.row + at, std::move(one.outcome)});
    }
  }

  /// Whether the continuation of the preceding range reaches the first state in the same assembly mode.
  bool follows(RowRange& before) {
    const std::optional<VectorX> reached = before.state(begin_);
    return first_ && reached && is_same(*first_, *reached);
  }

  void continue_from(RowRange& before) { inverse_dynamics_ = std::move(before.inverse_dynamics_); }

  std::vector<dynamics::FailedRow> take_failures() { return std::move(failures_); }

 private:
  std::optional<VectorX> state(Eigen::Index row) {
    const auto sample = inverse_dynamics_.at(request_.q.row(row), request_.dq.row(row), request_.ddq.row(row),
                                             request_.time.size() == 0 ? 0 : request_.time[row]);
    return sample ? std::optional(sample.value.position) : std::nullopt;
  }

  /// Newton's method converges to 1e-12, whereas assembly modes differ by the order of the mechanism's size.
  bool is_same(const VectorX& a, const VectorX& b) const {
    constexpr double same_mode_tolerance = 1e-6;
    const double length = characteristic_length(mechanism_);
    for (std::size_t i = 0; i < mechanism_.coordinates.size(); ++i) {
      const double difference = a[static_cast<Eigen::Index>(i)] - b[static_cast<Eigen::Index>(i)];
      const bool angle = mechanism_.coordinates[i].kind == CoordinateKind::angle;
      if (std::abs(angle ? std::remainder(difference, 2 * std::numbers::pi) : difference / length) >
          same_mode_tolerance)
        return false;
    }
    return true;
  }

  const Mechanism& mechanism_;
  const EffortRequest& request_;
  Eigen::Index begin_, end_;
  InverseDynamics inverse_dynamics_;
  std::optional<VectorX> first_;
  std::vector<dynamics::FailedRow> failures_;
};

/// Runs the ranges in parallel, the first one in the calling thread.
void run_all(std::vector<RowRange>& ranges, bool loops, Samples& efforts, const std::function<bool()>& is_stopped) {
  std::vector<std::exception_ptr> exceptions(ranges.size());
  const auto run = [&](std::size_t k) {
    try {
      if (loops && k > 0) ranges[k].note_first_state();
      ranges[k].run(efforts, is_stopped);
    } catch (...) {
      exceptions[k] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < ranges.size(); ++k) threads.emplace_back(run, k);
    run(0);
  }
  for (const std::exception_ptr& exception : exceptions)
    if (exception) std::rethrow_exception(exception);
}

}  // namespace

EffortBatch effort_rows(const Mechanism& mechanism, const InverseOptions& options, const EffortRequest& request,
                        unsigned threads, const std::function<bool()>& is_stopped) {
  const Eigen::Index rows = request.q.rows();
  const Eigen::Index count = std::clamp<Eigen::Index>(rows / min_rows_per_thread, 1, std::max(1U, threads));
  if (request.dq.rows() != rows || request.ddq.rows() != rows || (count == 1 && rows <= rows_per_poll))
    return InverseDynamics(mechanism, options).effort_rows(request.q, request.dq, request.ddq, request.time);
  const bool loops = mechanism.joints.size() + 1 > mechanism.bodies.size();
  std::vector<RowRange> ranges;
  ranges.reserve(static_cast<std::size_t>(count));
  for (Eigen::Index k = 0; k < count; ++k)
    ranges.emplace_back(mechanism, options, request, rows * k / count, rows * (k + 1) / count);
  EffortBatch all;
  all.efforts.resize(rows, static_cast<Eigen::Index>(mechanism.actuators.size()));
  run_all(ranges, loops, all.efforts, is_stopped);
  for (std::size_t k = 0; k < ranges.size(); ++k) {
    if (loops && k > 0 && !ranges[k].follows(ranges[k - 1])) {
      ranges[k].continue_from(ranges[k - 1]);
      ranges[k].run(all.efforts, is_stopped);
    }
    for (dynamics::FailedRow& one : ranges[k].take_failures()) all.failures.push_back(std::move(one));
  }
  return all;
}

namespace {

/// InverseDynamics with its mechanism. It keeps state between calls, so only one thread may use it at a time.
struct InverseDynamicsHandle {
  InverseDynamicsHandle(SharedMechanism its_mechanism, InverseDynamics its_inverse)
      : mechanism(std::move(its_mechanism)), inverse(std::move(its_inverse)) {}

  SharedMechanism mechanism;
  InverseDynamics inverse;
  std::mutex mutex;

  /// Runs exclusively and without the GIL.
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

/// Represents an outcome as (status, time, reason).
py::tuple outcome_to_python(const MotionOutcome& outcome) {
  return py::make_tuple(name_of(outcome.status), outcome.time, outcome.reason);
}

py::list outcome_to_python(const std::vector<dynamics::FailedRow>& failures) {
  py::list all;
  for (const dynamics::FailedRow& one : failures) all.append(py::make_tuple(one.row, outcome_to_python(one.outcome)));
  return all;
}

/// Maps the arrays, which the caller must keep alive.
EffortRequest make_request(const Numbers& q, const Numbers& dq, const Numbers& ddq, const Numbers& time) {
  return {rows_of(q), rows_of(dq), rows_of(ddq), vector_of(time)};
}

py::tuple efforts(const std::shared_ptr<Mechanism>& mechanism, const std::vector<std::string>& independent,
                  const Numbers& q, const Numbers& dq, const Numbers& ddq, const Numbers& time, unsigned threads) {
  EffortBatch result;
  const EffortRequest request = make_request(q, dq, ddq, time);
  const InverseOptions options = options_of(independent, {});
  if (request.q.rows() <= 64) {
    const ScopedGilRelease free;  // takes less time than starting a thread
    result = InverseDynamics(*mechanism, options).effort_rows(request.q, request.dq, request.ddq, request.time);
  } else {
    result = compute_in_background(
        [mechanism, options, request, threads](BackgroundTask& task) {
          return effort_rows(*mechanism, options, request, threads, [&] { return task.is_cancelled(); });
        },
        py::none(), DetachPolicy::never);  // the work reads the caller's arrays
  }
  return py::make_tuple(owned(std::move(result.efforts)), outcome_to_python(result.failures));
}

std::shared_ptr<Run> rows(InverseDynamicsHandle& handle, const Numbers& q, const Numbers& dq, const Numbers& ddq,
                          const Numbers& time, py::list failures) {
  const EffortRequest request = make_request(q, dq, ddq, time);
  SampleBatch samples = handle.with_lock(
      [&](InverseDynamics& inverse) { return inverse.at_rows(request.q, request.dq, request.ddq, request.time); });
  for (const py::handle one : outcome_to_python(samples.failures)) failures.append(one);
  auto run = std::make_shared<Run>();
  run->result = std::move(samples.result);
  run->description.title = handle.mechanism->name;
  return run;
}

py::array matrix(const MatrixX& m) {
  Samples row_major = m;
  return owned(std::move(row_major));
}

py::tuple mass_matrix(InverseDynamicsHandle& handle, const Numbers& q) {
  const VectorX at = vector_of(q);
  const auto result = handle.with_lock([&](InverseDynamics& inverse) { return inverse.mass_matrix(at); });
  return py::make_tuple(outcome_to_python(result.outcome), matrix(result.value));
}

py::tuple bias(InverseDynamicsHandle& handle, const Numbers& q, const Numbers& dq, double time) {
  const VectorX at = vector_of(q), rate = vector_of(dq);
  const auto result = handle.with_lock([&](InverseDynamics& inverse) { return inverse.bias(at, rate, time); });
  return py::make_tuple(outcome_to_python(result.outcome), copied(result.value));
}

py::tuple regressor(InverseDynamicsHandle& handle, const Numbers& q, const Numbers& dq, const Numbers& ddq,
                    double time) {
  const VectorX at = vector_of(q), rate = vector_of(dq), acceleration = vector_of(ddq);
  const auto result =
      handle.with_lock([&](InverseDynamics& inverse) { return inverse.regressor(at, rate, acceleration, time); });
  const dynamics::EffortRegressor& r = result.value;
  py::dict all;
  py::list names;
  for (const dynamics::Parameter& one : r.parameters) names.append(one.name);
  all["parameters"] = names;
  all["values"] = copied(r.values);
  all["effort"] = matrix(r.effort);
  all["shaking_force"] = matrix(r.shaking_force);
  all["shaking_moment"] = matrix(r.shaking_moment);
  all["other"] = copied(r.constant_effort);
  return py::make_tuple(outcome_to_python(result.outcome), all);
}

py::tuple assemble(InverseDynamicsHandle& handle, const Numbers& q,
                   const std::vector<std::pair<std::string, double>>& guesses) {
  std::vector<dynamics::CoordinateGuess> values;
  for (const auto& [name, value] : guesses) values.push_back({name, value});
  const VectorX at = vector_of(q);
  const auto result = handle.with_lock([&](InverseDynamics& inverse) { return inverse.assemble(at, values); });
  return py::make_tuple(outcome_to_python(result.outcome), copied(result.value));
}

}  // namespace

void bind_states(py::module_& m) {
  m.def("efforts", &efforts, py::arg("mechanism"), py::arg("independent"), py::arg("q"), py::arg("dq"), py::arg("ddq"),
        py::arg("time"), py::arg("threads"));
  py::class_<InverseDynamicsHandle, std::shared_ptr<InverseDynamicsHandle>>(m, "Door")
      .def(py::init(&make_handle), py::arg("mechanism"), py::arg("independent"), py::arg("about"))
      .def_property_readonly("dof",
                             [](const InverseDynamicsHandle& handle) { return handle.inverse.degrees_of_freedom(); })
      .def_property_readonly("independent",
                             [](const InverseDynamicsHandle& handle) { return handle.inverse.independent(); })
      .def_property_readonly("actuators",
                             [](const InverseDynamicsHandle& handle) { return handle.inverse.actuators(); })
      .def_property_readonly("notes", [](const InverseDynamicsHandle& handle) { return handle.inverse.notes(); })
      .def("assemble", &assemble, py::arg("q"), py::arg("near"))
      .def("rows", &rows, py::arg("q"), py::arg("dq"), py::arg("ddq"), py::arg("time"), py::arg("failures"))
      .def("mass_matrix", &mass_matrix, py::arg("q"))
      .def("bias", &bias, py::arg("q"), py::arg("dq"), py::arg("time"))
      .def("regressor", &regressor, py::arg("q"), py::arg("dq"), py::arg("ddq"), py::arg("time"));
}

}  // namespace balance::python
