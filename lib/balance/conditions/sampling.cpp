#include "balance/conditions/sampling.hpp"

#include "balance/motion/plan.hpp"

#include <Eigen/SVD>

#include <cmath>
#include <numbers>

namespace balance {

namespace {

constexpr double stride = 0.2;       ///< length of a step in scaled coordinates
constexpr int strides_apart = 3;     ///< between configurations that are used
constexpr double reach = 4;          ///< slides stay within so many characteristic lengths
constexpr double ball_limit = 1.25;  ///< of a spherical joint's second angle [rad]: its coordinates degenerate at π/2
constexpr double regular = 1e-3;     ///< smallest singular value of a configuration that is used

}  // namespace

double Random::uniform(double lower, double upper) {
  // written out: the standard's distributions differ between libraries
  return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1.0p-53;
}

VectorX Random::normal(Eigen::Index size) {
  VectorX values(size);
  for (double& value : values)
    value = std::sqrt(-2 * std::log(1 - uniform(0, 1))) * std::cos(2 * std::numbers::pi * uniform(0, 1));
  return values;
}

template <class S>
Sampler<S>::Sampler(const Mechanism& mechanism, Tree<S>& tree, std::uint64_t seed)
    : mechanism_(mechanism), tree_(tree), closures_(tree, Drive<S>{}), scale_(column_scale(tree)), random_(seed) {}

template <class S>
bool Sampler<S>::next(Configuration& configuration) {
  if (tree_.closure_rows == 0) {
    configuration.y.resize(tree_.columns);
    for (int c = 0; c < tree_.columns; ++c)
      configuration.y[c] = tree_.column_kind_length[static_cast<std::size_t>(c)] == 0
                               ? random_.uniform(-std::numbers::pi, std::numbers::pi)
                               : scale_[c] * random_.uniform(-1, 1);
    configuration.null_space = MatrixX::Identity(tree_.columns, tree_.columns);
    freedoms_ = tree_.columns;
    return freedoms_ > 0;
  }
  if (!started_ && !start()) return false;
  for (int tries = 0, taken = 0; tries < 400; ++tries) {
    if (!step()) continue;
    if (++taken < strides_apart || !regular_) continue;
    configuration = {y_, null_space_};
    return true;
  }
  return false;
}

/// Into the mode that the assembly values pick, and away from a singular configuration if that is where it is.
template <class S>
bool Sampler<S>::start() {
  const Solution found = find_pose(mechanism_, tree_, closures_, {});
  if (!found.found) return false;
  y_ = found.y;
  for (const int ball : tree_.balls) rereference(tree_, ball, y_.data());
  rank_ = generic_closure_rank(tree_, y_).rank;
  freedoms_ = tree_.columns - rank_;
  if (freedoms_ == 0) return false;
  settle(y_);
  direction_ = null_space_ * random_.normal(null_space_.cols());
  direction_.normalize();
  started_ = true;
  return true;
}

/// The velocities allowed at y, and whether the configuration is a regular one.
template <class S>
bool Sampler<S>::settle(const VectorX& y) {
  VectorX residual;
  MatrixX jacobian;
  closures_.evaluate(y, {}, residual, jacobian);
  const Eigen::JacobiSVD<MatrixX> svd(jacobian, Eigen::ComputeFullV);
  const VectorX& values = svd.singularValues();
  const double smallest = rank_ > 0 ? values[rank_ - 1] / values[0] : 1;
  y_ = y;
  null_space_ = svd.matrixV().rightCols(freedoms_);
  regular_ = smallest > regular;
  return regular_;
}

/// Straight on, a little aside where there is a choice. At a singular configuration the direction kept leads through it on
/// the branch that the mechanism is on.
template <class S>
bool Sampler<S>::step() {
  const Solution moved = solve(closures_, y_ + stride * scale_.cwiseProduct(direction_), {}, 30);
  const VectorX went = (moved.y - y_).cwiseQuotient(scale_);
  const bool good = moved.found && went.dot(direction_) > 0.7 * went.norm() && went.norm() > 0.3 * stride &&
                    went.norm() < 2 * stride && !out_of_range(moved.y);
  if (!good) {
    turn(1);
    return false;
  }
  const VectorX before = direction_;
  settle(moved.y);
  direction_ = null_space_ * (null_space_.transpose() * before);
  if (direction_.norm() < 0.1) direction_ = before;  // on a singular configuration
  direction_.normalize();
  if (freedoms_ > 1) turn(0.3);
  return true;
}

/// Changes the direction at random: amount 1 forgets the old one, and with one freedom goes back.
template <class S>
void Sampler<S>::turn(double amount) {
  if (freedoms_ == 1) {
    direction_ = -direction_;
    return;
  }
  VectorX other = null_space_ * random_.normal(freedoms_);
  other.normalize();
  direction_ = (1 - amount) * direction_ + amount * other;
  direction_.normalize();
}

template <class S>
bool Sampler<S>::out_of_range(const VectorX& y) const {
  for (int c = 0; c < tree_.columns; ++c)
    if (tree_.column_kind_length[static_cast<std::size_t>(c)] != 0 && std::abs(y[c]) > reach * scale_[c]) return true;
  for (const int ball : tree_.balls) {
    const Node<S>& middle = tree_.nodes[static_cast<std::size_t>(ball) + 1];
    if (middle.motion != NodeMotion::weld && std::abs(middle.ratio * y[middle.column] + middle.offset) > ball_limit)
      return true;
  }
  return false;
}

template class Sampler<Planar>;
template class Sampler<Spatial>;

}  // namespace balance
