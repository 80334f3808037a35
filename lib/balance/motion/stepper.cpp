#include "balance/motion/stepper.hpp"

#include "balance/base/computing_time.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/kinematics/joint_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace balance {

namespace {

constexpr double solved = 1e-12;    // scaled residual after which one correction is the last
constexpr double halved = 0x1p-24;  // of a step, before it is given up

/// Columns whose coordinate changes entries of the equations' matrix.
template <class S>
std::vector<Column> columns_of_matrix(const Tree<S>& tree, const Drive<S>& drive) {
  std::set<Column> columns;
  const auto add = [&](NodeId node) {
    if (tree.nodes[node].motion != NodeMotion::weld) columns.insert(tree.nodes[node].column);
  };
  for (const Closure<S>& closure : tree.closures)
    for (const PathStep& step : closure.path) add(step.node);
  if (!drive.point.empty() || !drive.rotation.empty())
    for (const NodeId node : drive.tool_path) add(node);
  for (std::size_t node = 1; !drive.com.empty() && node < tree.nodes.size(); ++node) add(static_cast<int>(node));
  return {columns.begin(), columns.end()};
}

}  // namespace

template <class S>
Stepper<S>::Stepper(const Mechanism& mechanism, Tree<S>& tree, const Plan<S>& plan)
    : mechanism_(mechanism),
      tree_(tree),
      plan_(plan),
      equations_(tree, plan.drive, plan.redundant),
      round_off_(solved * ground_extent(mechanism)),
      state_(tree.nodes.size()),
      matrix_columns_(columns_of_matrix(tree, plan.drive)),
      passages_(mechanism, tree, plan, {&older_, &before_, &now_}) {
  const int n = tree.columns;
  for (MotionMoment* moment : {&now_, &before_, &older_, &next_})
    moment->y.setZero(n), moment->dy.setZero(n), moment->ddy.setZero(n);
  predicted_.setZero(n);
  trial_.setZero(n);
  x_.assign(std::max(n, equations_.rows()), 0);
  rates_ = x_;
  rolls_ = tree.place_rows < tree.closure_rows;
  direct_ = tree.closures.empty() && plan.drive.rows() == static_cast<int>(plan.drive.linear.size());
  for (const LinearQuantity& quantity : plan.drive.linear)
    direct_ = direct_ && quantity.terms.size() == 1 && quantity.terms[0].second != 0;
}

template <class S>
bool Stepper<S>::begin() {
  now_.y = plan_.start;
  now_.time = 0;
  past_ = 0;
  plan_.schedule->at(0, Side::after, sample_);
  if (direct_ && !equations_.structurally_singular()) {
    set_direct(0);
    return true;
  }
  rereference_spherical_joints(0.5);
  trial_ = now_.y;
  if (equations_.structurally_singular() || !newton(trial_)) {
    stop(Attempt::no_convergence, 0);
    return false;
  }
  now_.y = trial_;
  differentiate(now_);
  if (settle()) {
    passages_.begin(equations_, equations_.regularity(), hold_pivot_);
    return true;
  }
  stop(Attempt::not_held, 0);
  return false;
}

/// The watched matrices are to be compared with those of this moment.
template <class S>
bool Stepper<S>::settle() {
  equations_.keep();
  if (guard_ == nullptr) return true;
  hold_pivot_ = guard_->look(equations_);
  guard_->keep();
  return hold_pivot_ >= floor_;
}

template <class S>
void Stepper<S>::set_direct(double time) {
  now_.time = time;
  for (std::size_t k = 0; k < plan_.drive.linear.size(); ++k) {
    const LinearQuantity& quantity = plan_.drive.linear[k];
    const auto& [column, coefficient] = quantity.terms[0];
    const double inverse = 1 / coefficient;
    now_.y[column] = (sample_.value[k] - quantity.constant) * inverse;
    now_.dy[column] = sample_.rate[k] * inverse;
    now_.ddy[column] = sample_.acceleration[k] * inverse;
  }
}

template <class S>
bool Stepper<S>::newton(VectorX& y) {
  double last = INFINITY;
  for (iterations_ = 0; iterations_ <= newton_steps; ++iterations_) {
    poses(tree_, y.data(), state_);
    equations_.fill(state_, y.data(), sample_, x_.data());
    double worst = 0;
    for (int r = 0; r < equations_.rows(); ++r) worst = std::max(worst, std::abs(x_[r]));
    if (!std::isfinite(worst) || !equations_.factorise(floor_)) return false;
    equations_.rate_rows(sample_, rates_.data());
    equations_.solve_pair(x_.data(), rates_.data());
    for (int c = 0; c < tree_.columns; ++c) y[c] -= x_[c];
    // Either small, or as small as round-off allows. The last correction is too small to show in the poses, but must be
    // made: the predictor would magnify what it leaves undone.
    if (worst <= round_off_ || (worst <= 10 * round_off_ && worst >= last)) return true;
    last = worst;
  }
  return false;
}

/// Continues the polynomial through the last configurations and their two derivatives by one step: degree 2 from one, 5 from
/// two, 8 from three equidistant ones. The weights are those of Hermite interpolation.
template <class S>
void Stepper<S>::predict(double time) {
  const double h = time - now_.time;
  const auto equidistant = [h](const MotionMoment& a, const MotionMoment& b) {
    return std::abs(b.time - a.time - h) <= 1e-6 * h;
  };
  const int known = past_ < 1 || !equidistant(before_, now_) ? 1 : past_ < 2 || !equidistant(older_, before_) ? 2 : 3;
  const double hh = h * h;
  for (int c = 0; c < tree_.columns; ++c) {
    const double y = now_.y[c], v = h * now_.dy[c], a = hh * now_.ddy[c];
    if (known == 1) {
      predicted_[c] = y + v + a / 2;
      continue;
    }
    const double y1 = before_.y[c], v1 = h * before_.dy[c], a1 = hh * before_.ddy[c];
    if (known == 2) {
      predicted_[c] = 32 * y - 31 * y1 - 16 * v - 14 * v1 + 4 * a - 2 * a1;
      continue;
    }
    const double y2 = older_.y[c], v2 = h * older_.dy[c], a2 = hh * older_.ddy[c];
    predicted_[c] = 229.5 * y - 351 * y1 + 122.5 * y2 - 94.5 * v - 54 * v1 + 43.5 * v2 + 13.5 * a - 54 * a1 + 4.5 * a2;
  }
}

template <class S>
typename Stepper<S>::Attempt Stepper<S>::step(double time) {
  plan_.schedule->at(time, Side::after, sample_);
  if (direct_) {
    set_direct(time);
    return Attempt::done;
  }
  if (--evaluations_left_ < 0) return Attempt::exhausted;
  Deadline::check();
  if (!rolls_)
    predict(time);
  else if (!integrate(time))
    return evaluations_left_ < 0 ? Attempt::exhausted : Attempt::no_convergence;
  trial_ = predicted_;
  if (!newton(trial_)) return Attempt::no_convergence;
  const std::vector<double>& scale = equations_.column_scale();
  for (int c = 0; c < tree_.columns; ++c)
    if (std::abs(trial_[c] - predicted_[c]) > longest_correction * scale[c]) return Attempt::far;
  next_.time = time;
  next_.y = trial_;
  differentiate(next_);
  const Attempt attempt = judge(next_);
  return attempt == Attempt::done ? accept() : attempt;
}

/// How far the mechanism turns on the way to the next moment [rad, characteristic lengths]: the most of any coordinate that matters, by the
/// rates at both ends too, for it may turn back in between.
template <class S>
double Stepper<S>::turned(const MotionMoment& next) const {
  const double h = next.time - now_.time;
  const std::vector<double>& scale = equations_.column_scale();
  double most = 0;
  for (const Column c : matrix_columns_) {
    const double rate = std::max(std::abs(now_.dy[c]), std::abs(next.dy[c]));
    most = std::max(most, std::max(std::abs(next.y[c] - now_.y[c]), h * rate) / scale[c]);
  }
  return most;
}

/// Could a watched matrix have been singular since the present moment? The equations are those of the next one.
template <class S>
typename Stepper<S>::Attempt Stepper<S>::judge(const MotionMoment& next) {
  way_ = turned(next);
  const double curvature = way_ * way_;  // h²/8 of second derivatives, three turns in a chain
  if (!(curvature <= most_curvature * equations_.regularity()) || !equations_.near_kept(most_change))
    return Attempt::singular;
  if (guard_ != nullptr) {
    hold_pivot_ = guard_->look(equations_);
    if (!(hold_pivot_ >= floor_ && curvature <= most_curvature * hold_pivot_ && guard_->near_kept(most_change)))
      return Attempt::not_held;
    hold_approach_.see(hold_pivot_, next.time);
  }
  approach_.see(equations_.regularity(), next.time);
  return Attempt::done;
}

template <class S>
typename Stepper<S>::Attempt Stepper<S>::accept() {
  std::swap(older_, before_);
  std::swap(before_, now_);
  std::swap(now_, next_);
  past_ = std::min(past_ + 1, 2);
  passages_.see(equations_, equations_.regularity(), hold_pivot_, way_);
  if (rereference_spherical_joints(1)) {  // same configuration, other coordinates
    if (!newton(now_.y)) return Attempt::no_convergence;
    differentiate(now_);
    past_ = 0;
    if (!settle()) return Attempt::not_held;
    passages_.restart(equations_, equations_.regularity(), hold_pivot_);
    return Attempt::done;
  }
  equations_.keep();
  if (guard_ != nullptr) guard_->keep();
  return Attempt::done;
}

/// Rereferences every spherical joint whose middle angle is beyond the limit [rad]: at a right angle its coordinates fail.
template <class S>
bool Stepper<S>::rereference_spherical_joints(double limit) {
  bool any = false;
  for (const NodeId spherical : tree_.spherical_joints) {
    const double middle = std::remainder(now_.y[tree_.nodes[spherical + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    rereference(tree_, spherical, now_.y.data());
    ++references_;
    any = true;
  }
  return any;
}

template <class S>
void Stepper<S>::differentiate(MotionMoment& moment) {
  std::copy_n(rates_.data(), tree_.columns, moment.dy.data());
  angular_velocities(tree_, moment.dy.data(), state_);
  if (tree_.slides) origin_velocities(tree_, moment.dy.data(), state_);
  accelerations<S>(tree_, moment.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rows(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, moment.ddy.data());
}

template <class S>
void Stepper<S>::accelerate(Side side) {
  plan_.schedule->at(now_.time, side, sample_);
  if (direct_) return set_direct(now_.time);
  accelerations<S>(tree_, now_.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rows(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, now_.ddy.data());
  if (side == Side::after) past_ = 0;  // nothing smooth to continue
}

template <class S>
bool Stepper<S>::advance(double time) {
  Deadline::check();
  if (direct_) return step(time) == Attempt::done;
  evaluations_left_ += evaluations_per_stop;
  const double smallest = halved * std::min(time - now_.time, plan_.schedule->duration() / 1024);
  double size = std::min(time - now_.time, stride_);
  int total = 0;
  while (now_.time < time) {
    // the last piece ends exactly where it should
    double next = time - now_.time < 1.5 * size ? time : now_.time + size;
    const double longest = plan_.schedule->longest_step(now_.time);
    if (next - now_.time > (1 + 1e-6) * longest) next = now_.time + longest;
    const Attempt attempt = step(next);
    total += iterations_;
    if (attempt == Attempt::done) {
      stride_ = size *= 2;
      if (now_.time < refill_time_) continue;
      refill_time_ = now_.time + plan_.schedule->duration() / 1000;
      evaluations_left_ = std::max(evaluations_left_, max_evaluations);
    } else if (attempt == Attempt::exhausted || (size = std::min(size, next - now_.time) / 2) < smallest) {
      stop(attempt, smallest);
      return false;
    }
  }
  iterations_ = total;
  return true;
}

template class Stepper<Planar>;
template class Stepper<Spatial>;

}  // namespace balance
