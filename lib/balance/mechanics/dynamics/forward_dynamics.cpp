#include "balance/mechanics/dynamics/forward_dynamics.hpp"

#include "balance/mechanics/dynamics/loop_dynamics.hpp"
#include "balance/mechanics/kinematics/constraint_system.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"

#include <stdexcept>

namespace balance::dynamics {

void ForwardOptions::validate() const {
  if (!(friction_regularisation_speed >= 0))
    throw std::invalid_argument("friction_regularisation_speed cannot be negative");
}

class ForwardDynamics::Implementation {
 public:
  virtual ~Implementation() = default;
  virtual MotionOutcome set(double time, const VectorX& position, const VectorX& velocity) = 0;
  virtual bool move(double time, const VectorX& position, const VectorX& rate) = 0;
  virtual EquationOfMotion equation() = 0;
  virtual TreeEquation tree_equation() = 0;
  virtual Transformation transformation() = 0;
  virtual Transformation tree_transformation() = 0;
  virtual VectorX acceleration(const VectorX& efforts) = 0;

  int freedoms = -1;
  std::vector<CoordinateId> independent, tree;
  VectorX position, velocity, rates;
};

namespace {

using RowMajor = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

template <class S>
class ForwardDynamicsOf : public ForwardDynamics::Implementation {
 public:
  ForwardDynamicsOf(const Mechanism& mechanism, const ForwardOptions& options)
      : mechanism_(mechanism), loop_dynamics_(mechanism, options) {
    tree = find_column_coordinates(loop_dynamics_.tree());
    ddy_.setZero(loop_dynamics_.columns());
  }

  MotionOutcome set(double time, const VectorX& q, const VectorX& dq) override {
    time_ = time;
    MotionOutcome outcome = loop_dynamics_.assemble(time, q, dq, y_, dy_);
    outcome.time = time;
    if (outcome.status != MotionStatus::done) return outcome;
    freedoms = loop_dynamics_.freedoms();
    independent.clear();
    rates.resize(freedoms);
    for (int k = 0; k < freedoms; ++k) {
      independent.push_back(tree[loop_dynamics_.independent()[k]]);
      rates[k] = dy_[loop_dynamics_.independent()[k]];
    }
    outcome = check_mass_matrix(mechanism_, loop_dynamics_, time_, dy_.data());
    if (outcome.status == MotionStatus::done) evaluate();
    return outcome;
  }

  bool move(double time, const VectorX& q, const VectorX& rate) override {
    time_ = time;
    for (int k = 0; k < freedoms; ++k) {
      y_[loop_dynamics_.independent()[k]] = q[k];
      dy_[loop_dynamics_.independent()[k]] = rate[k];
    }
    if (!loop_dynamics_.solve_dependent(time, y_.data(), dy_.data())) return false;
    rates = rate;
    evaluate();
    return true;
  }

  EquationOfMotion equation() override {
    return {loop_dynamics_.reduced_mass(), loop_dynamics_.reduced_bias(), C().transpose() * input()};
  }

  TreeEquation tree_equation() override {
    TreeEquation out;
    const int n = loop_dynamics_.columns();
    out.mass = RowMajor(loop_dynamics_.mass().data(), n, n);
    out.bias = Eigen::Map<const VectorX>(loop_dynamics_.bias().data(), n);
    out.input = input();
    kinematics::ConstraintSystem<S> closures(loop_dynamics_.tree(), kinematics::Drive<S>{});
    closures.velocity_jacobian(y_, {}, out.jacobian);
    for (int c = 0; c < n; ++c) out.jacobian.col(c) /= loop_dynamics_.scale()[c];
    // J̇ẏ = −J c, because ÿ = c is a motion with ν̇ = 0
    out.jacobian_bias = -out.jacobian * tree_bias();
    return out;
  }

  Transformation tree_transformation() override { return {C(), tree_bias()}; }

  Transformation transformation() override {
    Transformation out;
    const auto rows = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    const int n = loop_dynamics_.columns(), d = freedoms;
    out.matrix.resize(rows, d);
    VectorX q, dq, ddq;
    for (int k = 0; k < d; ++k) {
      const VectorX column = C().col(k);
      read(column, VectorX::Zero(n), q, dq, ddq);
      out.matrix.col(k) = dq;
    }
    read(dy_, tree_bias(), q, dq, out.bias);
    return out;
  }

  VectorX acceleration(const VectorX& efforts) override {
    if (efforts.size() != static_cast<Eigen::Index>(mechanism_.actuators.size()))
      throw std::invalid_argument("one effort per actuator is needed");
    VectorX ddy(loop_dynamics_.columns()), q, dq, ddq;
    loop_dynamics_.accelerate(time_, dy_.data(), efforts.data(), ddy.data());
    read(dy_, ddy, q, dq, ddq);
    return ddq;
  }

 private:
  void evaluate() {
    loop_dynamics_.compute_tree_terms(time_, dy_.data());
    loop_dynamics_.reduce_to_independent();
    compute_origin_velocities(loop_dynamics_.tree(), dy_.data(), loop_dynamics_.state());
    VectorX ignored;
    to_joint_coordinates(mechanism_, loop_dynamics_.tree(), loop_dynamics_.state(), y_.data(), dy_.data(), ddy_.data(),
                         position, velocity, ignored);
  }

  RowMajor C() const { return {loop_dynamics_.transformation().data(), loop_dynamics_.columns(), freedoms}; }
  VectorX tree_bias() const {
    return Eigen::Map<const VectorX>(loop_dynamics_.transformation_bias().data(), loop_dynamics_.columns());
  }

  MatrixX input() const {
    MatrixX out = MatrixX::Zero(loop_dynamics_.columns(), static_cast<Eigen::Index>(mechanism_.actuators.size()));
    for (std::size_t a = 0; a < mechanism_.actuators.size(); ++a) {
      const kinematics::LinearQuantity& source = loop_dynamics_.tree().coordinate_expressions[mechanism_.actuators[a]];
      source.add_generalised_force(1, out.col(static_cast<Eigen::Index>(a)).data());
    }
    return out;
  }

  /// Joint coordinates at the present pose for any rates and accelerations.
  void read(const VectorX& dy, const VectorX& ddy, VectorX& q, VectorX& dq, VectorX& ddq) {
    kinematics::TreeState<S>& state = loop_dynamics_.state();
    compute_velocities(loop_dynamics_.tree(), dy.data(), state);
    kinematics::compute_accelerations<S>(loop_dynamics_.tree(), dy.data(), ddy.data(), S::Vector::Zero(), state);
    to_joint_coordinates(mechanism_, loop_dynamics_.tree(), state, y_.data(), dy.data(), ddy.data(), q, dq, ddq);
  }

  const Mechanism& mechanism_;
  LoopDynamics<S> loop_dynamics_;
  double time_ = 0;
  VectorX y_, dy_, ddy_;
};

}  // namespace

ForwardDynamics::ForwardDynamics(const Mechanism& mechanism, const ForwardOptions& options) {
  options.validate();
  for (const CoordinateId coordinate : options.preferred)
    if (coordinate < 0 || coordinate >= static_cast<int>(mechanism.coordinates.size()))
      throw std::invalid_argument("a preferred coordinate does not exist");
  kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
    implementation_ = std::make_unique<ForwardDynamicsOf<S>>(mechanism, options);
  });
}

ForwardDynamics::~ForwardDynamics() = default;
ForwardDynamics::ForwardDynamics(ForwardDynamics&&) noexcept = default;
ForwardDynamics& ForwardDynamics::operator=(ForwardDynamics&&) noexcept = default;

MotionOutcome ForwardDynamics::set_state(double time, const VectorX& position, const VectorX& velocity) {
  return implementation_->set(time, position, velocity);
}
int ForwardDynamics::freedoms() const { return implementation_->freedoms; }
bool ForwardDynamics::move_to(double time, const VectorX& position, const VectorX& rate) {
  return implementation_->move(time, position, rate);
}

const std::vector<CoordinateId>& ForwardDynamics::independent() const { return implementation_->independent; }
const std::vector<CoordinateId>& ForwardDynamics::tree() const { return implementation_->tree; }
const VectorX& ForwardDynamics::position() const { return implementation_->position; }
const VectorX& ForwardDynamics::velocity() const { return implementation_->velocity; }
VectorX ForwardDynamics::rates() const { return implementation_->rates; }
EquationOfMotion ForwardDynamics::equation() { return implementation_->equation(); }
TreeEquation ForwardDynamics::tree_equation() { return implementation_->tree_equation(); }
Transformation ForwardDynamics::transformation() { return implementation_->transformation(); }
Transformation ForwardDynamics::tree_transformation() { return implementation_->tree_transformation(); }
VectorX ForwardDynamics::acceleration(const VectorX& efforts) { return implementation_->acceleration(efforts); }

}  // namespace balance::dynamics
