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
ForwardOptions with_actuated(const Mechanism& mechanism, ForwardOptions options) {
  options.friction_width = 0;
  if (options.preferred.empty()) options.preferred = mechanism.actuators;
  return options;
}

/// Columns that take part in a loop.
template <class S>
std::vector<Column> columns_in_loops(const Tree<S>& tree) {
  std::set<int> columns;
  for (const Closure<S>& closure : tree.closures)
    for (const PathStep& step : closure.path) columns.insert(tree.nodes[step.node].column);
  columns.erase(-1);
  return {columns.begin(), columns.end()};
}

}  // namespace

template <class S>
EngineOf<S>::EngineOf(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about)
    : mechanism_(mechanism),
      options_(options),
      about_(to_vector<S>(about)),
      loops_(mechanism, with_actuated(mechanism, options.dynamics)),
      leaders_(leaders(loops_.tree())),
      matrix_columns_(columns_in_loops(loops_.tree())),
      integrator_(options.absolute_tolerance, options.relative_tolerance),
      step_(std::min(1e-3, options.longest_step)) {
  const int n = loops_.columns();
  x_.assign(2 * n, 0), last_x_ = x_;
  y_.setZero(n), dy_.setZero(n), ddy_.setZero(n), start_ddy_.setZero(n);
  efforts_.setZero(static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (const Load& load : mechanism.loads) kinks_.insert(kinks_.end(), load.time.begin(), load.time.end());
  std::sort(kinks_.begin(), kinks_.end());
  // coordinates that are read off poses must not turn by half a turn between two looks
  reads_each_step_ = !loops_.tree().spherical_joints.empty() || (S::dimension == 3 && !loops_.open_tree());
}

template <class S>
MotionOutcome EngineOf<S>::start(double time, const VectorX& q, const VectorX& dq) {
  const auto count = static_cast<Eigen::Index>(mechanism_.coordinates.size());
  if (q.size() != count || dq.size() != count)
    throw std::invalid_argument("a start needs a value for each of the mechanism's coordinates");
  started_ = false;
  MotionOutcome outcome = loops_.assemble(q, dq, y_, dy_);
  outcome.time = time;
  if (outcome.status != MotionStatus::done) return outcome;
  outcome = check_masses(mechanism_, loops_, time, dy_.data());
  if (outcome.status != MotionStatus::done) return outcome;
  time_ = time;
  observer_.emplace(mechanism_, loops_.tree(), loops_.freedoms(), about_);
  const double fall = mechanism_.gravity.norm() / loops_.tree().length;  // of what is let go
  meter_.emplace(mechanism_, loops_.tree(), about_, RestScale{std::sqrt(fall), fall});
  ddy_.setZero();
  store();
  last_x_ = x_;
  if (!choose_anew()) return stop(MotionStatus::constraint_singularity);
  store();
  integrator_.restart();
  started_ = true;
  fastest_ = 0;
  events_here_ = 0, event_time_ = -INFINITY;
  grow_fastest();
  make_notes();
  follow();
  return outcome;
}

template <class S>
MotionOutcome EngineOf<S>::advance(double time, const VectorX& efforts) {
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  return advance_to(time);
}

template <class S>
MotionOutcome EngineOf<S>::advance(double time, const EffortCourse& course) {
  const VectorX efforts = course.at(time_);
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  course_ = &course;
  const MotionOutcome outcome = advance_to(time);
  course_ = nullptr;
  return outcome;
}

/// The efforts of a moment, where they change.
template <class S>
void EngineOf<S>::push(double time) {
  if (course_ != nullptr) course_->at(time, efforts_);
}

template <class S>
MotionOutcome EngineOf<S>::advance_to(double time) {
  const auto next = [&](const std::vector<double>& kinks, double end) {
    const auto kink = std::upper_bound(kinks.begin(), kinks.end(), time_);
    return kink != kinks.end() && *kink < end ? *kink : end;
  };
  while (time_ < time) {
    push(time_);
    if (!settle_friction(efforts_)) return stop(MotionStatus::constraint_singularity);
    double end = next(kinks_, time);
    if (course_ != nullptr) end = next(course_->knots(), end);
    const MotionOutcome outcome = go(end);
    if (outcome.status != MotionStatus::done) return outcome;
    if (end != time) integrator_.restart();
  }
  push(time_);
  follow();
  return {MotionStatus::done, time_, "", {}};
}

template <class S>
const std::vector<CoordinateId>& EngineOf<S>::independent() {
  independent_.clear();
  for (const int column : loops_.independent()) independent_.push_back(leaders_[column]);
  return independent_;
}

template <class S>
void EngineOf<S>::require_started(const VectorX& efforts) const {
  if (!started_) throw std::invalid_argument("the plant has not been started");
  if (efforts.size() != efforts_.size()) throw std::invalid_argument("one effort per actuator is needed");
}

/// Accelerations at the present state.
template <class S>
void EngineOf<S>::evaluate(const VectorX& efforts) {
  require_started(efforts);
  settle_friction(efforts);
  loops_.close(y_.data(), dy_.data());
  loops_.accelerate(time_, dy_.data(), efforts.data(), ddy_.data());
  ++cost_.evaluations;
}

template <class S>
VectorX EngineOf<S>::acceleration(const VectorX& efforts) {
  evaluate(efforts);
  observer_->follow(instant());
  return Eigen::Map<const VectorX>(observer_->last().acceleration.data(), position_.size());
}

template <class S>
EquationOfMotion EngineOf<S>::equation() {
  evaluate(efforts_);
  const int d = loops_.freedoms();
  EquationOfMotion out{loops_.reduced_mass(), loops_.reduced_bias(), MatrixX::Zero(d, efforts_.size())};
  for (Eigen::Index a = 0; a < efforts_.size(); ++a) {
    for (const auto& [column, ratio] : loops_.tree().sources[mechanism_.actuators[a]].terms)
      for (int k = 0; k < d; ++k) out.input(k, a) += ratio * loops_.transformation()[column * d + k];
  }
  return out;
}

template <class S>
const Sample& EngineOf<S>::observe(const VectorX& efforts) {
  evaluate(efforts);
  loops_.add_stuck_friction(efforts.data(), ddy_.data());
  loops_.multipliers(efforts.data(), ddy_.data(), y_.data(), multipliers_);
  observer_->observe_under(instant(), efforts.data(), multipliers_);
  sample_ = observer_->last();
  sample_.friction_power = loops_.friction_power(dy_.data());
  sample_.closure = loops_.residual();
  sample_.mobility = loops_.mobility();
  sample_.newton_iterations = loops_.iterations();
  meter_->see(instant(), observer_->last(), multipliers_, sample_.mobility);
  return sample_;
}

/// Reads the joint coordinates at the present state.
template <class S>
void EngineOf<S>::follow() {
  loops_.close(y_.data(), dy_.data());
  angular_velocities(loops_.tree(), dy_.data(), loops_.state());
  observer_->follow(instant());
  position_ = observer_->last().position;
  velocity_ = observer_->last().velocity;
}

template <class S>
void EngineOf<S>::make_notes() {
  notes_.clear();
  if (loops_.redundant()) notes_.push_back(over_constrained());
  for (const PassiveFreedom& spin : loops_.tree().locked_freedoms) notes_.push_back(locked_freedom(mechanism_, spin));
}

template class EngineOf<Planar>;
template class EngineOf<Spatial>;

}  // namespace balance
