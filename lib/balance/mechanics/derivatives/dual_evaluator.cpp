#include "balance/mechanics/derivatives/dual_evaluator.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Parts of what a number asks of the loops that are no larger are what rounding leaves of a change that they follow: places are good to
/// 1e-13 and multiplied by the inverse of the mobility, twice.
constexpr double closure_residual_tolerance = 1e-8;

}  // namespace

template <class S>
DualEvaluator<S>::DualEvaluator(const MechanismOf<DualNumber>& mechanism, const Tree<S>& tree,
                                const std::vector<CoordinateId>& needed, const DriveQuantities& quantities,
                                bool redundant, int freedoms, const typename D::Vector& about)
    : values_(tree),
      tree_(compile_tree<D>(mechanism, needed)),
      drive_(make_drive(mechanism, tree_, quantities)),
      equations_(tree_, drive_, redundant),
      observer_(mechanism, tree_, freedoms, about),
      state_(tree_.nodes.size()) {
  const auto one_coordinate = [](const LinearQuantityOf<DualNumber>& quantity) {
    return quantity.terms.size() == 1 && quantity.terms[0].second != 0;
  };
  direct_ = tree_.closures.empty() && drive_.row_count() == static_cast<int>(drive_.linear.size()) &&
            std::all_of(drive_.linear.begin(), drive_.linear.end(), one_coordinate);
  for (auto* values : {&now_.y, &now_.dy, &now_.ddy}) values->setZero(tree_.columns);
  if (redundant) gaps_.resize(tree_.closures.size());
  x_.assign(static_cast<std::size_t>(std::max(tree_.columns, equations_.rows())), 0);
}

template <class S>
void DualEvaluator<S>::differentiate_explicit(const DriveSampleOf<DualNumber>& target) {
  for (std::size_t i = 0; i < drive_.linear.size(); ++i) {
    const auto& [column, coefficient] = drive_.linear[i].terms[0];
    const auto k = static_cast<Eigen::Index>(i);
    now_.y[column] = (target.value[k] - drive_.linear[i].constant) / coefficient;
    now_.dy[column] = target.rate[k] / coefficient;
    now_.ddy[column] = target.acceleration[k] / coefficient;
  }
}

template <class S>
void DualEvaluator<S>::differentiate_motion(const double* y, const DriveSampleOf<DualNumber>& target) {
  if (direct_) return differentiate_explicit(target);
  // a floating spherical joint counts from any constant orientation
  for (const NodeId spherical : values_.spherical_joints)
    tree_.nodes[spherical].R_PF = cast<DualNumber>(values_.nodes[spherical].R_PF);
  now_.y = Eigen::Map<const VectorX>(y, tree_.columns).template cast<DualNumber>();
  const auto fill = [&] {
    compute_poses(tree_, now_.y.data(), state_);
    equations_.evaluate(state_, now_.y.data(), target, x_.data());
  };
  fill();
  DualArray followed = max_residual_change(tree_.closure_rows);
  equations_.factorise();
  equations_.solve(x_.data());
  for (int c = 0; c < tree_.columns; ++c) now_.y[c].d = (-x_[static_cast<std::size_t>(c)]).d;
  fill();
  if (!gaps_.empty()) measure_gaps(followed);
  equations_.velocity_rhs(target, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.begin(), tree_.columns, now_.dy.begin());
  compute_angular_velocities(tree_, now_.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, now_.dy.data(), state_);
  compute_accelerations<D>(tree_, now_.dy.data(), nullptr, D::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, target, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.begin(), tree_.columns, now_.ddy.begin());
}

template <class S>
typename DualEvaluator<S>::DualArray DualEvaluator<S>::max_residual_change(int count) const {
  DualArray largest{};
  for (int r = 0; r < count; ++r)
    for (std::size_t k = 0; k < dual_width; ++k)
      largest[k] = std::max(largest[k], std::abs(x_[static_cast<std::size_t>(r)].d[k]));
  return largest;
}

/// With the coordinates' derivatives in the closures, their residuals' derivatives are what the coordinates cannot close: of redundant
/// closures the residual of least squares.
/// @param followed the largest of what each number asks for, as the equations are scaled
template <class S>
void DualEvaluator<S>::measure_gaps(const DualArray& followed) {
  DualArray asked = followed;
  for (int c = 0; c < tree_.columns; ++c)
    for (std::size_t k = 0; k < dual_width; ++k)
      asked[k] = std::max(asked[k], std::abs(now_.y[c].d[k]) / equations_.column_scale()[static_cast<std::size_t>(c)]);
  std::size_t row = 0;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    DualArray length{}, angle{};  // squares
    for (const ClosureRow& one : tree_.closures[c].rows) {
      DualArray& squares = one.kind == ClosureRow::Kind::dot ? angle : length;
      for (std::size_t k = 0; k < dual_width && !tree_.closures[c].is_velocity_level(); ++k) {
        const double left = x_[row].d[k];
        const double unscaled = left / equations_.row_scale()[row];
        if (std::abs(left) > closure_residual_tolerance * asked[k]) squares[k] += unscaled * unscaled;
      }
      ++row;
    }
    for (std::size_t k = 0; k < dual_width; ++k) {
      gaps_[c].length[k] = std::max(gaps_[c].length[k], std::sqrt(length[k]));
      gaps_[c].angle[k] = std::max(gaps_[c].angle[k], std::sqrt(angle[k]));
    }
  }
}

template <class S>
ClosureGaps DualEvaluator<S>::closure_gaps(std::size_t k) const {
  ClosureGaps all;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    if (gaps_[c].length[k] > 0) all.push_back({tree_.closures[c].joint, true, gaps_[c].length[k]});
    if (gaps_[c].angle[k] > 0) all.push_back({tree_.closures[c].joint, false, gaps_[c].angle[k]});
  }
  return all;
}

template <class S>
bool DualEvaluator<S>::evaluate(const DualNumber& time, double duration, Detail detail) {
  const TreeMotion<D> here{state_, now_.y.data(), now_.dy.data(), now_.ddy.data(), time, direct_};
  return observer_.evaluate(here, equations_, duration, detail);
}

template <class S>
DualNumber DualEvaluator<S>::mobility() {
  return direct_ ? DualNumber(1) : equations_.min_singular_value();
}

template class DualEvaluator<Planar>;
template class DualEvaluator<Spatial>;

void write_derivative(const SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail extent, Sample& out) {
  const auto number = [k](const DualNumber& x, double& to) { to = x.d[k]; };
  const auto numbers = [k](const auto& from, auto& to) {
    to.resize(from.rows(), from.cols());
    for (Eigen::Index i = 0; i < from.size(); ++i) to(i) = from(i).d[k];
  };
  const auto vectors = [&](const auto& from, std::vector<Vector3>& to) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) numbers(from[i], to[i]);
  };
  number(sample.time, out.time);
  numbers(sample.effort, out.effort);
  numbers(sample.power, out.power);
  numbers(sample.com_acceleration, out.com_acceleration);
  numbers(sample.shaking_force, out.shaking_force);
  numbers(sample.shaking_moment, out.shaking_moment);
  numbers(sample.ground_force, out.ground_force);
  numbers(sample.ground_moment, out.ground_moment);
  if (extent == DerivativeDetail::forces) return;
  numbers(sample.com_velocity, out.com_velocity);
  numbers(sample.shaking_moment_com, out.shaking_moment_com);
  vectors(sample.joint_force, out.joint_force);
  vectors(sample.joint_moment, out.joint_moment);
  number(sample.kinetic_energy, out.kinetic_energy);
  number(sample.total_torque, out.total_torque);
  number(sample.mobility, out.mobility);
  if (extent == DerivativeDetail::figures) return;
  numbers(sample.position, out.position);
  numbers(sample.velocity, out.velocity);
  numbers(sample.acceleration, out.acceleration);
  numbers(sample.com, out.com);
  numbers(sample.tool_position, out.tool_position);
  numbers(sample.tool_rotation, out.tool_rotation);
  number(sample.tool_angle, out.tool_angle);
  number(sample.potential_energy, out.potential_energy);
}

Sample derivative_of(const SampleOf<DualNumber>& sample, std::size_t k) {
  Sample out;
  write_derivative(sample, k, DerivativeDetail::all, out);
  return out;
}

}  // namespace balance
