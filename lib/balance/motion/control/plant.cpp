#include "balance/motion/control/plant.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/regularity.hpp"
#include "balance/mechanics/dynamics/loop_dynamics.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/motion/control/plant_impl.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace balance {

void PlantOptions::validate() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument(what);
  };
  require(relative_tolerance > 0 && relative_tolerance <= 1e-2, "relative_tolerance must lie in (0, 0.01]");
  require(absolute_tolerance > 0, "absolute_tolerance must be positive");
  require(max_step > 0, "longest_step must be positive");
  require(max_steps > 0, "most_steps must be positive");
  dynamics.validate();
}

Plant::Plant(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about) {
  options.validate();
  dispatch_space(mechanism.space, [&]<class S>(S) { engine_ = make_plant<S>(mechanism, options, about); });
}

Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

MotionOutcome Plant::start(double time, const VectorX& position, const VectorX& velocity) {
  return engine_->start(time, position, velocity);
}
MotionOutcome Plant::advance(double time, const VectorX& efforts) { return engine_->advance(time, efforts); }
MotionOutcome Plant::advance(double time, const EffortProfile& course) { return engine_->advance(time, course); }
int Plant::freedoms() const { return engine_->freedoms(); }
const std::vector<CoordinateId>& Plant::independent() const { return engine_->independent(); }
double Plant::time() const { return engine_->time(); }
const VectorX& Plant::position() const { return engine_->position(); }
const VectorX& Plant::velocity() const { return engine_->velocity(); }
VectorX Plant::acceleration(const VectorX& efforts) { return engine_->acceleration(efforts); }
EquationOfMotion Plant::equation() { return engine_->equation(); }
const Sample& Plant::observe(const VectorX& efforts) { return engine_->observe(efforts); }
const TermMagnitudes& Plant::term_sizes() const { return engine_->term_sizes(); }
const TermMagnitudes& Plant::term_sizes_over_mobility() const { return engine_->term_sizes_over_mobility(); }
const PlantCost& Plant::cost() const { return engine_->cost(); }
const std::vector<std::string>& Plant::notes() const { return engine_->notes(); }

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

// The plant's integration: one step after another, each ending on the closures.

namespace {

constexpr double refactor_ratio = 0.3;  // part of its first regularity below which a choice of coordinates is made anew
constexpr double min_integration_step_fraction = 1e-9;  // of the longest one
constexpr double singular_closure_threshold =
    1e-3;                                // regularity of the closures that explains steps too short to go on
constexpr double overflow_limit = 1e60;  // of coordinates, rates, efforts and accelerations
constexpr double redundant_residual_tolerance =
    1e-9;  // residual of redundant rows that says that they are not redundant here

}  // namespace

template <class S>
void PlantOf<S>::pack_state() {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    x_[c] = y_[c] / loops_.scale()[c];
    x_[n + c] = dy_[c] / loops_.scale()[c];
  }
}

template <class S>
void PlantOf<S>::unpack_state(const std::vector<double>& x) {
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    y_[c] = x[c] * loops_.scale()[c];
    dy_[c] = x[n + c] * loops_.scale()[c];
  }
}

/// All tree coordinates and rates are integrated, the dependent ones replaced by what the closures say at every evaluation: so
/// the error control watches them too, and Newton starts next to its solution.
template <class S>
void PlantOf<S>::derivative(const std::vector<double>& x, std::vector<double>& dxdt, double time) {
  unpack_state(x);
  ++cost_.evaluations;
  update_efforts(time);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) throw StateRejected{};
  if (!loops_.accelerate(time, dy_.data(), efforts_.data(), ddy_.data())) throw StateRejected{};
  if (loops_.has_dry_friction() && time == time_) start_ddy_ = ddy_;
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    dxdt[c] = dy_[c] / loops_.scale()[c];
    dxdt[n + c] = ddy_[c] / loops_.scale()[c];
  }
}

/// @param step as tried, on return what to try next
/// @param refused the step leads over a singularity or to no state at all
/// @return false if nothing has changed
template <class S>
bool PlantOf<S>::try_step(double& time, double& step, bool& refused, bool& fresh) {
  const double tried = step;
  const int doubts = suspect_steps_;
  last_x_ = x_;
  refused = false;
  try {
    const auto slope = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
      derivative(x, dxdt, t);
    };
    if (!integrator_.try_step(slope, x_, time, step)) return false;
    if (project_step(tried, fresh) && locate_event(tried, time)) {
      loops_.store();
      suspect_steps_ = 0;
      if (loops_.has_dry_friction()) start_ddy_ = ddy_;
      return true;
    }
    restore_step_start();
  } catch (const StateRejected&) {
  }
  const bool doubted = suspect_steps_ > doubts;
  refused = !doubted || doubts > 0;  // other independent coordinates may help where a shorter step does not
  step = tried / (doubted ? 2 : 4);
  return false;
}

/// After a step that cannot be kept.
template <class S>
void PlantOf<S>::restore_step_start() {
  x_ = last_x_;
  integrator_.restart();
  unpack_state(x_);
  if (loops_.solve_dependent(y_.data(), dy_.data())) loops_.store();
}

/// Steps to the end of a smooth piece.
template <class S>
MotionOutcome PlantOf<S>::integrate_to(double end) {
  bool fresh = false;  // the independent coordinates have just been chosen, at the state that the step starts from
  while (time_ < end) {
    if (cost_.steps + cost_.rejected >= options_.max_steps) return stop(MotionStatus::unreachable);
    const double whole = std::min(step_, options_.max_step), left = end - time_;
    const bool last = left <= whole * (1 + 1e-9);
    const double tried = last ? left : left >= 2 * whole ? whole : left / 2;  // no tiny step at the end
    double step = tried, time = time_;
    bool refused;
    if (try_step(time, step, refused, fresh)) {
      ++cost_.steps;
      time_ = last && !is_at_event_ ? end : time;
      step_ = tried < whole ? std::max(step_, step) : step;
      if (is_at_event_ && !handle_event()) return stop(MotionStatus::constraint_singularity);
      update_max_rate();
      if (loops_.reset_spherical_references(1, y_.data(), dy_.data())) {  // other coordinates, other rates
        fresh = choose_independent_columns();
        pack_state();
        last_x_ = x_;
        integrator_.restart();
        if (!fresh) return stop(MotionStatus::constraint_singularity);
      }
      if (reads_each_step_) update_coordinates();
      continue;
    }
    ++cost_.rejected;
    step_ = step;
    unpack_state(last_x_);
    if (refused && !fresh) {
      if (!choose_independent_columns()) return stop(MotionStatus::constraint_singularity);
      integrator_.restart();
      fresh = true;
      step_ = tried;
    } else if (step_ < std::max(min_integration_step_fraction * options_.max_step, 1e-14 * std::abs(time_))) {
      return stop(refused ? MotionStatus::constraint_singularity : MotionStatus::unreachable);
    }
  }
  return {MotionStatus::done, time_, "", {}};
}

/// After a step: the dependent coordinates as the closures have them; new independent ones where the present ones wear out.
template <class S>
bool PlantOf<S>::project_step(double step, bool& fresh) {
  unpack_state(x_);
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  if (loops_.has_redundant_closures() && loops_.residual() > redundant_residual_tolerance) return false;
  if (can_have_crossed_singularity(step)) {
    ++suspect_steps_;
    return false;
  }
  fresh = loops_.regularity() < refactor_ratio * loops_.regularity_at_choice();
  if (fresh && !choose_independent_columns()) return false;
  pack_state();
  return true;
}

/// Could the closures, for the present choice of coordinates, have lost rank within a step that led to the state last closed?
template <class S>
bool PlantOf<S>::can_have_crossed_singularity(double step) {
  double way = 0;  // of any coordinate, by the rates at both ends too, for it may turn back in between
  const int n = loops_.columns();
  for (const int c : matrix_columns_) {
    const double rate = std::max(std::abs(dy_[c]) / loops_.scale()[c], std::abs(last_x_[n + c]));
    way = std::max(way, std::max(std::abs(y_[c] / loops_.scale()[c] - last_x_[c]), step * rate));
  }
  return !(way * way <= max_matrix_curvature * loops_.regularity()) || !loops_.near_kept(max_matrix_change);
}

template <class S>
bool PlantOf<S>::choose_independent_columns() {
  const bool good =
      loops_.choose_independent_columns(y_.data(), false) && loops_.solve_dependent(y_.data(), dy_.data());
  if (good) loops_.store();
  cost_.choices = loops_.choice_count();
  return good;
}

/// Whether what stopped the integration are numbers beyond bounds that no mechanism has.
template <class S>
bool PlantOf<S>::overflows() {
  const auto beyond = [](const VectorX& v, double bound) { return v.size() > 0 && !(max_abs(v) < bound); };
  if (beyond(efforts_, overflow_limit) || beyond(y_, overflow_limit) || beyond(dy_, overflow_limit)) return true;
  if (!loops_.solve_dependent(y_.data(), dy_.data())) return false;
  loops_.accelerate(time_, dy_.data(), efforts_.data(), ddy_.data());
  return beyond(ddy_, overflow_limit);
}

template <class S>
MotionOutcome PlantOf<S>::stop(MotionStatus status) {
  unpack_state(last_x_);
  update_coordinates();
  if (overflows()) return make_overflow_outcome(time_, "the motion under these efforts");
  if (status != MotionStatus::constraint_singularity &&
      (!choose_independent_columns() || loops_.closure_regularity() < singular_closure_threshold))
    status = MotionStatus::constraint_singularity;
  std::string what = "the integration needs steps that are too short to go on";
  const std::string flat = describe_flat_disc(mechanism_, {position_.begin(), position_.end()});
  if (status == MotionStatus::constraint_singularity) {
    what = "constraint singularity: the loop closures lose rank, the mechanism gains a freedom";
  } else if (cost_.steps + cost_.rejected >= options_.max_steps) {
    what = "the integration has taken the " + std::to_string(options_.max_steps) +
           " steps that it may take: the motion is faster than the run is long (stiff springs, hard control), or more "
           "steps must be allowed";
  }
  if (!flat.empty()) what += ": " + flat;
  return {status,
          time_,
          format_time_prefix(time_) + what + "; configuration: " + format_configuration(mechanism_, position_),
          {}};
}

#define BALANCE_INSTANTIATE(S)                                                                    \
  template void PlantOf<S>::pack_state();                                                         \
  template void PlantOf<S>::unpack_state(const std::vector<double>&);                             \
  template void PlantOf<S>::derivative(const std::vector<double>&, std::vector<double>&, double); \
  template bool PlantOf<S>::try_step(double&, double&, bool&, bool&);                             \
  template MotionOutcome PlantOf<S>::integrate_to(double);                                        \
  template bool PlantOf<S>::project_step(double, bool&);                                          \
  template bool PlantOf<S>::can_have_crossed_singularity(double);                                 \
  template void PlantOf<S>::restore_step_start();                                                 \
  template bool PlantOf<S>::choose_independent_columns();                                         \
  template bool PlantOf<S>::overflows();                                                          \
  template MotionOutcome PlantOf<S>::stop(MotionStatus);
BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
