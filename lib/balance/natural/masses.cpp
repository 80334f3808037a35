#include "balance/natural/model.hpp"

namespace balance::natural {

namespace {

NaturalInertia inertia_at(double mass, const Vector3& place, double about_com, double length) {
  const Complex r = to_complex(place, length);
  return {mass, mass * r, about_com / (length * length) + mass * std::norm(r)};
}

/// What is rigidly fixed to a body, itself included. A disc's centre of mass does not move in its carrier.
NaturalInertia sum_carried_inertia(const Mechanism& mechanism, int b, double length) {
  const Body& body = mechanism.bodies[static_cast<std::size_t>(b)];
  NaturalInertia sum = inertia_at(body.mass, body.com, body.inertia(2, 2), length);
  for (const Attachment& extra : mechanism.attachments)
    if (extra.body == b) sum += inertia_at(extra.mass, extra.position, extra.inertia(2, 2), length);
  for (const Disc& disc : mechanism.discs)
    if (disc.body == b) sum += inertia_at(disc.mass, disc.position, 0, length);
  return sum;
}

}  // namespace

void add_masses(const Mechanism& mechanism, NaturalModel& model) {
  model.total_mass = balance::total_mass(mechanism);
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    const NaturalInertia inertia = sum_carried_inertia(mechanism, static_cast<int>(b), model.length());
    const std::vector<BodyPoint>& points = model.basic.bodies[b].points;
    if (model.basic.bodies[b].has_mass_triangle) {
      const Matrix3 M =
          three_point_mass(isotropic_moments(inertia), points[0].position, points[1].position, points[2].position);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          model.mass.push_back(
              {points[static_cast<std::size_t>(i)].point, points[static_cast<std::size_t>(j)].point, M(i, j)});
      continue;
    }
    const Eigen::Matrix2cd M = two_point_mass(inertia, points[0].position, points[1].position);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        model.mass.push_back(
            {points[static_cast<std::size_t>(i)].point, points[static_cast<std::size_t>(j)].point, M(i, j)});
  }
  for (const Disc& disc : mechanism.discs) {
    Rotor rotor{disc.inertia(2, 2) / (model.length() * model.length()), {}};
    if (disc.body == ground) model.ground_disc_moment += disc.mass * to_complex(disc.position, model.length());
    const BodyModel& carrier = model.bodies[static_cast<std::size_t>(disc.body)];
    if (carrier.angle >= 0) rotor.angle.terms.push_back({carrier.angle, 1});
    for (const auto& [coordinate, ratio] : disc.follows.terms) {
      const ScalarAffineForm& leader = model.coordinates[static_cast<std::size_t>(coordinate)].form;
      rotor.angle.constant += disc.ratio * ratio * leader.constant;
      for (const ScalarTerm& term : leader.terms)
        rotor.angle.terms.push_back({term.scalar, disc.ratio * ratio * term.coefficient});
    }
    model.rotors.push_back(rotor);
  }
}

}  // namespace balance::natural
