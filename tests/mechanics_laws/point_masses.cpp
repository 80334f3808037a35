#include "runs.hpp"

#include "balance/foundation/base/rotation.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/results/body_poses.hpp"

#include <algorithm>
#include <cmath>

namespace laws {

namespace {

/// Points fixed to a carrier, or to a disc on it.
struct Lump {
  int body;
  const balance::Disc* disc;
  double mass;    ///< of each point
  Vector3 place;  ///< in the carrier's axes, disc at coordinate zero
};

/// Pairs of points on the principal axes: with n points of m / n each at ± d on axis k, ∫ x_k² dm = 2 m d² / n.
void spread(int body, const balance::Disc* disc, double mass, const Vector3& com, const Matrix3& inertia, bool planar,
            std::vector<Lump>& lumps) {
  if ((mass == 0 && inertia.isZero(0)) || (body == balance::model::ground && !disc))
    return;         // a disc turns on the ground too
  if (mass == 0) {  // inertia alone: what a mass does, less itself at its centre
    mass = 1;
    lumps.push_back({body, disc, -mass, com});
  }
  Matrix3 axes = Matrix3::Identity();
  Vector3 second(0.5 * inertia(2, 2), 0.5 * inertia(2, 2), 0);  // ∫ x_k² dm
  if (!planar) {
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia);
    axes = solver.eigenvectors();
    second = Vector3::Constant(0.5 * solver.eigenvalues().sum()) - solver.eigenvalues();
  }
  const int dimension = planar ? 2 : 3;
  for (int k = 0; k < dimension; ++k)
    for (const double sign : {-1.0, 1.0})
      lumps.push_back({body, disc, mass / (2 * dimension),
                       com + sign * std::sqrt(std::max(0.0, second[k]) * dimension / mass) * axes.col(k)});
}

std::vector<Lump> lumps(const Mechanism& m) {
  const bool planar = m.space == balance::SpaceKind::planar;
  std::vector<Lump> out;
  for (std::size_t b = 1; b < m.bodies.size(); ++b)
    spread(static_cast<int>(b), nullptr, m.bodies[b].mass, m.bodies[b].com, m.bodies[b].inertia, planar, out);
  for (const balance::Attachment& extra : m.attachments)
    spread(extra.body, nullptr, extra.mass, extra.position, extra.inertia, planar, out);
  for (const balance::Disc& disc : m.discs)
    spread(disc.body, &disc, disc.mass, disc.position, disc.inertia, planar, out);
  return out;
}

/// The cubic through four entries, which is what their not-a-knot spline is.
Vector3 cubic(const balance::Load& load, const std::vector<Vector3>& entries, double argument) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    double weight = 1;
    for (std::size_t j = 0; j < 4; ++j)
      if (j != i) weight *= (argument - load.arguments[j]) / (load.arguments[i] - load.arguments[j]);
    sum += weight * entries[i];
  }
  return sum;
}

/// Force and moment of a load at a time or coordinate: linear between the entries, held beyond them, or a cubic.
void interpolate(const balance::Load& load, double argument, Vector3& force, Vector3& moment) {
  if (load.is_spline) {
    argument = std::clamp(argument, load.arguments.front(), load.arguments.back());
    force = cubic(load, load.force, argument), moment = cubic(load, load.moment, argument);
    return;
  }
  std::size_t k = 0;
  while (k < load.arguments.size() && load.arguments[k] <= argument) ++k;
  const std::size_t next = std::min(k, load.force.size() - 1), last = k == 0 ? 0 : k - 1;
  const double part =
      next == last ? 0 : (argument - load.arguments[last]) / (load.arguments[next] - load.arguments[last]);
  force = (1 - part) * load.force[last] + part * load.force[next];
  moment = (1 - part) * load.moment[last] + part * load.moment[next];
}

}  // namespace

Cloud cloud(const Run& run) {
  const std::vector<Lump> all = lumps(run.mechanism);
  Cloud out;
  out.position.resize(run.samples(), 3 * static_cast<long>(all.size()));
  for (const Lump& lump : all) out.mass.push_back(lump.mass), out.body.push_back(lump.body);
  for (long k = 0; k < run.samples(); ++k)
    for (std::size_t i = 0; i < all.size(); ++i) {
      Vector3 place = all[i].place;
      if (const balance::Disc* disc = all[i].disc) {
        const double angle = disc->ratio * disc->follows.evaluate(run.result.joint_position.row(k));
        place = disc->position + balance::rotation_about(disc->axis, angle) * (place - disc->position);
      }
      const Pose& pose = run.poses[k][all[i].body];
      out.position.row(k).segment<3>(3 * static_cast<long>(i)) = (pose.p + pose.R * place).transpose();
    }
  return out;
}

Vector3 Cloud::velocity(long k, long point, double h) const {
  return {rate(position, k, 3 * point, h), rate(position, k, 3 * point + 1, h), rate(position, k, 3 * point + 2, h)};
}

Vector3 Cloud::acceleration(long k, long point, double h) const {
  return {second_rate(position, k, 3 * point, h), second_rate(position, k, 3 * point + 1, h),
          second_rate(position, k, 3 * point + 2, h)};
}

std::vector<Total> momentum_rates(const Run& run, const Cloud& cloud, long k) {
  std::vector<Total> out(run.mechanism.bodies.size());
  for (std::size_t i = 0; i < cloud.mass.size(); ++i) {
    const long point = static_cast<long>(i);
    out[cloud.body[i]].add(cloud.mass[i] * cloud.acceleration(k, point, run.step()), cloud.place(k, point));
  }
  return out;
}

std::vector<Total> weights(const Run& run, const Cloud& cloud, long k) {
  std::vector<Total> out(run.mechanism.bodies.size());
  for (std::size_t i = 0; i < cloud.mass.size(); ++i)
    out[cloud.body[i]].add(cloud.mass[i] * run.mechanism.gravity, cloud.place(k, static_cast<long>(i)));
  return out;
}

std::vector<Total> loads(const Run& run, long k) {
  std::vector<Total> out(run.mechanism.bodies.size());
  for (const balance::Load& load : run.mechanism.loads) {
    if (load.body == balance::model::ground) continue;
    const Pose& pose = run.poses[k][load.body];
    Vector3 force, moment;
    const double argument =
        load.is_over_coordinate() ? run.result.joint_position(k, load.coordinate) : run.result.time[k];
    interpolate(load, argument, force, moment);
    if (load.frame == balance::model::Frame::body) force = pose.R * force, moment = pose.R * moment;
    out[load.body].add(force, pose.p + pose.R * load.point, moment);
  }
  return out;
}

namespace {

/// Dampers and springs with a table between points. Velocities are those of the kinematics alone.
void add_force_elements(const Run& run, long k, std::vector<Total>& out) {
  if (run.mechanism.force_elements.empty()) return;
  const std::vector<balance::results::BodyMotion> bodies = balance::results::body_motions_at(
      run.mechanism, run.result.joint_position.row(k).transpose(), run.result.joint_velocity.row(k).transpose(),
      run.result.joint_acceleration.row(k).transpose());
  for (const balance::ForceElement& element : run.mechanism.force_elements) {
    if (element.is_in_joint()) continue;  // part of what the joint transmits
    const auto &a = bodies[element.first], &b = bodies[element.second];
    const Vector3 P = a.point_position(element.point_first), Q = b.point_position(element.point_second);
    const double length = (Q - P).norm();
    if (!(length > 0)) continue;
    const Vector3 u = (Q - P) / length;
    const double rate = u.dot(b.point_velocity(element.point_second) - a.point_velocity(element.point_first));
    const double tension =
        element.is_damper() ? element.damping * rate : balance::model::ForceLawOf<double>(element.table).force(length);
    out[element.first].add(tension * u, P);
    out[element.second].add(-tension * u, Q);
  }
}

}  // namespace

std::vector<Total> springs(const Run& run, long k) {
  std::vector<Total> out(run.mechanism.bodies.size());
  for (const balance::Spring& spring : run.mechanism.springs) {
    if (spring.is_joint_spring()) continue;  // part of what the joint transmits
    const Pose &a = run.poses[k][spring.first], &b = run.poses[k][spring.second];
    const Vector3 P = a.p + a.R * spring.point_first, Q = b.p + b.R * spring.point_second;
    const double length = (Q - P).norm();
    const Vector3 pull =
        length > 0 ? Vector3(spring.stiffness * (length - spring.free_length) * (Q - P) / length) : Vector3(0, 0, 0);
    out[spring.first].add(pull, P);
    out[spring.second].add(-pull, Q);
  }
  add_force_elements(run, k, out);
  return out;
}

std::vector<Total> keepers(const Run& run, long k) {
  using Of = balance::model::GeneralisedSpeedTerm::Kind;
  std::vector<Total> out(run.mechanism.bodies.size());
  for (std::size_t c = 0; c < run.mechanism.constraints.size(); ++c)
    for (const balance::model::GeneralisedSpeedTerm& term : run.mechanism.constraints[c].terms) {
      if (term.kind == Of::coordinate) continue;
      const Pose& pose = run.poses[k][term.body];
      const bool own = term.kind == Of::velocity_body || term.kind == Of::angular_velocity_body;
      const Vector3 axis = own ? Vector3(pose.R.col(term.index)) : Vector3(Vector3::Unit(term.index));
      const Vector3 push = run.result.constraint_force(k, static_cast<long>(c)) * term.factor * axis;
      const Vector3 P = pose.p + pose.R * term.position;
      const bool turns = term.kind == Of::angular_velocity || term.kind == Of::angular_velocity_body;
      const Vector3 none = Vector3::Zero();
      out[term.body].add(turns ? none : push, P, turns ? push : none);
      out[balance::model::ground].add(turns ? none : Vector3(-push), P, turns ? Vector3(-push) : none);
    }
  return out;
}

std::vector<Total> reactions(const Run& run, long k) {
  std::vector<Total> out(run.mechanism.bodies.size());
  for (std::size_t j = 0; j < run.mechanism.joints.size(); ++j) {
    const balance::Joint& joint = run.mechanism.joints[j];
    const Pose& b = run.poses[k][joint.second];
    const Vector3 Q = b.p + b.R * joint.point_second;
    const Vector3 force = run.row(run.result.joint_force, k, static_cast<long>(j));
    const Vector3 moment = run.moment(run.result.joint_moment, k, static_cast<long>(j));
    out[joint.second].add(force, Q, moment);
    out[joint.first].add(-force, Q, -moment);
  }
  return out;
}

double force_scale(const Run& run, const Cloud& cloud) {
  double largest = 0;
  for (long k = 0; k < run.samples(); ++k) {
    if (!run.smooth[k]) continue;
    double sum = 0;
    for (std::size_t i = 0; i < cloud.mass.size(); ++i)
      sum += cloud.mass[i] * cloud.acceleration(k, static_cast<long>(i), run.step()).norm();
    largest = std::max(largest, sum);
  }
  return largest;
}

}  // namespace laws
