#include "balance/motion/stepper.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/configuration_text.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance {

namespace {

constexpr double solved = 1e-12;            // scaled residual after which one correction is the last
constexpr double longest_correction = 0.1;  // of a prediction, in radians or characteristic lengths
constexpr int newton_steps = 8;
constexpr int halvings = 24;

}  // namespace

template <class S>
Stepper<S>::Stepper(const Mechanism& mechanism, Tree<S>& tree, const Plan<S>& plan)
    : mechanism_(mechanism),
      tree_(tree),
      plan_(plan),
      equations_(tree, plan.drive, plan.redundant),
      round_off_(solved * ground_extent(mechanism)),
      state_(tree.nodes.size()) {
  const int n = tree.columns;
  for (Moment* moment : {&now_, &before_, &older_}) moment->y.setZero(n), moment->dy.setZero(n), moment->ddy.setZero(n);
  predicted_.setZero(n);
  trial_.setZero(n);
  x_.assign(std::max(n, equations_.rows()), 0);
  rates_ = x_;
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
  turn_balls_back(0.5);
  trial_ = now_.y;
  if (equations_.structurally_singular() || !newton(trial_)) {
    stop(Attempt::no_convergence, 0);
    return false;
  }
  now_.y = trial_;
  sign_ = equations_.determinant_sign();
  differentiate();
  return true;
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
    if (!std::isfinite(worst) || !equations_.factorise()) return false;
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
  const auto equidistant = [h](const Moment& a, const Moment& b) { return std::abs(b.time - a.time - h) <= 1e-6 * h; };
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
  predict(time);
  trial_ = predicted_;
  if (!newton(trial_)) return Attempt::no_convergence;
  const std::vector<double>& scale = equations_.column_scale();
  for (int c = 0; c < tree_.columns; ++c)
    if (std::abs(trial_[c] - predicted_[c]) > longest_correction * scale[c]) return Attempt::far;
  if (equations_.determinant_sign() != sign_) return Attempt::flipped;
  std::swap(older_, before_);
  std::swap(before_, now_);
  past_ = std::min(past_ + 1, 2);
  now_.time = time;
  now_.y = trial_;
  if (turn_balls_back(1)) {  // same configuration, other coordinates
    if (!newton(now_.y)) return Attempt::no_convergence;
    sign_ = equations_.determinant_sign();
    past_ = 0;
  }
  differentiate();
  return Attempt::done;
}

/// Rereferences every ball whose middle angle is beyond the limit [rad]: at a right angle its coordinates fail.
template <class S>
bool Stepper<S>::turn_balls_back(double limit) {
  bool any = false;
  for (const int ball : tree_.balls) {
    const double middle = std::remainder(now_.y[tree_.nodes[ball + 1].column], 2 * std::numbers::pi);
    if (std::abs(middle) < limit) continue;
    rereference(tree_, ball, now_.y.data());
    any = true;
  }
  return any;
}

template <class S>
void Stepper<S>::differentiate() {
  std::copy_n(rates_.data(), tree_.columns, now_.dy.data());
  angular_velocities(tree_, now_.dy.data(), state_);
  if (tree_.slides) origin_velocities(tree_, now_.dy.data(), state_);
  accelerations<S>(tree_, now_.dy.data(), nullptr, S::Vector::Zero(), state_);
  equations_.acceleration_rows(state_, sample_, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.data(), tree_.columns, now_.ddy.data());
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
  Attempt attempt = step(time);
  if (attempt == Attempt::done) return true;
  const double start = now_.time;
  double size = (time - start) / 2;
  const double smallest = std::ldexp(time - start, -halvings);
  int total = iterations_;
  while (now_.time < time) {
    // the last piece ends exactly where it should
    const double next = time - now_.time < 1.5 * size ? time : now_.time + size;
    attempt = step(next);
    total += iterations_;
    if (attempt == Attempt::done) {
      size *= 2;
    } else if ((size /= 2) < smallest) {
      stop(attempt, now_.time);
      return false;
    }
  }
  iterations_ = total;
  return true;
}

template <class S>
double Stepper<S>::mobility() {
  if (direct_) return 1;
  const int rows = equations_.rows(), n = tree_.columns;
  MatrixX matrix(rows, n);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < n; ++c) matrix(r, c) = equations_.entry(r, c);
  const MatrixX normal = matrix.transpose() * matrix;
  const double smallest = Eigen::SelfAdjointEigenSolver<MatrixX>(normal, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return std::sqrt(std::max(0.0, smallest));
}

/// Which matrix has lost rank at the last good configuration?
template <class S>
void Stepper<S>::stop(Attempt attempt, double time) {
  System<S> system(tree_, plan_.drive);
  VectorX residual;
  MatrixX jacobian;
  plan_.schedule->at(std::min(time, plan_.schedule->duration()), Side::after, sample_);
  system.evaluate(now_.y, sample_, residual, jacobian);
  const int rank = tree_.columns - plan_.freedoms;
  const auto relative = [](const MatrixX& matrix, int k) {
    if (k == 0 || matrix.size() == 0) return 1.0;
    const VectorX values = Eigen::JacobiSVD<MatrixX>(matrix).singularValues();
    return values[0] > 0 ? values[k - 1] / values[0] : 0.0;
  };
  const double loops = relative(jacobian.topRows(tree_.closure_rows), rank);
  const double all = relative(jacobian, std::min<int>(tree_.columns, static_cast<int>(jacobian.rows())));
  constexpr double lost = 0.02;  // at distance ε from a singularity the values are of the order √ε
  outcome_.time = time;
  const char* what;
  if (loops < lost && loops < 10 * all) {
    outcome_.status = MotionStatus::constraint_singularity;
    what = "constraint singularity: the loop closures lose rank, the mechanism gains a freedom";
  } else if (all < lost) {
    outcome_.status = MotionStatus::drive_singularity;
    what =
        "drive singularity: the prescribed quantities no longer determine the motion (the path may leave the workspace "
        "here)";
  } else if (attempt == Attempt::no_convergence) {
    outcome_.status = MotionStatus::unreachable;
    what = "the prescribed values cannot be reached";
  } else {
    outcome_.status = MotionStatus::assembly_jump;
    what = "the motion could only go on by a jump to another assembly mode";
  }
  outcome_.reason = at_time(time) + what + "; configuration: " + configuration_text(mechanism_, tree_, now_.y.data());
}

template class Stepper<Planar>;
template class Stepper<Spatial>;

}  // namespace balance
