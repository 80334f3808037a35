#include "balance/mechanics/derivatives/dual_evaluator.hpp"

#include <algorithm>
#include <cmath>

namespace balance::derivatives {

namespace {

/// Residual of a closure's derivative, relative to the change that a variable demands, up to which the loops follow the
/// variable. Positions are accurate to 1e-13, and the inverse of the mobility amplifies the error twice.
constexpr double closure_residual_tolerance = 1e-8;

}  // namespace

template <class S>
DualEvaluator<S>::DualEvaluator(const MechanismOf<DualNumber>& mechanism, const kinematics::Tree<S>& tree,
                                const std::vector<CoordinateId>& needed, const trajectory::DriveQuantities& quantities,
                                bool redundant, int freedoms, const typename D::Vector& about)
    : values_(tree),
      tree_(kinematics::compile_tree<D>(mechanism, needed)),
      drive_(make_drive(mechanism, tree_, quantities)),
      equations_(tree_, drive_, redundant),
      sample_evaluator_(mechanism, tree_, freedoms, about),
      state_(tree_.nodes.size()) {
  const auto is_single_coordinate = [](const kinematics::LinearQuantityOf<DualNumber>& quantity) {
    return quantity.terms.size() == 1 && quantity.terms[0].second != 0;
  };
  is_explicit_ = tree_.closures.empty() && drive_.row_count() == static_cast<int>(drive_.linear.size()) &&
                 std::all_of(drive_.linear.begin(), drive_.linear.end(), is_single_coordinate);
  for (auto* values : {&coordinates_.y, &coordinates_.dy, &coordinates_.ddy}) values->setZero(tree_.columns);
  if (redundant) gaps_.resize(tree_.closures.size());
  x_.assign(static_cast<std::size_t>(std::max(tree_.columns, equations_.rows())), 0);
}

template <class S>
void DualEvaluator<S>::differentiate_explicit(const trajectory::DriveSampleOf<DualNumber>& target) {
  for (std::size_t i = 0; i < drive_.linear.size(); ++i) {
    const auto& [column, coefficient] = drive_.linear[i].terms[0];
    const auto k = static_cast<Eigen::Index>(i);
    coordinates_.y[column] = (target.value[k] - drive_.linear[i].constant) / coefficient;
    coordinates_.dy[column] = target.rate[k] / coefficient;
    coordinates_.ddy[column] = target.acceleration[k] / coefficient;
  }
}

template <class S>
void DualEvaluator<S>::differentiate_motion(const double* y, const trajectory::DriveSampleOf<DualNumber>& target) {
  if (is_explicit_) return differentiate_explicit(target);
  // the reference orientation of a floating spherical joint is an arbitrary constant
  for (const kinematics::NodeId spherical : values_.spherical_joints)
    tree_.nodes[spherical].R_PF = kinematics::cast<DualNumber>(values_.nodes[spherical].R_PF);
  coordinates_.y = Eigen::Map<const VectorX>(y, tree_.columns).template cast<DualNumber>();
  const auto fill = [&] {
    compute_poses(tree_, coordinates_.y.data(), state_);
    equations_.evaluate(state_, coordinates_.y.data(), target, x_.data());
  };
  fill();
  DualArray initial_change = max_residual_change(tree_.closure_rows);
  equations_.factorise();
  equations_.solve(x_.data());
  for (int c = 0; c < tree_.columns; ++c) coordinates_.y[c].d = (-x_[static_cast<std::size_t>(c)]).d;
  fill();
  if (!gaps_.empty()) measure_gaps(initial_change);
  equations_.velocity_rhs(target, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.begin(), tree_.columns, coordinates_.dy.begin());
  compute_angular_velocities(tree_, coordinates_.dy.data(), state_);
  if (tree_.has_sliding_closures) compute_origin_velocities(tree_, coordinates_.dy.data(), state_);
  kinematics::compute_accelerations<D>(tree_, coordinates_.dy.data(), nullptr, D::Vector::Zero(), state_);
  equations_.acceleration_rhs(state_, target, x_.data());
  equations_.solve(x_.data());
  std::copy_n(x_.begin(), tree_.columns, coordinates_.ddy.begin());
}

template <class S>
typename DualEvaluator<S>::DualArray DualEvaluator<S>::max_residual_change(int count) const {
  DualArray largest{};
  for (int r = 0; r < count; ++r)
    for (std::size_t k = 0; k < numerics::dual_width; ++k)
      largest[k] = std::max(largest[k], std::abs(x_[static_cast<std::size_t>(r)].d[k]));
  return largest;
}

/// Once the coordinates' derivatives are inserted, the derivatives of the closure residuals are what the coordinates
/// cannot close: for redundant closures, the least-squares residual.
/// @param initial_change per variable: the largest scaled change of a closure residual before the coordinates follow
template <class S>
void DualEvaluator<S>::measure_gaps(const DualArray& initial_change) {
  DualArray demanded_change = initial_change;
  for (int c = 0; c < tree_.columns; ++c)
    for (std::size_t k = 0; k < numerics::dual_width; ++k)
      demanded_change[k] = std::max(demanded_change[k], std::abs(coordinates_.y[c].d[k]) /
                                                            equations_.column_scale()[static_cast<std::size_t>(c)]);
  std::size_t row = 0;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    DualArray length{}, angle{};  // squared
    for (const kinematics::ClosureRow& closure_row : tree_.closures[c].rows) {
      DualArray& squares = closure_row.kind == kinematics::ClosureRow::Kind::dot ? angle : length;
      for (std::size_t k = 0; k < numerics::dual_width && !tree_.closures[c].is_velocity_level(); ++k) {
        const double residual = x_[row].d[k];
        const double unscaled = residual / equations_.row_scale()[row];
        if (std::abs(residual) > closure_residual_tolerance * demanded_change[k]) squares[k] += unscaled * unscaled;
      }
      ++row;
    }
    for (std::size_t k = 0; k < numerics::dual_width; ++k) {
      gaps_[c].length[k] = std::max(gaps_[c].length[k], std::sqrt(length[k]));
      gaps_[c].angle[k] = std::max(gaps_[c].angle[k], std::sqrt(angle[k]));
    }
  }
}

template <class S>
ClosureGaps DualEvaluator<S>::closure_gaps(std::size_t k) const {
  ClosureGaps gaps;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    if (gaps_[c].length[k] > 0) gaps.push_back({tree_.closures[c].joint, true, gaps_[c].length[k]});
    if (gaps_[c].angle[k] > 0) gaps.push_back({tree_.closures[c].joint, false, gaps_[c].angle[k]});
  }
  return gaps;
}

template <class S>
bool DualEvaluator<S>::evaluate(const DualNumber& time, double duration, dynamics::Detail detail) {
  const dynamics::TreeMotion<D> motion{state_, coordinates_.y.data(), coordinates_.dy.data(), coordinates_.ddy.data(),
                                       time,   is_explicit_};
  return sample_evaluator_.evaluate(motion, equations_, duration, detail);
}

template <class S>
DualNumber DualEvaluator<S>::mobility() {
  return is_explicit_ ? DualNumber(1) : equations_.min_singular_value();
}

template class DualEvaluator<kinematics::Planar>;
template class DualEvaluator<kinematics::Spatial>;

void write_derivative(const trajectory::SampleOf<DualNumber>& sample, std::size_t k, DerivativeDetail detail,
                      Sample& out) {
  const auto copy_scalar = [k](const DualNumber& x, double& to) { to = x.d[k]; };
  const auto copy_matrix = [k](const auto& from, auto& to) {
    to.resize(from.rows(), from.cols());
    for (Eigen::Index i = 0; i < from.size(); ++i) to(i) = from(i).d[k];
  };
  const auto copy_vectors = [&](const auto& from, std::vector<Vector3>& to) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) copy_matrix(from[i], to[i]);
  };
  copy_scalar(sample.time, out.time);
  copy_matrix(sample.effort, out.effort);
  copy_matrix(sample.power, out.power);
  copy_matrix(sample.com_acceleration, out.com_acceleration);
  copy_matrix(sample.shaking_force, out.shaking_force);
  copy_matrix(sample.shaking_moment, out.shaking_moment);
  copy_matrix(sample.ground_force, out.ground_force);
  copy_matrix(sample.ground_moment, out.ground_moment);
  if (detail == DerivativeDetail::forces) return;
  copy_matrix(sample.com_velocity, out.com_velocity);
  copy_matrix(sample.shaking_moment_com, out.shaking_moment_com);
  copy_vectors(sample.joint_force, out.joint_force);
  copy_vectors(sample.joint_moment, out.joint_moment);
  copy_scalar(sample.kinetic_energy, out.kinetic_energy);
  copy_scalar(sample.total_torque, out.total_torque);
  copy_scalar(sample.mobility, out.mobility);
  if (detail == DerivativeDetail::figures) return;
  copy_matrix(sample.position, out.position);
  copy_matrix(sample.velocity, out.velocity);
  copy_matrix(sample.acceleration, out.acceleration);
  copy_matrix(sample.com, out.com);
  copy_matrix(sample.tool_position, out.tool_position);
  copy_matrix(sample.tool_rotation, out.tool_rotation);
  copy_scalar(sample.tool_angle, out.tool_angle);
  copy_scalar(sample.potential_energy, out.potential_energy);
}

Sample derivative_of(const trajectory::SampleOf<DualNumber>& sample, std::size_t k) {
  Sample out;
  write_derivative(sample, k, DerivativeDetail::all, out);
  return out;
}

}  // namespace balance::derivatives
