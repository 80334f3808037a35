#include "balance/synthesis/verification/natural_dynamics.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/model/friction_law.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <algorithm>
#include <cmath>

namespace balance::natural {

namespace {

/// Linear between its rows, held beyond them.
void interpolate_load(const Load& load, double time, Vector3& force, Vector3& moment) {
  if (load.time.empty()) {
    force = load.force.front();
    moment = load.moment.front();
    return;
  }
  const double t = std::clamp(time, load.time.front(), load.time.back());
  std::size_t k = 1;
  while (k + 1 < load.time.size() && load.time[k] < t) ++k;
  if (load.time.size() == 1) {
    force = load.force.front();
    moment = load.moment.front();
    return;
  }
  const double part = (t - load.time[k - 1]) / (load.time[k] - load.time[k - 1]);
  force = load.force[k - 1] + part * (load.force[k] - load.force[k - 1]);
  moment = load.moment[k - 1] + part * (load.moment[k] - load.moment[k - 1]);
}

/// A force on a place that is a form: virtual power shares it among the points.
void distribute_force(const AffineForm& place, Complex force, std::vector<Complex>& forces) {
  for (const PointTerm& term : place.terms)
    forces[static_cast<std::size_t>(term.point)] += std::conj(term.weight) * force;
}

}  // namespace

AppliedForces::AppliedForces(const Mechanism& mechanism, const NaturalModel& model)
    : model_(model), gravity_(to_complex(mechanism.gravity, model.length())) {
  const auto place = [&](BodyId body, const Vector3& point) {
    return model.bodies[static_cast<std::size_t>(body)].place(to_complex(point, model.length()));
  };
  for (const Load& load : mechanism.loads)
    loads_.push_back(
        {&load, place(load.body, load.point), model.bodies[static_cast<std::size_t>(load.body)].direction});
  const double L = model.length();
  for (const Spring& spring : mechanism.springs)
    if (spring.is_joint_spring())
      joint_springs_.push_back({model.coordinates[static_cast<std::size_t>(spring.coordinate)].form,
                                spring.stiffness / (L * L), spring.preload / (L * L)});
    else
      springs_.push_back({place(spring.second, spring.point_second) - place(spring.first, spring.point_first),
                          spring.stiffness, spring.free_length / L});
}

NaturalWrench AppliedForces::add_forces(const NaturalCoordinates& position, double time,
                                        std::vector<Complex>& forces) const {
  const std::vector<Complex> weights = multiply_by_mass(model_, std::vector<Complex>(forces.size(), gravity_));
  for (std::size_t k = 0; k < forces.size(); ++k) forces[k] += weights[k];
  NaturalWrench total;
  const double L = model_.length();
  for (const PlacedLoad& placed : loads_) {
    Vector3 given, moment;
    interpolate_load(*placed.load, time, given, moment);
    const Complex e = placed.direction.at(position);
    const Complex force = to_complex(given, L) * (placed.load->frame == Frame::body ? e : Complex(1));
    const double turning = moment.z() / (L * L);
    distribute_force(placed.point, force, forces);
    distribute_force(placed.direction, imaginary * turning * e, forces);  // power turning · ω, with ė = i ω e
    total.force += force;
    total.moment += turning + cross(placed.point.at(position), force);
  }
  for (const PlacedSpring& spring : springs_) {
    const Complex way = spring.vector.at(position);
    const double length = std::abs(way);
    // a spring without free length pulls with k d even at zero length
    const double pull = spring.free_length == 0 ? spring.stiffness
                        : length > 0            ? spring.stiffness * (1 - spring.free_length / length)
                                                : 0;
    distribute_force(spring.vector, -pull * way, forces);
  }
  return total;
}

void AppliedForces::add_joint_springs(const NaturalCoordinates& position, double* scalars) const {
  for (const JointSpring& spring : joint_springs_) {
    const double drive = spring.preload - spring.stiffness * spring.coordinate.at(position.scalars);
    for (const ScalarTerm& term : spring.coordinate.terms) scalars[term.scalar] += term.coefficient * drive;
  }
}

double AppliedForces::energy(const NaturalCoordinates& position) const {
  double sum = 0;
  for (const JointSpring& spring : joint_springs_) {
    const double q = spring.coordinate.at(position.scalars);
    sum += (0.5 * spring.stiffness * q - spring.preload) * q;
  }
  for (const PlacedSpring& spring : springs_) {
    const double stretch = std::abs(spring.vector.at(position)) - spring.free_length;
    sum += 0.5 * spring.stiffness * stretch * stretch;
  }
  return sum - model_.total_mass * dot(gravity_, make_com_form(model_).at(position));
}

NaturalWrench AppliedForces::weight(const NaturalCoordinates& position) const {
  const Complex weight = model_.total_mass * gravity_;
  return {weight, cross(make_com_form(model_).at(position), weight)};
}

std::vector<Complex> multiply_by_mass(const NaturalModel& model, const std::vector<Complex>& rates) {
  std::vector<Complex> out(rates.size());
  for (const MassEntry& entry : model.mass)
    out[static_cast<std::size_t>(entry.row)] += entry.value * rates[static_cast<std::size_t>(entry.column)];
  return out;
}

namespace {

Vector3 to_vector3(Complex z) { return {z.real(), z.imag(), 0}; }

}  // namespace

NaturalSampleEvaluator::NaturalSampleEvaluator(const Mechanism& mechanism, const NaturalModel& model, int freedoms,
                                               const Vector3& about)
    : mechanism_(mechanism),
      model_(model),
      applied_(mechanism, model),
      freedoms_(freedoms),
      about_(to_complex(about, model.length())),
      com_(make_com_form(model)),
      point_(about) {
  if (mechanism.tool) tool_ = make_tool_form(mechanism, model);
  const int motors = static_cast<int>(mechanism.actuators.size());
  if (motors < freedoms) mismatch_ = describe_under_actuation(motors, freedoms);
  if (motors > freedoms) notes_.push_back(describe_over_actuation(motors, freedoms));
  for (auto* values : {&seen_.position, &seen_.velocity, &seen_.acceleration})
    values->setZero(static_cast<Eigen::Index>(mechanism.coordinates.size()));
  for (auto* values : {&seen_.effort, &seen_.power}) values->setZero(motors);
}

bool NaturalSampleEvaluator::observe(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  read_coordinates(stepper);
  read_momentum(state);
  const bool held = solve_efforts(stepper);
  const double L = model_.length();
  const NaturalWrench weight = applied_.weight(state.position);
  const Complex force = weight.force + loads_.force - shaking_;
  seen_.time = stepper.time();
  seen_.newton_iterations = stepper.iterations();
  seen_.ground_force = L * to_vector3(force);
  seen_.ground_moment.z() =
      L * L * (weight.moment + loads_.moment - cross(about_, weight.force + loads_.force)) - seen_.shaking_moment.z();
  seen_.potential_energy = L * L * applied_.energy(state.position);
  seen_.add_derived(point_);
  if (!mechanism_.tool) return held;
  seen_.tool_position = L * to_vector3(tool_.at(state.position));
  seen_.tool_angle = stepper.angles()[static_cast<std::size_t>(mechanism_.tool->body)] - model_.tool_angle_offset;
  return held;
}

void NaturalSampleEvaluator::read_coordinates(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  const double L = model_.length();
  for (Eigen::Index c = 0; c < seen_.position.size(); ++c) {
    const JointCoordinate& coordinate = model_.coordinates[static_cast<std::size_t>(c)];
    if (coordinate.linear) {
      seen_.position[c] = coordinate.form.at(state.position.scalars);
      seen_.velocity[c] = coordinate.form.rate(state.velocity.scalars);
      seen_.acceleration[c] = coordinate.form.rate(state.acceleration.scalars);
    } else if (coordinate.angle) {
      const auto first = static_cast<std::size_t>(coordinate.first),
                 second = static_cast<std::size_t>(coordinate.second);
      seen_.position[c] = stepper.angles()[second] - stepper.angles()[first] - coordinate.offset;
      seen_.velocity[c] = stepper.angular_velocity(coordinate.second) - stepper.angular_velocity(coordinate.first);
      seen_.acceleration[c] =
          stepper.angular_acceleration(coordinate.second) - stepper.angular_acceleration(coordinate.first);
    } else {
      seen_.position[c] = L * coordinate.slide.value(state.position);
      seen_.velocity[c] = L * coordinate.slide.rate(state.position, state.velocity);
      seen_.acceleration[c] = L * coordinate.slide.second_rate(state);
    }
  }
}

void NaturalSampleEvaluator::read_momentum(const NaturalState& state) {
  const double L = model_.length();
  inertia_ = multiply_by_mass(model_, state.acceleration.points);
  const std::vector<Complex> momentum = multiply_by_mass(model_, state.velocity.points);
  Complex force;
  double moment = 0, energy = 0;
  // The second term of P3 eq. 27, (dq̃/dt) M q̇, is zero: ż ᴴ M ż is real because M is Hermitian.
  for (std::size_t k = 0; k < inertia_.size(); ++k) {
    force += inertia_[k];
    moment += cross(state.position.points[k] - about_, inertia_[k]);
    energy += 0.5 * dot(state.velocity.points[k], momentum[k]);
  }
  for (const Rotor& rotor : model_.rotors) {
    const double rate = rotor.angle.rate(state.velocity.scalars);
    moment += rotor.inertia * rotor.angle.rate(state.acceleration.scalars);
    energy += 0.5 * rotor.inertia * rate * rate;
  }
  shaking_ = force;
  seen_.com = L * to_vector3(com_.at(state.position));
  seen_.com_velocity = L * to_vector3(com_.rate(state.velocity));
  seen_.com_acceleration = L * to_vector3(com_.rate(state.acceleration));
  seen_.shaking_force = L * to_vector3(force);
  seen_.shaking_moment.z() = L * L * moment;
  seen_.kinetic_energy = L * L * energy;
}

/// M q̈ less weight, loads, springs and friction, on the unknowns: what constraints and actuators must supply.
VectorX NaturalSampleEvaluator::needed_forces(const NaturalStepper& stepper) {
  const NaturalState& state = stepper.state();
  const double L = model_.length();
  const int moving = model_.basic.moving;
  std::vector<Complex> applied(state.position.points.size());
  loads_ = applied_.add_forces(state.position, state.time, applied);
  VectorX needed = VectorX::Zero(model_.unknowns());
  for (int k = 0; k < moving; ++k) {
    const Complex force = inertia_[static_cast<std::size_t>(k)] - applied[static_cast<std::size_t>(k)];
    needed[2 * k] = force.real();
    needed[2 * k + 1] = force.imag();
  }
  VectorX scalars = VectorX::Zero(model_.scalars);
  applied_.add_joint_springs(state.position, scalars.data());
  needed.tail(model_.scalars) -= scalars;
  for (const Rotor& rotor : model_.rotors)
    for (const ScalarTerm& term : rotor.angle.terms)
      needed[2 * moving + term.scalar] +=
          term.coefficient * rotor.inertia * rotor.angle.rate(state.acceleration.scalars);
  const auto unit = [&](std::size_t c) { return mechanism_.coordinates[c].kind == CoordinateKind::length ? L : 1; };
  double fastest = 0;
  for (Eigen::Index c = 0; c < seen_.velocity.size(); ++c)
    fastest = std::max(fastest, std::abs(seen_.velocity[c]) / unit(static_cast<std::size_t>(c)));
  const double rest = rest_rate_threshold(fastest, stepper.duration());
  for (const Friction& friction : mechanism_.friction) {
    const auto c = static_cast<std::size_t>(friction.coordinate);
    const double rate = seen_.velocity[friction.coordinate];
    const double resistance = sliding_friction(friction, rate, sliding_sign(rate, rest * unit(c)));
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      needed[2 * moving + term.scalar] += term.coefficient * resistance / (L * L);
  }
  return needed;
}

/// Φᵀ λ + Sᵀ u = needed; along the motions N that the constraints allow Φ N = 0, so that Nᵀ Sᵀ u = Nᵀ needed.
bool NaturalSampleEvaluator::solve_efforts(const NaturalStepper& stepper) {
  const double L = model_.length();
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  const VectorX needed = needed_forces(stepper);
  const MatrixX motions = stepper.equations().allowed_velocities();
  MatrixX actuation = MatrixX::Zero(motors, motions.cols());  // rates of the actuated coordinates, a length's by L
  VectorX unit = VectorX::Ones(motors);                       // of least norm: a force counts as its moment on L
  for (Eigen::Index a = 0; a < motors; ++a) {
    const auto c = static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)]);
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      actuation.row(a) += term.coefficient * motions.row(2 * model_.basic.moving + term.scalar);
    if (mechanism_.coordinates[c].kind == CoordinateKind::length) unit[a] = L;
  }
  actuation = unit.cwiseInverse().asDiagonal() * actuation;
  // columns of equal size: what drives the mechanism must not decide what holds it
  const VectorX size = motions.colwise().norm().transpose().cwiseMax(1e-300).cwiseInverse();
  actuation = actuation * size.asDiagonal();
  const VectorX right = L * L * size.cwiseProduct(motions.transpose() * needed);
  CompleteOrthogonalDecomposition qr;
  qr.setThreshold(1e-10);
  qr.compute(actuation.transpose());
  const VectorX efforts = qr.solve(right).cwiseQuotient(unit);
  for (Eigen::Index a = 0; a < motors; ++a) {
    seen_.effort[a] = efforts[a];
    seen_.power[a] = efforts[a] * seen_.velocity[mechanism_.actuators[static_cast<std::size_t>(a)]];
  }
  return qr.rank() == freedoms_;
}

MatrixX NaturalSampleEvaluator::actuation_matrix(const NaturalKinematicEquations& equations,
                                                 const NaturalCoordinates& position) const {
  const auto motors = static_cast<Eigen::Index>(mechanism_.actuators.size());
  MatrixX out = MatrixX::Zero(equations.constraint_count() + motors, equations.unknown_count());
  out.topRows(equations.constraint_count()) = equations.constraint_jacobian(position);
  for (Eigen::Index a = 0; a < motors; ++a) {
    const auto c = static_cast<std::size_t>(mechanism_.actuators[static_cast<std::size_t>(a)]);
    for (const ScalarTerm& term : model_.coordinates[c].form.terms)
      out(equations.constraint_count() + a, 2 * model_.basic.moving + term.scalar) += term.coefficient;
  }
  return out;
}

}  // namespace balance::natural
