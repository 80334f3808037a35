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

namespace balance::control {

void PlantOptions::validate() const {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
  };
  require(relative_tolerance > 0 && relative_tolerance <= 1e-2, "relative_tolerance must lie in (0, 0.01]");
  require(absolute_tolerance > 0, "absolute_tolerance must be positive");
  require(max_step > 0, "max_step must be positive");
  require(max_steps > 0, "max_steps must be positive");
  dynamics.validate();
}

Plant::Plant(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about) {
  options.validate();
  kinematics::dispatch_space(mechanism.space,
                             [&]<class S>(S) { implementation_ = make_plant<S>(mechanism, options, about); });
}

Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

MotionOutcome Plant::start(double time, const VectorX& position, const VectorX& velocity) {
  return implementation_->start(time, position, velocity);
}
MotionOutcome Plant::advance(double time, const VectorX& efforts) { return implementation_->advance(time, efforts); }
MotionOutcome Plant::advance(double time, const EffortProfile& effort_profile) {
  return implementation_->advance(time, effort_profile);
}
int Plant::freedoms() const { return implementation_->freedoms(); }
const std::vector<CoordinateId>& Plant::independent() const { return implementation_->independent(); }
double Plant::time() const { return implementation_->time(); }
const VectorX& Plant::position() const { return implementation_->position(); }
const VectorX& Plant::velocity() const { return implementation_->velocity(); }
VectorX Plant::acceleration(const VectorX& efforts) { return implementation_->acceleration(efforts); }
dynamics::EquationOfMotion Plant::equation() { return implementation_->equation(); }
const Sample& Plant::observe(const VectorX& efforts) { return implementation_->observe(efforts); }
const results::TermMagnitudes& Plant::term_sizes() const { return implementation_->term_sizes(); }
const results::TermMagnitudes& Plant::term_sizes_over_mobility() const {
  return implementation_->term_sizes_over_mobility();
}
const PlantCost& Plant::cost() const { return implementation_->cost(); }
const std::vector<std::string>& Plant::notes() const { return implementation_->notes(); }

namespace {

/// A start keeps the actuated coordinates unless others are preferred. Friction is not regularised.
dynamics::ForwardOptions make_plant_dynamics_options(const Mechanism& mechanism, dynamics::ForwardOptions options) {
  options.friction_regularisation_speed = 0;
  if (options.preferred.empty()) options.preferred = mechanism.actuators;
  return options;
}

/// Columns that are part of a loop.
template <class S>
std::vector<kinematics::ColumnId> find_loop_columns(const kinematics::Tree<S>& tree) {
  std::set<int> columns;
  for (const kinematics::Closure<S>& closure : tree.closures)
    for (const kinematics::PathStep& step : closure.path) columns.insert(tree.nodes[step.node].column);
  columns.erase(-1);
  return {columns.begin(), columns.end()};
}

}  // namespace

template <class S>
PlantOf<S>::PlantOf(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about)
    : mechanism_(mechanism),
      options_(options),
      about_(kinematics::to_vector<S>(about)),
      loops_(mechanism, make_plant_dynamics_options(mechanism, options.dynamics)),
      column_coordinates_(find_column_coordinates(loops_.tree())),
      matrix_columns_(find_loop_columns(loops_.tree())),
      integrator_(options.absolute_tolerance, options.relative_tolerance),
      step_(std::min(1e-3, options.max_step)) {
  const int n = loops_.columns();
  x_.assign(2 * n, 0), step_start_x_ = x_;
  y_.setZero(n), dy_.setZero(n), ddy_.setZero(n), start_ddy_.setZero(n);
  efforts_.setZero(static_cast<Eigen::Index>(mechanism.actuators.size()));
  for (const Load& load : mechanism.loads)
    if (load.is_over_time())
      load_breakpoints_.insert(load_breakpoints_.end(), load.arguments.begin(), load.arguments.end());
  std::sort(load_breakpoints_.begin(), load_breakpoints_.end());
  // coordinates that are computed from poses must not turn by half a turn between two evaluations
  updates_coordinates_each_step_ =
      !loops_.tree().spherical_joints.empty() || (S::dimension == 3 && !loops_.is_open_tree());
}

template <class S>
MotionOutcome PlantOf<S>::start(double time, const VectorX& q, const VectorX& dq) {
  const auto count = static_cast<Eigen::Index>(mechanism_.coordinates.size());
  if (q.size() != count || dq.size() != count)
    throw std::invalid_argument("a start needs a value for each of the mechanism's coordinates");
  is_started_ = false;
  MotionOutcome outcome = loops_.assemble(time, q, dq, y_, dy_);
  outcome.time = time;
  if (outcome.status != MotionStatus::done) return outcome;
  outcome = check_mass_matrix(mechanism_, loops_, time, dy_.data());
  if (outcome.status != MotionStatus::done) return outcome;
  time_ = time;
  evaluator_.emplace(mechanism_, loops_.tree(), loops_.freedoms(), about_);
  const double free_fall =
      mechanism_.gravity.norm() / loops_.tree().characteristic_length;  // acceleration of free fall
  magnitude_recorder_.emplace(mechanism_, loops_.tree(), about_, dynamics::RestScale{std::sqrt(free_fall), free_fall});
  ddy_.setZero();
  pack_state();
  step_start_x_ = x_;
  if (!choose_independent_columns(time_)) return stop(MotionStatus::constraint_singularity);
  pack_state();
  integrator_.restart();
  is_started_ = true;
  max_rate_ = 0;
  stalled_events_ = 0, event_time_ = -INFINITY;
  update_max_rate();
  make_notes();
  update_coordinates();
  evaluator_->continue_turns(q);
  position_ = evaluator_->sample().position;
  return outcome;
}

template <class S>
MotionOutcome PlantOf<S>::advance(double time, const VectorX& efforts) {
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  return advance_to(time);
}

template <class S>
MotionOutcome PlantOf<S>::advance(double time, const EffortProfile& effort_profile) {
  const VectorX efforts = effort_profile.evaluate(time_);
  require_started(efforts);
  if (efforts != efforts_) efforts_ = efforts, integrator_.restart();
  effort_profile_ = &effort_profile;
  const MotionOutcome outcome = advance_to(time);
  effort_profile_ = nullptr;
  return outcome;
}

/// Updates efforts that change over time.
template <class S>
void PlantOf<S>::update_efforts(double time) {
  if (effort_profile_ != nullptr) effort_profile_->evaluate(time, efforts_);
}

template <class S>
MotionOutcome PlantOf<S>::advance_to(double time) {
  const auto next_breakpoint = [&](const std::vector<double>& breakpoints, double end) {
    const auto breakpoint = std::upper_bound(breakpoints.begin(), breakpoints.end(), time_);
    return breakpoint != breakpoints.end() && *breakpoint < end ? *breakpoint : end;
  };
  while (time_ < time) {
    update_efforts(time_);
    if (!update_friction(efforts_)) return stop(MotionStatus::constraint_singularity);
    double end = next_breakpoint(load_breakpoints_, time);
    if (effort_profile_ != nullptr) end = next_breakpoint(effort_profile_->knots(), end);
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
  if (!is_started_) throw std::invalid_argument("the plant has not been started");
  if (efforts.size() != efforts_.size()) throw std::invalid_argument("one effort per actuator is needed");
}

/// Computes the accelerations at the current state.
template <class S>
void PlantOf<S>::evaluate(const VectorX& efforts) {
  require_started(efforts);
  update_friction(efforts);
  loops_.solve_dependent(time_, y_.data(), dy_.data());
  loops_.accelerate(time_, dy_.data(), efforts.data(), ddy_.data());
  ++cost_.evaluations;
}

template <class S>
VectorX PlantOf<S>::acceleration(const VectorX& efforts) {
  evaluate(efforts);
  evaluator_->update_coordinates(instant());
  return Eigen::Map<const VectorX>(evaluator_->sample().acceleration.data(), position_.size());
}

template <class S>
dynamics::EquationOfMotion PlantOf<S>::equation() {
  evaluate(efforts_);
  const int d = loops_.freedoms();
  dynamics::EquationOfMotion out{loops_.reduced_mass(), loops_.reduced_bias(), MatrixX::Zero(d, efforts_.size())};
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
  evaluator_->evaluate_under_efforts(instant(), efforts.data(), multipliers_);
  sample_ = evaluator_->sample();
  sample_.friction_power = loops_.friction_power(dy_.data());
  sample_.closure_residual = loops_.residual();
  sample_.mobility = loops_.mobility();
  sample_.newton_iterations = loops_.iterations();
  magnitude_recorder_->sample(instant(), evaluator_->sample(), multipliers_, sample_.mobility);
  return sample_;
}

/// Computes the joint coordinates at the current state.
template <class S>
void PlantOf<S>::update_coordinates() {
  loops_.solve_dependent(time_, y_.data(), dy_.data());
  compute_angular_velocities(loops_.tree(), dy_.data(), loops_.state());
  evaluator_->update_coordinates(instant());
  position_ = evaluator_->sample().position;
  velocity_ = evaluator_->sample().velocity;
}

template <class S>
void PlantOf<S>::make_notes() {
  notes_.clear();
  if (loops_.has_redundant_closures()) notes_.push_back(trajectory::describe_over_constraint());
  for (const model::PassiveFreedom& spin : loops_.tree().locked_freedoms)
    notes_.push_back(trajectory::describe_locked_freedom(mechanism_, spin));
}

template class PlantOf<kinematics::Planar>;
template class PlantOf<kinematics::Spatial>;

// Integration of the plant: every step ends on the closures.

namespace {

constexpr double refactor_ratio = 0.3;  // regularity, relative to that at a choice of coordinates, for a new choice
constexpr double min_integration_step_fraction = 1e-9;  // of the longest step
constexpr double singular_closure_threshold =
    1e-3;                                // regularity of the closures that explains steps too short to continue
constexpr double overflow_limit = 1e60;  // of coordinates, rates, efforts and accelerations
constexpr double redundant_residual_tolerance = 1e-9;  // residual above which redundant rows are not redundant here

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

/// Integrates all tree coordinates and rates. The dependent ones are replaced by the solution of the closures at every
/// evaluation, so that error control includes them and Newton's method starts near its solution.
template <class S>
void PlantOf<S>::derivative(const std::vector<double>& x, std::vector<double>& dxdt, double time) {
  unpack_state(x);
  ++cost_.evaluations;
  update_efforts(time);
  if (!loops_.solve_dependent(time, y_.data(), dy_.data())) throw StateRejected{};
  if (!loops_.accelerate(time, dy_.data(), efforts_.data(), ddy_.data())) throw StateRejected{};
  if (loops_.has_dry_friction() && time == time_) start_ddy_ = ddy_;
  const int n = loops_.columns();
  for (int c = 0; c < n; ++c) {
    dxdt[c] = dy_[c] / loops_.scale()[c];
    dxdt[n + c] = ddy_[c] / loops_.scale()[c];
  }
}

/// @param step the step size to try; on return, the size to try next
/// @param is_rejected on return, whether the step crosses a singularity or leads to no valid state
/// @return false if nothing has changed
template <class S>
bool PlantOf<S>::try_step(double& time, double& step, bool& is_rejected, bool& has_new_coordinates) {
  const double attempted_step = step;
  const int previous_suspect_steps = suspect_steps_;
  step_start_x_ = x_;
  is_rejected = false;
  try {
    const auto right_hand_side = [this](const std::vector<double>& x, std::vector<double>& dxdt, double t) {
      derivative(x, dxdt, t);
    };
    if (!integrator_.try_step(right_hand_side, x_, time, step)) return false;
    if (project_step(time, attempted_step, has_new_coordinates) && locate_event(attempted_step, time)) {
      loops_.store();
      suspect_steps_ = 0;
      if (loops_.has_dry_friction()) start_ddy_ = ddy_;
      return true;
    }
    restore_step_start();
  } catch (const StateRejected&) {
  }
  const bool is_suspect = suspect_steps_ > previous_suspect_steps;
  is_rejected =
      !is_suspect || previous_suspect_steps > 0;  // new independent coordinates may help where a shorter step does not
  step = attempted_step / (is_suspect ? 2 : 4);
  return false;
}

/// Restores the state after a rejected step.
template <class S>
void PlantOf<S>::restore_step_start() {
  x_ = step_start_x_;
  integrator_.restart();
  unpack_state(x_);
  if (loops_.solve_dependent(time_, y_.data(), dy_.data())) loops_.store();
}

/// Integrates to the end of a smooth interval.
template <class S>
MotionOutcome PlantOf<S>::integrate_to(double end) {
  bool has_new_coordinates =
      false;  // the independent coordinates have just been chosen, at the start of the current step
  while (time_ < end) {
    if (cost_.steps + cost_.rejected >= options_.max_steps) return stop(MotionStatus::unreachable);
    const double max_step = std::min(step_, options_.max_step), remaining = end - time_;
    const bool is_last = remaining <= max_step * (1 + 1e-9);
    const double attempted_step = is_last                     ? remaining
                                  : remaining >= 2 * max_step ? max_step
                                                              : remaining / 2;  // avoids a tiny step at the end
    double step = attempted_step, time = time_;
    bool is_rejected;
    if (try_step(time, step, is_rejected, has_new_coordinates)) {
      ++cost_.steps;
      time_ = is_last && !is_at_event_ ? end : time;
      step_ = attempted_step < max_step ? std::max(step_, step) : step;
      if (is_at_event_ && !handle_event()) return stop(MotionStatus::constraint_singularity);
      update_max_rate();
      if (loops_.reset_spherical_references(1, y_.data(), dy_.data())) {  // coordinates and rates have changed
        has_new_coordinates = choose_independent_columns(time_);
        pack_state();
        step_start_x_ = x_;
        integrator_.restart();
        if (!has_new_coordinates) return stop(MotionStatus::constraint_singularity);
      }
      if (updates_coordinates_each_step_) update_coordinates();
      continue;
    }
    ++cost_.rejected;
    step_ = step;
    unpack_state(step_start_x_);
    if (is_rejected && !has_new_coordinates) {
      if (!choose_independent_columns(time_)) return stop(MotionStatus::constraint_singularity);
      integrator_.restart();
      has_new_coordinates = true;
      step_ = attempted_step;
    } else if (step_ < std::max(min_integration_step_fraction * options_.max_step, 1e-14 * std::abs(time_))) {
      return stop(is_rejected ? MotionStatus::constraint_singularity : MotionStatus::unreachable);
    }
  }
  return {MotionStatus::done, time_, "", {}};
}

/// Projects the end of a step onto the closures. Chooses new independent coordinates if the current ones degrade.
template <class S>
bool PlantOf<S>::project_step(double time, double step, bool& has_new_coordinates) {
  unpack_state(x_);
  if (!loops_.solve_dependent(time, y_.data(), dy_.data())) return false;
  if (loops_.has_redundant_closures() && loops_.residual() > redundant_residual_tolerance) return false;
  if (can_have_crossed_singularity(step)) {
    ++suspect_steps_;
    return false;
  }
  has_new_coordinates = loops_.regularity() < refactor_ratio * loops_.regularity_at_choice();
  if (has_new_coordinates && !choose_independent_columns(time)) return false;
  pack_state();
  return true;
}

/// Whether the closures, for the current choice of coordinates, may have lost rank within a step to the last closed
/// state.
template <class S>
bool PlantOf<S>::can_have_crossed_singularity(double step) {
  double max_displacement = 0;  // of any coordinate, also by the rates at both ends, since it may reverse in between
  const int n = loops_.columns();
  for (const int c : matrix_columns_) {
    const double rate = std::max(std::abs(dy_[c]) / loops_.scale()[c], std::abs(step_start_x_[n + c]));
    max_displacement =
        std::max(max_displacement, std::max(std::abs(y_[c] / loops_.scale()[c] - step_start_x_[c]), step * rate));
  }
  return !(max_displacement * max_displacement <= numerics::max_matrix_curvature * loops_.regularity()) ||
         !loops_.near_kept(numerics::max_matrix_change);
}

template <class S>
bool PlantOf<S>::choose_independent_columns(double time) {
  const bool is_regular =
      loops_.choose_independent_columns(y_.data(), false) && loops_.solve_dependent(time, y_.data(), dy_.data());
  if (is_regular) loops_.store();
  cost_.choices = loops_.choice_count();
  return is_regular;
}

/// Whether the integration stopped because numbers exceed bounds that no mechanism reaches.
template <class S>
bool PlantOf<S>::overflows() {
  const auto exceeds = [](const VectorX& v, double bound) { return v.size() > 0 && !(numerics::max_abs(v) < bound); };
  if (exceeds(efforts_, overflow_limit) || exceeds(y_, overflow_limit) || exceeds(dy_, overflow_limit)) return true;
  if (!loops_.solve_dependent(time_, y_.data(), dy_.data())) return false;
  loops_.accelerate(time_, dy_.data(), efforts_.data(), ddy_.data());
  return exceeds(ddy_, overflow_limit);
}

template <class S>
MotionOutcome PlantOf<S>::stop(MotionStatus status) {
  unpack_state(step_start_x_);
  update_coordinates();
  if (overflows()) return trajectory::make_overflow_outcome(time_, "the motion under these efforts");
  if (status != MotionStatus::constraint_singularity &&
      (!choose_independent_columns(time_) || loops_.closure_regularity() < singular_closure_threshold))
    status = MotionStatus::constraint_singularity;
  std::string reason = "the integration cannot continue: its steps became too short";
  const std::string flat_disc = trajectory::describe_flat_disc(mechanism_, {position_.begin(), position_.end()});
  if (status == MotionStatus::constraint_singularity) {
    reason = "constraint singularity: the loop closures lose rank, the mechanism gains a freedom";
  } else if (cost_.steps + cost_.rejected >= options_.max_steps) {
    reason = "the integration has reached its limit of " + std::to_string(options_.max_steps) +
             " steps: the motion is too fast for the length of the run (stiff springs, hard control); slow it down or "
             "allow more steps";
  }
  if (!flat_disc.empty()) reason += ": " + flat_disc;
  return {status,
          time_,
          trajectory::format_time_prefix(time_) + reason +
              "; configuration: " + kinematics::format_configuration(mechanism_, position_),
          {}};
}

#define BALANCE_INSTANTIATE(S)                                                                    \
  template void PlantOf<S>::pack_state();                                                         \
  template void PlantOf<S>::unpack_state(const std::vector<double>&);                             \
  template void PlantOf<S>::derivative(const std::vector<double>&, std::vector<double>&, double); \
  template bool PlantOf<S>::try_step(double&, double&, bool&, bool&);                             \
  template MotionOutcome PlantOf<S>::integrate_to(double);                                        \
  template bool PlantOf<S>::project_step(double, double, bool&);                                  \
  template bool PlantOf<S>::can_have_crossed_singularity(double);                                 \
  template void PlantOf<S>::restore_step_start();                                                 \
  template bool PlantOf<S>::choose_independent_columns(double);                                   \
  template bool PlantOf<S>::overflows();                                                          \
  template MotionOutcome PlantOf<S>::stop(MotionStatus);
BALANCE_INSTANTIATE(kinematics::Planar)
BALANCE_INSTANTIATE(kinematics::Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance::control
