#include "balance/synthesis/conditions/base_parameters.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/kinematics/closure.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/row_reduction.hpp"

#include <fmt/format.h>

namespace balance::conditions {

namespace {

constexpr int min_identification_samples = 12, max_identification_samples = 2000;
constexpr int max_identification_retries = 2;  ///< each with twice as many samples

/// Stacks the regressor, projected onto the admissible velocities, at random configurations.
template <class S>
class BaseParameterIdentification {
 public:
  BaseParameterIdentification(const Mechanism& mechanism, std::uint64_t seed)
      : mechanism_(mechanism),
        tree_(kinematics::compile_tree<S>(mechanism, mechanism.actuators)),
        sampler_(mechanism, tree_, seed),
        random_(seed + 1),
        scale_(column_scale(tree_)),
        state_(tree_.nodes.size()) {
    out_.parameters = dynamics::list_parameters(mechanism);
  }

  Conditions run() {
    const NaturalUnits units(mechanism_, out_.parameters);
    const std::vector<int> order = order_pivots(mechanism_, out_.parameters);
    const auto P = static_cast<Eigen::Index>(out_.parameters.size());
    MatrixX rows(0, P);
    for (int k = 0, min_rows = 2 * static_cast<int>(P) + 20; k <= max_identification_retries; ++k, min_rows *= 2) {
      while (rows.rows() < min_rows || out_.samples < min_identification_samples)
        if (!add_sample(units, rows)) return refuse(ConditionsStatus::not_assembled, sampler_.infeasibility_reason());
      if (!reduce_conditions(rows, units.parameter, units.mass, order, out_)) continue;
      out_.status = ConditionsStatus::done;
      return std::move(out_);
    }
    return refuse(ConditionsStatus::rank_unclear,
                  fmt::format("the number of base parameters is not clear: the widest gap between singular values is "
                              "{:.1e}, from {:.1e} to {:.1e}",
                              out_.singular_value_gap, out_.min_kept_singular_value, out_.max_dropped_singular_value));
  }

 private:
  Conditions refuse(ConditionsStatus status, const std::string& reason) {
    out_.status = status;
    out_.reason = reason;
    return std::move(out_);
  }

  MatrixX compute_regressor(const VectorX& velocity, const VectorX& acceleration, bool weight) {
    const VectorX dy = scale_.cwiseProduct(velocity), ddy = scale_.cwiseProduct(acceleration);
    compute_angular_velocities(tree_, dy.data(), state_);
    const typename S::Vector base = weight ? typename S::Vector(-kinematics::to_vector<S>(mechanism_.gravity))
                                           : typename S::Vector(S::Vector::Zero());
    compute_accelerations(tree_, dy.data(), ddy.data(), base, state_);
    return dynamics::compute_regressor(tree_, state_).torque;
  }

  /// A particular acceleration that is compatible with a velocity; all others differ from it by an admissible one.
  VectorX bias_acceleration(const VectorX& y, const VectorX& velocity) {
    VectorX rhs = VectorX::Zero(tree_.closure_rows);
    if (rhs.size() == 0) return VectorX::Zero(tree_.columns);
    const VectorX dy = scale_.cwiseProduct(velocity);
    compute_velocities(tree_, dy.data(), state_);
    kinematics::compute_accelerations<S>(tree_, dy.data(), nullptr, S::Vector::Zero(), state_);
    double* next = rhs.data();
    for (const kinematics::Closure<S>& closure : tree_.closures) {
      closure_bias(state_, closure, closure_pose(state_, closure), next);
      for (const kinematics::ClosureRow& row : closure.rows) *next++ *= -compute_row_scale(tree_, closure, row);
    }
    kinematics::ConstraintSystem<S> system(tree_, kinematics::Drive<S>{});
    MatrixX jacobian;
    system.velocity_jacobian(y, {}, jacobian);
    numerics::CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);  // redundant closures leave rows of round-off
    return qr.compute(jacobian).solve(rhs);
  }

  /// Adds rows of inertia, velocity terms and weight at one more configuration. Returns false if there is none.
  bool add_sample(const NaturalUnits& units, MatrixX& rows) {
    SampledConfiguration configuration;
    if (out_.samples == max_identification_samples || !sampler_.next(configuration)) return false;
    ++out_.samples;
    compute_poses(tree_, configuration.y.data(), state_);
    const MatrixX projection = configuration.null_space.transpose() * scale_.asDiagonal();
    const VectorX zero_rate = VectorX::Zero(tree_.columns);
    const auto random_velocity = [&] {
      return VectorX(configuration.null_space * random_.sample_normal(configuration.null_space.cols()));
    };
    const double L2 = units.length * units.length;
    add(projection * compute_regressor(zero_rate, random_velocity(), false) / L2, units, rows);
    const VectorX velocity = random_velocity();
    add(projection * compute_regressor(velocity, bias_acceleration(configuration.y, velocity), false) / L2, units,
        rows);
    if (mechanism_.gravity.norm() > 0)
      add(projection * compute_regressor(zero_rate, zero_rate, true) / (units.acceleration * units.length), units,
          rows);
    return true;
  }

  static void add(const MatrixX& block, const NaturalUnits& units, MatrixX& rows) {
    rows.conservativeResize(rows.rows() + block.rows(), Eigen::NoChange);
    rows.bottomRows(block.rows()) = block * units.parameter.asDiagonal();
  }

  const Mechanism& mechanism_;
  kinematics::Tree<S> tree_;
  ConfigurationSampler<S> sampler_;
  numerics::UniformRandom random_;
  VectorX scale_;
  kinematics::TreeState<S> state_;
  Conditions out_;
};

}  // namespace

Conditions compute_base_parameters(const Mechanism& mechanism, std::uint64_t seed) {
  Mechanism without_forces = mechanism;
  without_forces.springs.clear();
  without_forces.force_elements.clear();
  without_forces.loads.clear();
  without_forces.friction.clear();
  if (has_prescribed_speeds(mechanism)) {
    Conditions refusal;
    refusal.status = ConditionsStatus::mismatch;
    refusal.reason = "a constraint on speeds has a value";
    return refusal;
  }
  return kinematics::dispatch_space(
      mechanism.space, [&]<class S>(S) { return BaseParameterIdentification<S>(without_forces, seed).run(); });
}

}  // namespace balance::conditions
