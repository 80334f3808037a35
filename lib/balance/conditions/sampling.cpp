#include "balance/conditions/sampling.hpp"

#include "balance/base/elementary.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/motion/missing_start.hpp"
#include "balance/motion/plan.hpp"

#include <cmath>
#include <numbers>

namespace balance {

namespace {

constexpr double longest_step = 0.2;  ///< in scaled coordinates
constexpr double apart = 0.5;         ///< way between configurations that are used
constexpr double caution = 0.5;  ///< step per smallest singular value: no step can leap over a singular configuration
constexpr double too_close =
    0.1;  ///< to a singular configuration: smallest singular value against the largest such seen
constexpr double short_step = 0.02;  ///< as long as steps get where loops are ill-conditioned everywhere
constexpr double steady =
    0.1;                     ///< change of the smallest singular value after which the next step may be twice as long
constexpr double reach = 4;  ///< slides stay within so many characteristic lengths
constexpr double spherical_limit =
    1.25;  ///< of a spherical joint's second angle [rad]: its coordinates degenerate at π/2

}  // namespace

double Random::uniform(double lower, double upper) {
  // written out: the standard's distributions differ between libraries
  return lower + (upper - lower) * static_cast<double>(bits_() >> 11) * 0x1.0p-53;
}

VectorX Random::normal(Eigen::Index size) {
  VectorX values(size);
  for (double& value : values)
    value = std::sqrt(-2 * elementary::log(1 - uniform(0, 1))) * elementary::cos(2 * std::numbers::pi * uniform(0, 1));
  return values;
}

template <class S>
Sampler<S>::Sampler(const Mechanism& mechanism, Tree<S>& tree, std::uint64_t seed)
    : mechanism_(mechanism), tree_(tree), closures_(tree, Drive<S>{}), scale_(column_scale(tree)), random_(seed) {}

template <class S>
bool Sampler<S>::next(Configuration& configuration) {
  if (tree_.place_rows == 0) {
    configuration.y.resize(tree_.columns);
    for (int c = 0; c < tree_.columns; ++c)
      configuration.y[c] = tree_.column_kind_length[static_cast<std::size_t>(c)] == 0
                               ? random_.uniform(-std::numbers::pi, std::numbers::pi)
                               : scale_[c] * random_.uniform(-1, 1);
    freedoms_ = tree_.columns - (tree_.closure_rows == 0 ? 0 : generic_closure_rank(tree_, configuration.y));
    return freedoms_ > 0 && settle(closures_, configuration.y, freedoms_, configuration);
  }
  if (!started_ && !start()) return false;
  double way = 0;
  for (int tries = 0; tries < 2000; ++tries) {
    way += step();
    if (way < apart) continue;
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
  for (const NodeId spherical : tree_.spherical_joints) rereference(tree_, spherical, y_.data());
  rank_ = generic_closure_rank(tree_, y_);
  freedoms_ = tree_.columns - rank_;
  if (freedoms_ == 0) return false;
  look(y_);
  y_ = seen_.y;
  null_space_ = seen_.null_space;
  widest_ = room_ = margin_;
  direction_ = null_space_ * random_.normal(null_space_.cols());
  direction_.normalize();
  started_ = true;
  return true;
}

/// The velocities allowed at y, and how far from losing rank the loops are there.
template <class S>
void Sampler<S>::look(const VectorX& y) {
  MatrixX jacobian;
  closures_.rates(y, {}, jacobian);
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  margin_ = rank_ > 0 ? svd.singularValues()[rank_ - 1] : longest_step / caution;
  seen_ = {y, svd.matrixV().rightCols(freedoms_)};
}

/// Straight on, a little aside where there is a choice, and never through a singular configuration, beyond which another branch
/// may begin. @return the way gone in scaled coordinates, 0 if there is none in this direction
template <class S>
double Sampler<S>::step() {
  const double careful = std::min(longest_step, caution * room_);
  const double stride = std::max(careful, std::min(short_step, careful * pace_));
  const Solution moved = solve(closures_, y_ + stride * scale_.cwiseProduct(direction_), {}, 30);
  const VectorX went = (moved.y - y_).cwiseQuotient(scale_);
  bool good = moved.found && went.dot(direction_) > 0.7 * went.norm() && went.norm() > 0.3 * stride &&
              went.norm() < 2 * stride && !out_of_range(moved.y);
  if (good) {
    look(moved.y);
    good = margin_ > too_close * widest_ || margin_ > room_;
  }
  pace_ = good && std::abs(margin_ - room_) < steady * room_ ? 2 * pace_ : 1;
  if (!good) {
    turn(1);
    return 0;
  }
  y_ = seen_.y;
  null_space_ = seen_.null_space;
  room_ = margin_;
  widest_ = std::max(widest_, room_);
  direction_ = null_space_ * (null_space_.transpose() * direction_);
  direction_.normalize();
  if (freedoms_ > 1) turn(0.3);
  return went.norm();
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
  for (const NodeId spherical : tree_.spherical_joints) {
    const Node<S>& middle = tree_.nodes[static_cast<std::size_t>(spherical) + 1];
    if (middle.motion != NodeMotion::weld &&
        std::abs(middle.ratio * y[middle.column] + middle.offset) > spherical_limit)
      return true;
  }
  return false;
}

template <class S>
bool settle(System<S>& closures, const VectorX& y, int freedoms, Configuration& here) {
  here.y = y;
  if (closures.closure_rows() == 0) {
    here.null_space = MatrixX::Identity(closures.columns(), closures.columns());
    return true;
  }
  if (closures.place_rows() > 0) {
    const Solution moved = solve(closures, y, {}, 40);
    if (!moved.found) return false;
    here.y = moved.y;
  }
  MatrixX jacobian;
  closures.rates(here.y, {}, jacobian);
  // beyond the rank the orthogonal factor spans what no row sees
  const ColumnPivotingQr qr(jacobian.transpose());
  const MatrixX q = qr.householderQ() * MatrixX::Identity(jacobian.cols(), jacobian.cols());
  here.null_space = q.rightCols(freedoms);
  return true;
}

template bool settle(System<Planar>&, const VectorX&, int, Configuration&);
template bool settle(System<Spatial>&, const VectorX&, int, Configuration&);

template <class S>
std::string Sampler<S>::obstacle() {
  const Solution start = find_pose(mechanism_, tree_, closures_, {});
  if (!start.found) return explain_missing_start(mechanism_, tree_, start, {}).reason;
  return started_ ? "too few configurations are connected to the one it is assembled in" : "the mechanism cannot move";
}

template class Sampler<Planar>;
template class Sampler<Spatial>;

}  // namespace balance
