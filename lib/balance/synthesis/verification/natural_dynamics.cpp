#include "balance/synthesis/verification/natural_dynamics.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/model/friction_law.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <algorithm>
#include <cmath>

namespace balance::verification::natural {

namespace {

/// Distributes a force at a place, given as an affine form, among the points by virtual power.
void distribute_force(const AffineForm& point, Complex force, std::vector<Complex>& forces) {
  for (const PointTerm& term : point.terms)
    forces[static_cast<std::size_t>(term.point)] += std::conj(term.weight) * force;
}

/// A spring between points, with its lengths in another unit.
Spring scale_lengths(Spring spring, double factor) {
  spring.free_length *= factor;
  if (spring.slack_length) *spring.slack_length *= factor;
  return spring;
}

}  // namespace

TableReader::TableReader(const model::ForceTableOf<double>& table) : table_(table) {
  if (table.is_empty() || table.interpolation == model::TableInterpolation::linear) return;
  const Samples values = VectorX::Map(table.force.data(), static_cast<Eigen::Index>(table.force.size()));
  spline_.emplace(table.displacement, values, numerics::SplineEnd::not_a_knot);
}

double TableReader::force(double displacement) const {
  const std::vector<double>&x = table_.displacement, &f = table_.force;
  const double at = std::clamp(displacement, x.front(), x.back());
  if (spline_) {
    VectorX value(1), first(1), second(1);
    spline_->at(at, value, first, second);
    return value[0];
  }
  std::size_t k = 1;
  while (k + 1 < x.size() && x[k] < at) ++k;
  return ((x[k] - at) * f[k - 1] + (at - x[k - 1]) * f[k]) / (x[k] - x[k - 1]);
}

/// Simpson's rule, which is exact for cubics, from row to row.
double TableReader::energy(double displacement) const {
  const std::vector<double>& x = table_.displacement;
  const auto integrate = [&](double from, double to) {
    return (to - from) * (force(from) + 4 * force((from + to) / 2) + force(to)) / 6;
  };
  if (displacement < x.front()) return integrate(x.front(), displacement);
  double sum = 0;
  for (std::size_t k = 1; k < x.size() && x[k - 1] < displacement; ++k)
    sum += integrate(x[k - 1], std::min(x[k], displacement));
  return displacement > x.back() ? sum + integrate(x.back(), displacement) : sum;
}

AppliedForces::AppliedForces(const Mechanism& mechanism, const NaturalModel& model)
    : model_(model), gravity_(to_complex(mechanism.gravity, model.length())) {
  const auto make_point_form = [&](BodyId body, const Vector3& point) {
    return model.bodies[static_cast<std::size_t>(body)].place(to_complex(point, model.length()));
  };
  for (const Load& load : mechanism.loads)
    loads_.push_back(
        {model::LoadTable<double>(load),
         load.is_over_coordinate() ? &model.coordinates[static_cast<std::size_t>(load.coordinate)].form : nullptr,
         make_point_form(load.body, load.point), model.bodies[static_cast<std::size_t>(load.body)].direction});
  const double L = model.length();
  for (const Spring& spring : mechanism.springs)
    if (spring.is_joint_spring())
      joint_springs_.push_back({model.coordinates[static_cast<std::size_t>(spring.coordinate)].form,
                                spring.stiffness / (L * L), spring.preload / (L * L)});
    else
      springs_.push_back(
          {make_point_form(spring.second, spring.point_second) - make_point_form(spring.first, spring.point_first),
           scale_lengths(spring, 1 / L)});
  for (const ForceElement& element : mechanism.force_elements)
    if (element.is_in_joint())
      joint_tables_.push_back(
          {model.coordinates[static_cast<std::size_t>(element.coordinate)].form, TableReader(element.table)});
    else
      point_elements_.push_back(
          {make_point_form(element.second, element.point_second) - make_point_form(element.first, element.point_first),
           &element, TableReader(element.table)});
}

NaturalWrench AppliedForces::add_forces(const NaturalCoordinates& position, const NaturalCoordinates& velocity,
                                        double time, std::vector<Complex>& forces) const {
  const std::vector<Complex> weights = multiply_by_mass(model_, std::vector<Complex>(forces.size(), gravity_));
  for (std::size_t k = 0; k < forces.size(); ++k) forces[k] += weights[k];
  NaturalWrench total;
  const double L = model_.length();
  for (const PlacedLoad& placed : loads_) {
    Vector3 load_force, moment;
    placed.table.evaluate(placed.coordinate != nullptr ? placed.coordinate->at(position.scalars) : time, load_force,
                          moment);
    const Complex e = placed.direction.at(position);
    const Complex force =
        to_complex(load_force, L) * (placed.table.load().frame == model::Frame::body ? e : Complex(1));
    const double load_moment = moment.z() / (L * L);
    distribute_force(placed.point, force, forces);
    distribute_force(placed.direction, imaginary * load_moment * e, forces);  // power turning · ω, with ė = i ω e
    total.force += force;
    total.moment += load_moment + cross(placed.point.at(position), force);
  }
  for (const PlacedSpring& spring : springs_) {
    const Complex spring_vector = spring.vector.at(position);
    const double force_per_length = spring.law.tension_per_length(std::abs(spring_vector));
    distribute_force(spring.vector, -force_per_length * spring_vector, forces);
  }
  for (const PointElement& placed : point_elements_) {
    const Complex vector = placed.vector.at(position);
    const double length = std::abs(vector);
    if (!(length > 0)) continue;
    const Complex direction = vector / length;
    const double tension = placed.element->is_damper()
                               ? placed.element->damping * dot(direction, placed.vector.rate(velocity))
                               : placed.table.force(L * length) / L;
    distribute_force(placed.vector, -tension * direction, forces);
  }
  return total;
}

void AppliedForces::add_joint_springs(const NaturalCoordinates& position, double* scalars) const {
  for (const JointSpring& spring : joint_springs_) {
    const double spring_force = spring.preload - spring.stiffness * spring.coordinate.at(position.scalars);
    for (const ScalarTerm& term : spring.coordinate.terms) scalars[term.scalar] += term.coefficient * spring_force;
  }
  const double energy_unit = model_.length() * model_.length();
  for (const JointTable& spring : joint_tables_) {
    const double effort = spring.table.force(spring.coordinate.at(position.scalars)) / energy_unit;
    for (const ScalarTerm& term : spring.coordinate.terms) scalars[term.scalar] += term.coefficient * effort;
  }
}

double AppliedForces::energy(const NaturalCoordinates& position) const {
  double sum = 0;
  for (const JointSpring& spring : joint_springs_) {
    const double q = spring.coordinate.at(position.scalars);
    sum += (0.5 * spring.stiffness * q - spring.preload) * q;
  }
  for (const PlacedSpring& spring : springs_) sum += spring.law.energy(std::abs(spring.vector.at(position)));
  const double L = model_.length();
  for (const PointElement& placed : point_elements_)
    if (!placed.element->is_damper()) sum += placed.table.energy(L * std::abs(placed.vector.at(position))) / (L * L);
  for (const JointTable& spring : joint_tables_)
    sum -= spring.table.energy(spring.coordinate.at(position.scalars)) / (L * L);
  return sum - model_.total_mass * dot(gravity_, make_com_form(model_).at(position));
}

NaturalWrench AppliedForces::weight(const NaturalCoordinates& position) const {
  const Complex weight = model_.total_mass * gravity_;
  return {weight, cross(make_com_form(model_).at(position), weight)};
}

std::vector<Complex> multiply_by_mass(const NaturalModel& model, const std::vector<Complex>& rates) {
  std::vector<Complex> result(rates.size());
  for (const MassEntry& entry : model.mass)
    result[static_cast<std::size_t>(entry.row)] += entry.value * rates[static_cast<std::size_t>(entry.column)];
  return result;
}

namespace {

Vector3 to_vector3(Complex z) { return {z.real(), z.imag(), 0}; }

}  // namespace

NaturalSampleEvaluator::NaturalSampleEvaluator(const Mechanism& mechanism, const NaturalModel& model, int freedoms,
                                               const Vector3& about)
    : mechanism_(mechanism),
      model_(model),
      applied_forces_(mechanism, model),
      freedoms_(freedoms),
      about_(to_complex(about, model.length())),
      com_(make_com_form(model)),
      moment_reference_(about) {
  if (mechanism.tool) tool_ = make_tool_form(mechanism, model);
  const int motors = static_cast<int>(mechanism.actuators.size());
  if (motors < freedoms) mismatch_ = trajectory::describe_under_actuation(motors, freedoms);
  trajectory::add_distribution_note(mechanism, freedoms, notes_);
  if (motors > freedoms && mechanism.torque_distribution)
    distribution_ = model::scale_distribution(mechanism, model.length());
  for (auto* values : {&sample_.position, &sample_.velocity, &sample_.acceleration})
    values->setZero(static_cast<Eigen::Index>(mechanism.coordinates.size()));
  for (auto* values : {&sample_.effort, &sample_.power}) values->setZero(motors);
}

bool NaturalSampleEvaluator::observe(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  update_coordinates(stepper);
  update_momentum(state);
  const bool is_held = solve_efforts(stepper);
  const double L = model_.length();
  const NaturalWrench weight = applied_forces_.weight(state.position);
  const Complex force = weight.force + load_wrench_.force - shaking_;
  sample_.time = stepper.time();
  sample_.newton_iterations = stepper.iterations();
  sample_.ground_force = L * to_vector3(force);
  sample_.ground_moment.z() =
      L * L * (weight.moment + load_wrench_.moment - cross(about_, weight.force + load_wrench_.force)) -
      sample_.shaking_moment.z();
  sample_.potential_energy = L * L * applied_forces_.energy(state.position);
  sample_.add_derived(moment_reference_);
  if (!mechanism_.tool) return is_held;
  sample_.tool_position = L * to_vector3(tool_.at(state.position));
  sample_.tool_angle = stepper.angles()[static_cast<std::size_t>(mechanism_.tool->body)] - model_.tool_angle_offset;
  return is_held;
}

void NaturalSampleEvaluator::update_coordinates(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  const double L = model_.length();
  for (Eigen::Index c = 0; c < sample_.position.size(); ++c) {
    const JointCoordinate& coordinate = model_.coordinates[static_cast<std::size_t>(c)];
    if (coordinate.linear) {
      sample_.position[c] = coordinate.form.at(state.position.scalars);
      sample_.velocity[c] = coordinate.form.rate(state.velocity.scalars);
      sample_.acceleration[c] = coordinate.form.rate(state.acceleration.scalars);
    } else if (coordinate.angle) {
      const auto first = static_cast<std::size_t>(coordinate.first),
                 second = static_cast<std::size_t>(coordinate.second);
      sample_.position[c] = stepper.angles()[second] - stepper.angles()[first] - coordinate.offset;
      sample_.velocity[c] = stepper.angular_velocity(coordinate.second) - stepper.angular_velocity(coordinate.first);
      sample_.acceleration[c] =
          stepper.angular_acceleration(coordinate.second) - stepper.angular_acceleration(coordinate.first);
    } else {
      sample_.position[c] = L * coordinate.slide.value(state.position);
      sample_.velocity[c] = L * coordinate.slide.rate(state.position, state.velocity);
      sample_.acceleration[c] = L * coordinate.slide.second_rate(state);
    }
  }
}

void NaturalSampleEvaluator::update_momentum(const NaturalState& state) {
  const double L = model_.length();
  inertial_forces_ = multiply_by_mass(model_, state.acceleration.points);
  const std::vector<Complex> momentum = multiply_by_mass(model_, state.velocity.points);
  Complex force;
  double moment = 0, energy = 0;
  // The second term of P3 eq. 27, (dq̃/dt) M q̇, is zero: ż ᴴ M ż is real because M is Hermitian.
  for (std::size_t k = 0; k < inertial_forces_.size(); ++k) {
    force += inertial_forces_[k];
    moment += cross(state.position.points[k] - about_, inertial_forces_[k]);
    energy += 0.5 * dot(state.velocity.points[k], momentum[k]);
  }
  for (const Rotor& rotor : model_.rotors) {
    const double rate = rotor.angle.rate(state.velocity.scalars);
    moment += rotor.inertia * rotor.angle.rate(state.acceleration.scalars);
    energy += 0.5 * rotor.inertia * rate * rate;
  }
  shaking_ = force;
  sample_.com = L * to_vector3(com_.at(state.position));
  sample_.com_velocity = L * to_vector3(com_.rate(state.velocity));
  sample_.com_acceleration = L * to_vector3(com_.rate(state.acceleration));
  sample_.shaking_force = L * to_vector3(force);
  sample_.shaking_moment.z() = L * L * moment;
  sample_.kinetic_energy = L * L * energy;
}

/// M q̈ minus weight, loads, springs and friction on the unknowns: what constraints and actuators must supply.
VectorX NaturalSampleEvaluator::required_forces(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  const double L = model_.length();
  const int moving = model_.basic.moving;
  std::vector<Complex> applied(state.position.points.size());
  load_wrench_ = applied_forces_.add_forces(state.position, state.velocity, state.time, applied);
  VectorX required = VectorX::Zero(model_.unknowns());
  for (int k = 0; k < moving; ++k) {
    const Complex force = inertial_forces_[static_cast<std::size_t>(k)] - applied[static_cast<std::size_t>(k)];
    required[2 * k] = force.real();
    required[2 * k + 1] = force.imag();
  }
  VectorX scalars = VectorX::Zero(model_.scalars);
  applied_forces_.add_joint_springs(state.position, scalars.data());
  required.tail(model_.scalars) -= scalars;
  for (const Rotor& rotor : model_.rotors)
    for (const ScalarTerm& term : rotor.angle.terms)
      required[2 * moving + term.scalar] +=
          term.coefficient * rotor.inertia * rotor.angle.rate(state.acceleration.scalars);
  const auto unit = [&](std::size_t c) { return mechanism_.coordinates[c].kind == CoordinateKind::length ? L : 1; };
  double max_rate = 0;
  for (Eigen::Index c = 0; c < sample_.velocity.size(); ++c)
    max_rate = std::max(max_rate, std::abs(sample_.velocity[c]) / unit(static_cast<std::size_t>(c)));
  const double rest_rate = model::rest_rate_threshold(max_rate, stepper.duration());
  for (const Friction& friction : mechanism_.friction) {
    const auto c = static_cast<std::size_t>(friction.coordinate);
    const double rate = sample_.velocity[friction.coordinate];
    const double resistance = sliding_friction(friction, rate, model::sliding_sign(rate, rest_rate * unit(c)));
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      required[2 * moving + term.scalar] += term.coefficient * resistance / (L * L);
  }
  return required;
}

/// Φᵀ λ + Sᵀ u = f, the required forces. Along the motions N that the constraints allow, Φ N = 0, so that
/// Nᵀ Sᵀ u = Nᵀ f.
bool NaturalSampleEvaluator::solve_efforts(const NaturalStepper& stepper) {
  const double L = model_.length();
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  const VectorX required = required_forces(stepper);
  const MatrixX motions = stepper.equations().allowed_velocities();
  MatrixX actuation = MatrixX::Zero(motors, motions.cols());  // rates of the actuated coordinates; lengths divided by L
  VectorX unit = VectorX::Ones(motors);                       // for the minimum norm, a force counts as its moment at L
  for (Eigen::Index a = 0; a < motors; ++a) {
    const auto c = static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)]);
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      actuation.row(a) += term.coefficient * motions.row(2 * model_.basic.moving + term.scalar);
    if (mechanism_.coordinates[c].kind == CoordinateKind::length) unit[a] = L;
  }
  actuation = unit.cwiseInverse().asDiagonal() * actuation;
  // normalised columns: the choice of the drive must not influence whether the actuators hold the mechanism
  const VectorX column_scale = motions.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  actuation = actuation * column_scale.asDiagonal();
  const VectorX right_hand_side = L * L * column_scale.cwiseProduct(motions.transpose() * required);
  numerics::CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-10);
  qr.compute(actuation.transpose());
  VectorX efforts;
  if (!distribution_)
    efforts = qr.solve(right_hand_side).cwiseQuotient(unit);
  else if (qr.rank() == freedoms_)
    efforts = solve_distribution(*distribution_, actuation.transpose() * unit.asDiagonal(), right_hand_side);
  else
    efforts = VectorX::Constant(motors, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index a = 0; a < motors; ++a) {
    sample_.effort[a] = efforts[a];
    sample_.power[a] = efforts[a] * sample_.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
  }
  return qr.rank() == freedoms_;
}

MatrixX NaturalSampleEvaluator::actuation_matrix(const NaturalKinematicEquations& equations,
                                                 const NaturalCoordinates& position) const {
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  MatrixX result = MatrixX::Zero(equations.constraint_count() + motors, equations.unknown_count());
  result.topRows(equations.constraint_count()) = equations.constraint_jacobian(position);
  for (Eigen::Index a = 0; a < motors; ++a) {
    const auto c = static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)]);
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      result(equations.constraint_count() + a, 2 * model_.basic.moving + term.scalar) += term.coefficient;
  }
  return result;
}

}  // namespace balance::verification::natural
