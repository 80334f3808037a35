#include "balance/synthesis/identification/motion_equation.hpp"

#include "balance/mechanics/dynamics/inertia_regressor.hpp"
#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/kinematics/assembly_branch.hpp"
#include "balance/mechanics/kinematics/drive.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

namespace balance::identification {

class MotionEquations::Implementation {
 public:
  explicit Implementation(Mechanism source) : mechanism(std::move(source)) {}
  virtual ~Implementation() = default;
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  virtual MotionOutcome evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time,
                                 MotionEquation& out) = 0;
  virtual bool has_loops() const = 0;
  virtual double mobility() = 0;
  virtual VectorX coordinates() const = 0;

  const Mechanism mechanism;
  std::vector<CoordinateId> independent;
  VectorX inertial_values;
  int freedoms = 0, frame_rows = 0;
};

namespace {

/// Friction that is unknown counts as zero; its entries keep their coordinates in the tree.
Mechanism without_friction(Mechanism mechanism) {
  for (Friction& friction : mechanism.friction) friction = {.coordinate = friction.coordinate};
  return mechanism;
}

template <class S>
class MotionEquationsOf final : public MotionEquations::Implementation {
 public:
  MotionEquationsOf(const Mechanism& source, const std::vector<std::string>& names)
      : Implementation(without_friction(source)),
        branch_(mechanism, kinematics::choose_independent_coordinates<S>(mechanism, names)),
        gravity_(kinematics::to_vector<S>(mechanism.gravity)) {
    if (!mechanism.loads.empty() || !mechanism.springs.empty())
      known_forces_.emplace(mechanism, branch_.tree(), branch_.freedoms(), S::Vector::Zero());
    independent = branch_.independent();
    freedoms = branch_.freedoms();
    frame_rows = S::dimension + S::angular_dimension;
    inertial_values = dynamics::list_inertial_parameters(branch_.tree());
    compile_coordinate_rows();
  }

  MotionOutcome evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time,
                         MotionEquation& out) override {
    MotionOutcome outcome = branch_.move_to(q.data(), time);
    if (outcome.status != MotionStatus::done) return outcome;
    branch_.set_rates(dq.data());
    branch_.set_accelerations(ddq.data());
    const kinematics::Tree<S>& tree = branch_.tree();
    kinematics::TreeState<S>& state = branch_.state();
    if (branch_.is_explicit()) {
      compute_poses(tree, branch_.y(), state);
      compute_angular_velocities(tree, branch_.dy(), state);
    }
    branch_.fill_transformation(C_);
    const Eigen::Map<const VectorX> dy(branch_.dy(), tree.columns), ddy(branch_.ddy(), tree.columns);
    kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), -gravity_, state);
    const dynamics::InertiaRegressor<S> forces = dynamics::compute_regressor(tree, state);
    out.inertial.noalias() = C_.transpose() * forces.torque;
    out.rate_map.noalias() = coordinate_rows_ * C_;
    out.rates = coordinate_rows_ * dy;
    out.accelerations = coordinate_rows_ * ddy;
    out.input.resize(freedoms, static_cast<Eigen::Index>(mechanism.actuators.size()));
    for (std::size_t a = 0; a < mechanism.actuators.size(); ++a)
      out.input.col(static_cast<Eigen::Index>(a)) = out.rate_map.row(mechanism.actuators[a]).transpose();
    out.frame = stack(forces);
    set_known_forces(time, out);
    kinematics::compute_accelerations<S>(tree, dy.data(), ddy.data(), S::Vector::Zero(), state);
    out.shaking = stack(dynamics::compute_momentum_rate_regressor(tree, state));
    return outcome;
  }

  bool has_loops() const override { return !branch_.is_explicit(); }
  double mobility() override { return branch_.mobility(); }
  VectorX coordinates() const override { return branch_.coordinates(); }

 private:
  /// ∂ṡ/∂ẏ: a row per coordinate of the mechanism.
  void compile_coordinate_rows() {
    const kinematics::Tree<S>& tree = branch_.tree();
    coordinate_rows_.setZero(static_cast<Eigen::Index>(mechanism.coordinates.size()), tree.columns);
    for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      if (tree.coordinate_expressions[c].has_terms() && !tree.is_floating[c]) {
        for (const auto& [column, coefficient] : tree.coordinate_expressions[c].terms)
          coordinate_rows_(row, column) += coefficient;
        continue;
      }
      if constexpr (kinematics::is_planar<S>) {
        if (mechanism.coordinates[c].kind != CoordinateKind::angle) continue;
        const Joint& joint = mechanism.joints[mechanism.coordinates[c].joint];  // cut: difference of two bodies' angles
        for (const auto& [body, sign] : {std::pair{joint.second, 1.0}, std::pair{joint.first, -1.0}})
          for (const auto& [column, coefficient] :
               kinematics::make_tool_angle_expression(tree, tree.bodies[body]).terms)
            coordinate_rows_(row, column) += sign * coefficient;
      }
    }
  }

  /// On the frame: minus what the frame exerts on everything.
  static MatrixX stack(const dynamics::InertiaRegressor<S>& forces) {
    MatrixX rows(forces.force.rows() + forces.moment.rows(), forces.force.cols());
    rows << -forces.force, -forces.moment;
    return rows;
  }

  /// Springs and loads: what all forces are besides those of the masses.
  void set_known_forces(double time, MotionEquation& out) {
    out.known.setZero(freedoms);
    out.known_frame.setZero(frame_rows);
    if (!known_forces_) return;
    known_forces_->evaluate({branch_.state(), branch_.y(), branch_.dy(), branch_.ddy(), time, branch_.is_explicit()},
                            branch_.equations(), 1, dynamics::Detail::forces);
    const Eigen::Map<const VectorX> tau(known_forces_->generalised_forces().data(), branch_.tree().columns);
    out.known = C_.transpose() * tau - out.inertial * inertial_values;
    const trajectory::Sample& sample = known_forces_->sample();
    out.known_frame << sample.ground_force.template head<S::dimension>(),
        sample.ground_moment.template tail<S::angular_dimension>();
    out.known_frame -= out.frame * inertial_values;
  }

  kinematics::AssemblyBranch<S> branch_;
  std::optional<dynamics::SampleEvaluator<S>> known_forces_;  ///< if there are springs or loads
  typename S::Vector gravity_;
  MatrixX coordinate_rows_, C_;
};

}  // namespace

MotionEquations::MotionEquations(const Mechanism& mechanism, const std::vector<std::string>& independent) {
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("constraints on rates (rolling bodies, constraints on speeds) cannot be identified");
  engine_ = kinematics::dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<Implementation> {
    return std::make_unique<MotionEquationsOf<S>>(mechanism, independent);
  });
}
MotionEquations::~MotionEquations() = default;
MotionEquations::MotionEquations(MotionEquations&&) noexcept = default;
MotionEquations& MotionEquations::operator=(MotionEquations&&) noexcept = default;

const Mechanism& MotionEquations::mechanism() const { return engine_->mechanism; }
int MotionEquations::degrees_of_freedom() const { return engine_->freedoms; }
const std::vector<CoordinateId>& MotionEquations::independent() const { return engine_->independent; }
const VectorX& MotionEquations::inertial_values() const { return engine_->inertial_values; }
int MotionEquations::frame_rows() const { return engine_->frame_rows; }

MotionOutcome MotionEquations::evaluate(const VectorX& q, const VectorX& dq, const VectorX& ddq, double time,
                                        MotionEquation& equation) {
  return engine_->evaluate(q, dq, ddq, time, equation);
}

bool MotionEquations::has_loops() const { return engine_->has_loops(); }
double MotionEquations::mobility() { return engine_->mobility(); }
VectorX MotionEquations::coordinates() const { return engine_->coordinates(); }

}  // namespace balance::identification
