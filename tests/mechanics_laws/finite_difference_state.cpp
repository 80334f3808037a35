#include "finite_difference_state.hpp"

#include "random_mechanism_classes.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <array>
#include <cmath>

namespace laws {

namespace {

/// Value, first and second derivative at the middle of seven equidistant values: the error is of order six.
template <class T>
std::array<T, 3> derivatives(const std::array<T, 7>& f, double h) {
  return {f[3], T((45 * (f[4] - f[2]) - 9 * (f[5] - f[1]) + (f[6] - f[0])) / (60 * h)),
          T((270 * ((f[4] - f[3]) + (f[2] - f[3])) - 27 * ((f[5] - f[3]) + (f[1] - f[3])) +
             2 * ((f[6] - f[3]) + (f[0] - f[3]))) /
            (180 * h * h))};
}

Moving moving(const std::array<Pose, 7>& poses, double h) {
  std::array<Matrix3, 7> R;
  std::array<Vector3, 7> p;
  for (int i = 0; i < 7; ++i) R[i] = poses[i].R, p[i] = poses[i].p;
  const auto turn = derivatives(R, h);
  const auto place = derivatives(p, h);
  return {turn[0], turn[1], turn[2], place[0], place[1], place[2]};
}

/// Twice the axial vector of a matrix's antisymmetric part: Σ aᵢ × bᵢ of A = Σ bᵢ aᵢᵀ.
Vector3 crossed(const Matrix3& A) { return {A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)}; }

Mass mass_of(double m, const Vector3& com, const Matrix3& inertia, bool planar) {
  const Matrix3 about_com = planar ? Matrix3(Vector3(inertia(2, 2) / 2, inertia(2, 2) / 2, 0).asDiagonal())
                                   : Matrix3(inertia.trace() / 2 * Matrix3::Identity() - inertia);
  return {m, m * com, about_com + m * com * com.transpose()};
}

Pose element_pose(const Element& element, const std::vector<Pose>& bodies, const VectorX& q) {
  const Pose& body = bodies[element.body];
  if (!element.disc) return body;
  const double angle = element.disc->ratio * element.disc->follows.evaluate(q);
  return {body.R * balance::rotation_about(element.disc->axis, angle), body.p + body.R * element.disc->position};
}

}  // namespace

Vector3 Moving::angular_velocity() const { return 0.5 * crossed(dR * R.transpose()); }

std::vector<Element> elements(const Mechanism& m) {
  const bool planar = m.space == balance::SpaceKind::planar;
  std::vector<Element> out;
  for (std::size_t b = 1; b < m.bodies.size(); ++b)
    out.push_back(
        {static_cast<int>(b), nullptr, mass_of(m.bodies[b].mass, m.bodies[b].com, m.bodies[b].inertia, planar)});
  for (const balance::Attachment& extra : m.attachments)
    out.push_back({extra.body, nullptr, mass_of(extra.mass, extra.position, extra.inertia, planar)});
  for (const balance::Disc& disc : m.discs)
    out.push_back({disc.body, &disc, mass_of(disc.mass, Vector3::Zero(), disc.inertia, planar)});
  return out;
}

Instant instant(const Run& run, const std::vector<Element>& elements, long k) {
  const VectorX q = run.result.joint_position.row(k).transpose(), v = run.result.joint_velocity.row(k).transpose(),
                a = run.result.joint_acceleration.row(k).transpose();
  double rate = 1e-3 / run.trajectory.duration;  // of angles, and of lengths in characteristic lengths
  for (Eigen::Index c = 0; c < q.size(); ++c) {
    const double unit =
        run.mechanism.coordinates[c].kind == balance::CoordinateKind::length ? std::max(run.length(), 1e-300) : 1;
    rate = std::max({rate, std::abs(v[c]) / unit, std::sqrt(std::abs(a[c]) / unit)});
  }
  const double h = 0.02 / rate;
  std::vector<std::array<Pose, 7>> bodies(run.mechanism.bodies.size()), parts(elements.size());
  std::array<VectorX, 7> open;
  for (int i = 0; i < 7; ++i) {
    const double s = (i - 3) * h;
    const VectorX there = q + s * (v + s / 2 * a);
    const std::vector<Pose> world = poses(run.mechanism, there);
    for (std::size_t b = 0; b < world.size(); ++b) bodies[b][i] = world[b];
    for (std::size_t e = 0; e < elements.size(); ++e) parts[e][i] = element_pose(elements[e], world, there);
    open[i] = disagreement(run.mechanism, there);
  }
  Instant out;
  for (const auto& body : bodies) out.bodies.push_back(moving(body, h));
  for (const auto& part : parts) out.elements.push_back(moving(part, h));
  const auto opened = derivatives(open, h);
  out.open = opened[0], out.open_rate = opened[1], out.open_second_rate = opened[2];
  return out;
}

Total momentum_rate(const Moving& f, const Mass& mass) {
  const Vector3 b = f.R * mass.mc, ddb = f.ddR * mass.mc;
  return {mass.m * f.ddp + ddb,
          mass.m * f.p.cross(f.ddp) + f.p.cross(ddb) + b.cross(f.ddp) + crossed(f.ddR * mass.S * f.R.transpose())};
}

Total momentum(const Moving& f, const Mass& mass) {
  const Vector3 b = f.R * mass.mc, db = f.dR * mass.mc;
  return {mass.m * f.dp + db,
          mass.m * f.p.cross(f.dp) + f.p.cross(db) + b.cross(f.dp) + crossed(f.dR * mass.S * f.R.transpose())};
}

double kinetic_energy(const Moving& f, const Mass& mass) {
  return 0.5 * mass.m * f.dp.squaredNorm() + f.dp.dot(f.dR * mass.mc) +
         0.5 * (f.dR * mass.S * f.dR.transpose()).trace();
}

double kinetic_energy_rate(const Moving& f, const Mass& mass) {
  return mass.m * f.dp.dot(f.ddp) + f.ddp.dot(f.dR * mass.mc) + f.dp.dot(f.ddR * mass.mc) +
         (f.ddR * mass.S * f.dR.transpose()).trace();
}

}  // namespace laws
