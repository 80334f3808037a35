#include "balance/natural/forces.hpp"

#include "balance/natural/drive.hpp"

#include <algorithm>

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

}  // namespace balance::natural
