#include "balance/natural/random_walk.hpp"

#include "balance/base/factorizations.hpp"

#include <cmath>

namespace balance::natural {

namespace {

constexpr double max_step = 0.2;
constexpr double min_configuration_distance = 0.5;  // way between configurations that are used
constexpr double step_per_singular_value =
    0.5;  // step per smallest singular value: none can leap over a singular configuration
constexpr double min_margin_ratio = 0.1;  // to a singular one: smallest singular value against the largest such seen
constexpr double max_point_distance = 6;  // points stay within so many characteristic lengths of where they were

VectorX subtract_coordinates(const NaturalCoordinates& a, const NaturalCoordinates& b, int moving) {
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

RandomWalk::RandomWalk(const NaturalModel& model) : model_(model), constraints_(model, {}) {}

bool RandomWalk::begin() {
  position_ = model_.start;
  if (!constraints_.solve_least_norm(position_, VectorX())) return false;
  rank_ = find_generic_constraint_rank(model_, position_);
  if (rank_ == model_.unknowns() || !compute_motions(position_, motions_, margin_)) return false;
  max_margin_ = margin_;
  direction_ = random_direction();
  return true;
}

bool RandomWalk::compute_motions(const NaturalCoordinates& position, MatrixX& motions, double& margin) const {
  const MatrixX jacobian = constraints_.jacobian(position);
  if (!jacobian.allFinite()) return false;
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  margin = rank_ > 0 ? svd.singularValues()[rank_ - 1] : max_step / step_per_singular_value;
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
  for (int tries = 0; tries < 2000 && way < min_configuration_distance; ++tries) way += step();
  return way >= min_configuration_distance;
}

double RandomWalk::step() {
  const double stride = std::min(max_step, step_per_singular_value * margin_);
  NaturalCoordinates there = position_;
  there.add(stride, direction_);
  bool good = constraints_.solve_least_norm(there, VectorX());
  VectorX went;
  if (good) {
    went = subtract_coordinates(there, position_, model_.basic.moving);
    good =
        (went - stride * direction_).norm() < 0.7 * stride &&
        subtract_coordinates(there, model_.start, model_.basic.moving).lpNorm<Eigen::Infinity>() < max_point_distance;
  }
  MatrixX motions;
  double margin = 0;
  good =
      good && compute_motions(there, motions, margin) && (margin > min_margin_ratio * max_margin_ || margin > margin_);
  if (!good) {
    perturb_direction(1);
    return 0;
  }
  position_ = there;
  motions_ = motions;
  margin_ = margin;
  max_margin_ = std::max(max_margin_, margin);
  direction_ = (motions_ * (motions_.transpose() * direction_)).normalized();
  if (motions_.cols() > 1) perturb_direction(0.3);
  return went.norm();
}

/// Amount 1 forgets the old direction, and with one freedom goes back.
void RandomWalk::perturb_direction(double amount) {
  if (motions_.cols() == 1)
    direction_ = -direction_;
  else
    direction_ = ((1 - amount) * direction_ + amount * random_direction()).normalized();
}

}  // namespace balance::natural
