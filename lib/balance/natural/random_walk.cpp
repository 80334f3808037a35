#include "balance/natural/random_walk.hpp"

#include "balance/base/factorizations.hpp"

#include <cmath>

namespace balance::natural {

namespace {

constexpr double longest_step = 0.2;
constexpr double apart = 0.5;      // way between configurations that are used
constexpr double caution = 0.5;    // step per smallest singular value: none can leap over a singular configuration
constexpr double too_close = 0.1;  // to a singular one: smallest singular value against the largest such seen
constexpr double reach = 6;        // points stay within so many characteristic lengths of where they were

VectorX difference(const Coordinates& a, const Coordinates& b, int moving) {
  VectorX out(2 * moving + static_cast<Eigen::Index>(a.scalars.size()));
  for (int k = 0; k < moving; ++k) {
    const Complex d = a.points[static_cast<std::size_t>(k)] - b.points[static_cast<std::size_t>(k)];
    out[2 * k] = d.real();
    out[2 * k + 1] = d.imag();
  }
  for (std::size_t s = 0; s < a.scalars.size(); ++s)
    out[2 * moving + static_cast<Eigen::Index>(s)] = a.scalars[s] - b.scalars[s];
  return out;
}

}  // namespace

RandomWalk::RandomWalk(const Model& model) : model_(model), constraints_(model, {}) {}

bool RandomWalk::begin() {
  position_ = model_.start;
  if (!constraints_.approach(position_, VectorX())) return false;
  rank_ = generic_rank(model_, position_);
  if (rank_ == model_.unknowns() || !look(position_, motions_, margin_)) return false;
  widest_ = margin_;
  direction_ = random_direction();
  return true;
}

bool RandomWalk::look(const Coordinates& position, MatrixX& motions, double& margin) const {
  const MatrixX jacobian = constraints_.jacobian(position);
  if (!jacobian.allFinite()) return false;
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  margin = rank_ > 0 ? svd.singularValues()[rank_ - 1] : longest_step / caution;
  motions = svd.matrixV().rightCols(model_.unknowns() - rank_);
  return true;
}

VectorX RandomWalk::random_direction() {
  VectorX amounts(motions_.cols());
  // written out: the standard's distributions differ between libraries
  for (double& amount : amounts) amount = static_cast<double>(random_() >> 11) * 0x1.0p-52 - 1;
  return (motions_ * amounts).normalized();
}

bool RandomWalk::next() {
  double way = 0;
  for (int tries = 0; tries < 2000 && way < apart; ++tries) way += step();
  return way >= apart;
}

double RandomWalk::step() {
  const double stride = std::min(longest_step, caution * margin_);
  Coordinates there = position_;
  there.add(stride, direction_);
  bool good = constraints_.approach(there, VectorX());
  VectorX went;
  if (good) {
    went = difference(there, position_, model_.basic.moving);
    good = (went - stride * direction_).norm() < 0.7 * stride &&
           difference(there, model_.start, model_.basic.moving).lpNorm<Eigen::Infinity>() < reach;
  }
  MatrixX motions;
  double margin = 0;
  good = good && look(there, motions, margin) && (margin > too_close * widest_ || margin > margin_);
  if (!good) {
    turn(1);
    return 0;
  }
  position_ = there;
  motions_ = motions;
  margin_ = margin;
  widest_ = std::max(widest_, margin);
  direction_ = (motions_ * (motions_.transpose() * direction_)).normalized();
  if (motions_.cols() > 1) turn(0.3);
  return went.norm();
}

/// Amount 1 forgets the old direction, and with one freedom goes back.
void RandomWalk::turn(double amount) {
  if (motions_.cols() == 1)
    direction_ = -direction_;
  else
    direction_ = ((1 - amount) * direction_ + amount * random_direction()).normalized();
}

}  // namespace balance::natural
