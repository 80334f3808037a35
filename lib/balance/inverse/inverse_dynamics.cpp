#include "balance/inverse/inverse_dynamics.hpp"

#include "balance/inverse/engine.hpp"
#include "balance/model/payload_stretches.hpp"
#include "balance/result/recorder.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace balance {

namespace {

std::string join_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void check_size(const char* what, const VectorX& values, const std::vector<std::string>& names) {
  if (values.size() != static_cast<Eigen::Index>(names.size()))
    throw std::invalid_argument(std::string(what) + ": expected " + std::to_string(names.size()) + " numbers for " +
                                join_names(names) + "; got " + std::to_string(values.size()));
}

void check_finite(const char* what, const VectorX& values) {
  if (!values.allFinite()) throw std::invalid_argument(std::string(what) + ": expected finite numbers");
}

void check_state(const char* what, const VectorX& values, const std::vector<std::string>& names) {
  check_size(what, values, names);
  check_finite(what, values);
}

void check_table(const char* what, const Eigen::Ref<const Samples>& values, Eigen::Index rows,
                 const std::vector<std::string>& names) {
  const auto shape = [](const std::string& count, Eigen::Index columns) {
    return "(" + count + ", " + std::to_string(columns) + ")";
  };
  const auto columns = static_cast<Eigen::Index>(names.size());
  if (values.cols() != columns || (rows >= 0 && values.rows() != rows))
    throw std::invalid_argument(std::string(what) + ": expected " +
                                shape(rows >= 0 ? std::to_string(rows) : "…", columns) + " for " + join_names(names) +
                                "; got " + shape(std::to_string(values.rows()), values.cols()));
  for (Eigen::Index k = 0; k < values.rows(); ++k)
    if (!values.row(k).allFinite())
      throw std::invalid_argument(std::string(what) + ": expected finite numbers; row " + std::to_string(k) +
                                  " has others");
}

void check_time(const VectorX& time, Eigen::Index rows) {
  if (time.size() != 0 && time.size() != rows)
    throw std::invalid_argument("time: expected " + std::to_string(rows) + " numbers or none; got " +
                                std::to_string(time.size()));
  if (!time.allFinite()) throw std::invalid_argument("time: expected finite numbers");
}

void check_time(double time) {
  if (!std::isfinite(time)) throw std::invalid_argument("time: expected a finite number");
}

std::unique_ptr<InverseDynamics::Implementation> make_inverse_dynamics(const Mechanism& mechanism,
                                                                       const InverseOptions& options) {
  require_valid(mechanism);
  if (has_temporary_payloads(mechanism))
    throw std::invalid_argument("single states need payloads that are always there");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument(
        "rates are bound (constraints, or something that rolls on a plane): independent coordinates do not tell the "
        "configuration; see EquationTerms, which is told all coordinates");
  if (!options.about.allFinite()) throw std::invalid_argument("about: expected finite numbers");
  if (!(options.time_scale > 0) || !std::isfinite(options.time_scale))
    throw std::invalid_argument("time_scale: expected a positive number");
  return dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<InverseDynamics::Implementation> {
    return std::make_unique<InverseDynamicsOf<S>>(mechanism, options);
  });
}

}  // namespace

InverseDynamics::InverseDynamics(const Mechanism& mechanism, const InverseOptions& options)
    : engine_(make_inverse_dynamics(mechanism, options)) {}
InverseDynamics::~InverseDynamics() = default;
InverseDynamics::InverseDynamics(InverseDynamics&&) noexcept = default;
InverseDynamics& InverseDynamics::operator=(InverseDynamics&&) noexcept = default;

const Mechanism& InverseDynamics::mechanism() const { return engine_->mechanism; }
int InverseDynamics::degrees_of_freedom() const { return engine_->freedoms; }
const std::vector<std::string>& InverseDynamics::independent() const { return engine_->independent; }
const std::vector<std::string>& InverseDynamics::notes() const { return engine_->notes; }

std::vector<std::string> InverseDynamics::actuators() const {
  std::vector<std::string> names;
  for (const int a : engine_->mechanism.actuators)
    names.push_back(engine_->mechanism.coordinates[static_cast<std::size_t>(a)].name);
  return names;
}

Expected<VectorX> InverseDynamics::assemble(const VectorX& q, const std::vector<CoordinateGuess>& near) {
  check_state("q", q, engine_->independent);
  std::vector<CoordinateValue> values;
  for (const CoordinateGuess& value : near) {
    if (!std::isfinite(value.value)) throw std::invalid_argument("near: expected finite numbers");
    values.push_back({require_coordinate(engine_->mechanism, value.coordinate, "near"), value.value});
  }
  Expected<VectorX> found;
  found.outcome = engine_->assemble(q.data(), values, found.value);
  return found;
}

Expected<Sample> InverseDynamics::at(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_state("ddq", ddq, engine_->independent);
  check_time(time);
  Expected<Sample> found;
  found.outcome = engine_->observe({q.data(), dq.data(), ddq.data(), time}, found.value);
  return found;
}

MotionOutcome InverseDynamics::efforts(const VectorX& q, const VectorX& dq, const VectorX& ddq, VectorX& effort,
                                       double time) {
  check_size("q", q, engine_->independent);
  check_size("dq", dq, engine_->independent);
  check_size("ddq", ddq, engine_->independent);
  const auto check_numbers = [&] { check_finite("q", q), check_finite("dq", dq), check_finite("ddq", ddq); };
  check_time(time);
  effort.resize(static_cast<Eigen::Index>(engine_->mechanism.actuators.size()));
  if (!engine_->is_fully_actuated_tree) check_numbers();
  MotionOutcome outcome = engine_->efforts({q.data(), dq.data(), ddq.data(), time}, effort.data());
  if (engine_->is_fully_actuated_tree && outcome.status != MotionStatus::done)
    check_numbers();  // the short way looks only now
  return outcome;
}

EffortBatch InverseDynamics::effort_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                                         const Eigen::Ref<const Samples>& ddq, const VectorX& time) {
  check_table("q", q, -1, engine_->independent);
  check_table("dq", dq, q.rows(), engine_->independent);
  check_table("ddq", ddq, q.rows(), engine_->independent);
  check_time(time, q.rows());
  EffortBatch table;
  table.efforts.resize(q.rows(), static_cast<Eigen::Index>(engine_->mechanism.actuators.size()));
  engine_->efforts(StateTableView{q, dq, ddq, time}, table);
  return table;
}

SampleBatch InverseDynamics::at_rows(const Eigen::Ref<const Samples>& q, const Eigen::Ref<const Samples>& dq,
                                     const Eigen::Ref<const Samples>& ddq, const VectorX& time) {
  check_table("q", q, -1, engine_->independent);
  check_table("dq", dq, q.rows(), engine_->independent);
  check_table("ddq", ddq, q.rows(), engine_->independent);
  check_time(time, q.rows());
  SampleBatch table;
  RunResult& result = table.result;
  name_columns(engine_->mechanism, result);
  resize_arrays(engine_->mechanism, q.rows(), {}, result);
  result.moment_reference = engine_->options.about;
  ResultRecorder recorder(result);
  const double none = std::numeric_limits<double>::quiet_NaN();
  Sample sample;
  const StateTableView states{q, dq, ddq, time};
  for (Eigen::Index k = 0; k < states.rows(); ++k) {
    const StateView state = states.row(k);
    MotionOutcome outcome = engine_->observe(state, sample);
    sample.time = state.time;
    if (outcome.status == MotionStatus::done) {
      recorder.write(sample, k, result);
    } else {  // the sample is the state's before, or empty
      result.time[k] = state.time;
      result.newton_iterations[k] = 0;
      for (const Quantity& quantity : list_sampled_quantities(result))
        (result.*quantity.member).row(k).setConstant(none);
      table.failures.push_back({k, std::move(outcome)});
    }
  }
  result.outcome.status = table.failures.empty() ? MotionStatus::done : table.failures.front().outcome.status;
  if (!table.failures.empty()) result.outcome.reason = table.failures.front().outcome.reason;
  result.outcome.notes = engine_->notes;
  return table;
}

Expected<MatrixX> InverseDynamics::mass_matrix(const VectorX& q) {
  check_state("q", q, engine_->independent);
  Expected<MatrixX> found;
  found.outcome = engine_->mass_matrix(q.data(), found.value);
  return found;
}

Expected<VectorX> InverseDynamics::bias(const VectorX& q, const VectorX& dq, double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_time(time);
  const VectorX still = VectorX::Zero(q.size());
  Expected<VectorX> found;
  found.outcome = engine_->bias({q.data(), dq.data(), still.data(), time}, found.value);
  return found;
}

Expected<EffortRegressor> InverseDynamics::regressor(const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                                     double time) {
  check_state("q", q, engine_->independent);
  check_state("dq", dq, engine_->independent);
  check_state("ddq", ddq, engine_->independent);
  check_time(time);
  Expected<EffortRegressor> found;
  found.outcome = engine_->regressor({q.data(), dq.data(), ddq.data(), time}, found.value);
  return found;
}

}  // namespace balance
