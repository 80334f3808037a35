#include "balance/conditions/base_parameters.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/conditions/reduce.hpp"
#include "balance/conditions/rows.hpp"
#include "balance/kinematics/closure.hpp"

#include <fmt/format.h>

namespace balance {

namespace {

constexpr int fewest_configurations = 12, most_configurations = 2000;
constexpr int more_rounds = 2;  ///< with twice as many samples each, before the rank is called unclear

/// Generalised forces along the admissible velocities, per unit of every parameter, at random configurations.
template <class S>
class Identification {
 public:
  Identification(const Mechanism& mechanism, std::uint64_t seed)
      : mechanism_(mechanism),
        tree_(compile<S>(mechanism, mechanism.actuators)),
        sampler_(mechanism, tree_, seed),
        random_(seed + 1),
        scale_(column_scale(tree_)),
        state_(tree_.nodes.size()) {
    out_.parameters = list_parameters(mechanism);
  }

  Conditions run() {
    const NaturalUnits units(mechanism_, out_.parameters);
    const std::vector<int> order = pivot_order(mechanism_, out_.parameters);
    const auto P = static_cast<Eigen::Index>(out_.parameters.size());
    MatrixX rows(0, P);
    for (int k = 0, wanted = 2 * static_cast<int>(P) + 20; k <= more_rounds; ++k, wanted *= 2) {
      while (rows.rows() < wanted || out_.samples < fewest_configurations)
        if (!add_sample(units, rows)) return refuse(ConditionsStatus::not_assembled, sampler_.obstacle());
      if (!reduce(rows, units.parameter, units.mass, order, out_)) continue;
      out_.status = ConditionsStatus::done;
      return std::move(out_);
    }
    return refuse(ConditionsStatus::rank_unclear,
                  fmt::format("the number of base parameters is not clear: the widest gap between singular values is "
                              "{:.1e}, from {:.1e} to {:.1e}",
                              out_.gap, out_.smallest_kept, out_.largest_dropped));
  }

 private:
  Conditions refuse(ConditionsStatus status, const std::string& reason) {
    out_.status = status;
    out_.reason = reason;
    return std::move(out_);
  }

  MatrixX regress(const VectorX& velocity, const VectorX& acceleration, bool weight) {
    const VectorX dy = scale_.cwiseProduct(velocity), ddy = scale_.cwiseProduct(acceleration);
    angular_velocities(tree_, dy.data(), state_);
    const typename S::Vector base =
        weight ? typename S::Vector(-to_vector<S>(mechanism_.gravity)) : typename S::Vector(S::Vector::Zero());
    accelerations(tree_, dy.data(), ddy.data(), base, state_);
    return regressor(tree_, state_).torque;
  }

  /// Some accelerations that go with a velocity: they differ from all others by an admissible one.
  VectorX bias(const VectorX& y, const VectorX& velocity) {
    VectorX right = VectorX::Zero(tree_.closure_rows);
    if (right.size() == 0) return VectorX::Zero(tree_.columns);
    const VectorX dy = scale_.cwiseProduct(velocity);
    velocities(tree_, dy.data(), state_);
    accelerations<S>(tree_, dy.data(), nullptr, S::Vector::Zero(), state_);
    double* next = right.data();
    for (const Closure<S>& closure : tree_.closures) {
      closure_bias(state_, closure, closure_pose(state_, closure), next);
      for (const ClosureRow& row : closure.rows) *next++ *= -row_unit(tree_, closure, row);
    }
    System<S> system(tree_, Drive<S>{});
    MatrixX jacobian;
    system.rates(y, {}, jacobian);
    CompleteOrthogonalDecomposition qr;
    qr.setThreshold(1e-9);  // redundant closures have rows of round-off
    return qr.compute(jacobian).solve(right);
  }

  /// Rows of inertia, velocity terms and weight at one more configuration.
  bool add_sample(const NaturalUnits& units, MatrixX& rows) {
    Configuration here;
    if (out_.samples == most_configurations || !sampler_.next(here)) return false;
    ++out_.samples;
    poses(tree_, here.y.data(), state_);
    const MatrixX project = here.null_space.transpose() * scale_.asDiagonal();
    const VectorX rest = VectorX::Zero(tree_.columns);
    const auto mixed = [&] { return VectorX(here.null_space * random_.normal(here.null_space.cols())); };
    const double L2 = units.length * units.length;
    add(project * regress(rest, mixed(), false) / L2, units, rows);
    const VectorX velocity = mixed();
    add(project * regress(velocity, bias(here.y, velocity), false) / L2, units, rows);
    if (mechanism_.gravity.norm() > 0)
      add(project * regress(rest, rest, true) / (units.acceleration * units.length), units, rows);
    return true;
  }

  static void add(const MatrixX& block, const NaturalUnits& units, MatrixX& rows) {
    rows.conservativeResize(rows.rows() + block.rows(), Eigen::NoChange);
    rows.bottomRows(block.rows()) = block * units.parameter.asDiagonal();
  }

  const Mechanism& mechanism_;
  Tree<S> tree_;
  Sampler<S> sampler_;
  Random random_;
  VectorX scale_;
  State<S> state_;
  Conditions out_;
};

}  // namespace

Conditions base_parameters(const Mechanism& mechanism, std::uint64_t seed) {
  Mechanism massive = mechanism;
  massive.springs.clear();
  massive.loads.clear();
  massive.friction.clear();
  return in_space(mechanism.space, [&]<class S>(S) { return Identification<S>(massive, seed).run(); });
}

}  // namespace balance
