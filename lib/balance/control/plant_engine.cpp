#include "balance/control/plant_engine.hpp"

#include "balance/control/massless_freedom.hpp"
#include "balance/control/tree_state.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace balance {

namespace {

/// A start keeps the actuated coordinates unless something else is preferred. Friction is the true one.
ForwardOptions make_plant_dynamics_options(const Mechanism& mechanism, ForwardOptions options) {
  options.friction_regularisation_speed = 0;
  if (options.preferred.empty()) options.preferred = mechanism.actuators;
  return options;
}

/// Columns that take part in a loop.
template <class S>
std::vector<ColumnId> find_loop_columns(const Tree<S>& tree) {
  std::set<int> columns;
  for (const Closure<S>& closure : tree.closures)
    for (const PathStep& step : closure.path) columns.insert(tree.nodes[step.node].column);
  columns.erase(-1);
  return {columns.begin(), columns.end()};
}

}  // namespace

template <class S>
PlantOf<S>::PlantOf(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about)
    : mechanism_(mechanism),
      options_(options),
      about_(to_vector<S>(about)),
      loops_(mechanism, make_plant_dynamics_options(mechanism, options.dynamics)),
      column_coordinates_(find_column_coordinates(loops_.tree())),
      matrix_columns_(find_loop_columns(loops_.tree())),
      integrator_(options.absolute_tolerance, options.relative_tolerance),
      step_(std::min(1e-3, options.max_step)) {
  const int n = loops_.columns();
  x_.assign(2 * n, 0), last_x_ = x_;
  y_.setZero(n), dy_.setZero(n), ddy_.setZero(n), start_ddy_.setZero(n);
  efforts_.setZero(static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (const Load& load : mechanism.loads)
    load_breakpoints_.insert(load_breakpoints_.end(), load.time.begin(), load.time.end());
  std::sort(load_breakpoints_.begin(), load_breakpoints_.end());
  // coordinates that are read off poses must not turn by half a turn between two looks
  reads_each_step_ = !loops_.tree().spherical_joints.empty() || (S::dimension == 3 && !loops_.is_open_tree());
}

template <class S>
MotionOutcome PlantOf<S>::start(double time, const VectorX& q, const VectorX& dq) {
  const auto count = static_cast<Eigen::Index>(mechanism_.coordinates.size());
  if (q.size() != count || dq.size() != count)
    throw std::invalid_argument("a start needs a value for each of the mechanism's coordinates");
  started_ = false;
  MotionOutcome outcome = loops_.assemble(q, dq, y_, dy_);
  outcome.time = time;
  if (outcome.status != MotionStatus::done) return outcome;
  outcome = check_mass_matrix(mechanism_, loops_, time, dy_.data());
  if (outcome.status != MotionStatus::done) return outcome;
  time_ = time;
  observer_.emplace(mechanism_, loops_.tree(), loops_.freedoms(), about_);
  const double fall = mechanism_.gravity.norm() / loops_.tree().characteristic_length;  // of what is let go
  meter_.emplace(mechanism_, loops_.tree(), about_, RestScale{std::sqrt(fall), fall});
  ddy_.setZero();
  pack_state();
  last_x_ = x_;
  if (!choose_independent_columns()) return stop(MotionStatus::constraint_singularity);
  pack_state();
  integrator_.restart();
  started_ = true;
  max_rate_ = 0;
  stalled_events_ = 0, event_time_ = -INFINITY;
  update_max_rate();
  make_notes();
  update_coordinates();
  return outcome;
}

template <class S>
MotionOutcome PlantOf<S>::advance(double time, const VectorX& efforts) {
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  return advance_to(time);
}

template <class S>
MotionOutcome PlantOf<S>::advance(double time, const EffortProfile& course) {
  const VectorX efforts = course.evaluate(time_);
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  effort_profile_ = &course;
  const MotionOutcome outcome = advance_to(time);
  effort_profile_ = nullptr;
  return outcome;
}

/// The efforts of a moment, where they change.
template <class S>
void PlantOf<S>::update_efforts(double time) {
  if (effort_profile_ != nullptr) effort_profile_->evaluate(time, efforts_);
}

template <class S>
MotionOutcome PlantOf<S>::advance_to(double time) {
  const auto next = [&](const std::vector<double>& kinks, double end) {
    const auto kink = std::upper_bound(kinks.begin(), kinks.end(), time_);
    return kink != kinks.end() && *kink < end ? *kink : end;
  };
  while (time_ < time) {
    update_efforts(time_);
    if (!update_friction(efforts_)) return stop(MotionStatus::constraint_singularity);
    double end = next(load_breakpoints_, time);
    if (effort_profile_ != nullptr) end = next(effort_profile_->knots(), end);
    const MotionOutcome outcome = integrate_to(end);
    if (outcome.status != MotionStatus::done) return outcome;
    if (end != time) integrator_.restart();
  }
  update_efforts(time_);
  update_coordinates();
  return {MotionStatus::done, time_, "", {}};
}

template <class S>
const std::vector<CoordinateId>& PlantOf<S>::independent() {
  independent_.clear();
  for (const int column : loops_.independent()) independent_.push_back(column_coordinates_[column]);
  return independent_;
}

template <class S>
void PlantOf<S>::require_started(const VectorX& efforts) const {
  if (!started_) throw std::invalid_argument("the plant has not been started");
  if (efforts.size() != efforts_.size()) throw std::invalid_argument("one effort per actuator is needed");
}

/// Accelerations at the present state.
template <class S>
void PlantOf<S>::evaluate(const VectorX& efforts) {
  require_started(efforts);
  update_friction(efforts);
  loops_.solve_dependent(y_.data(), dy_.data());
  loops_.accelerate(time_, dy_.data(), efforts.data(), ddy_.data());
  ++cost_.evaluations;
}

template <class S>
VectorX PlantOf<S>::acceleration(const VectorX& efforts) {
  evaluate(efforts);
  observer_->update_coordinates(instant());
  return Eigen::Map<const VectorX>(observer_->sample().acceleration.data(), position_.size());
}

template <class S>
EquationOfMotion PlantOf<S>::equation() {
  evaluate(efforts_);
  const int d = loops_.freedoms();
  EquationOfMotion out{loops_.reduced_mass(), loops_.reduced_bias(), MatrixX::Zero(d, efforts_.size())};
  for (Eigen::Index a = 0; a < efforts_.size(); ++a) {
    for (const auto& [column, ratio] : loops_.tree().coordinate_expressions[mechanism_.actuators[a]].terms)
      for (int k = 0; k < d; ++k) out.input(k, a) += ratio * loops_.transformation()[column * d + k];
  }
  return out;
}

template <class S>
const Sample& PlantOf<S>::observe(const VectorX& efforts) {
  evaluate(efforts);
  loops_.add_sticking_friction(efforts.data(), ddy_.data());
  loops_.multipliers(efforts.data(), ddy_.data(), y_.data(), multipliers_);
  observer_->evaluate_under_efforts(instant(), efforts.data(), multipliers_);
  sample_ = observer_->sample();
  sample_.friction_power = loops_.friction_power(dy_.data());
  sample_.closure_residual = loops_.residual();
  sample_.mobility = loops_.mobility();
  sample_.newton_iterations = loops_.iterations();
  meter_->sample(instant(), observer_->sample(), multipliers_, sample_.mobility);
  return sample_;
}

/// Reads the joint coordinates at the present state.
template <class S>
void PlantOf<S>::update_coordinates() {
  loops_.solve_dependent(y_.data(), dy_.data());
  compute_angular_velocities(loops_.tree(), dy_.data(), loops_.state());
  observer_->update_coordinates(instant());
  position_ = observer_->sample().position;
  velocity_ = observer_->sample().velocity;
}

template <class S>
void PlantOf<S>::make_notes() {
  notes_.clear();
  if (loops_.has_redundant_closures()) notes_.push_back(describe_over_constraint());
  for (const PassiveFreedom& spin : loops_.tree().locked_freedoms)
    notes_.push_back(describe_locked_freedom(mechanism_, spin));
}

template class PlantOf<Planar>;
template class PlantOf<Spatial>;

}  // namespace balance
