// Energy is kept.

#include "runs.hpp"

#include "balance/mechanics/results/body_poses.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace laws;

namespace {

double load_power(const Run& run, const Samples& points, const std::vector<Total>& forces, long k) {
  double power = 0;  // of a rigid body: force · velocity of its origin + moment about the origin · angular velocity
  const double h = run.step();
  for (std::size_t b = 1; b < forces.size(); ++b) {
    const long c = 12 * static_cast<long>(b);
    Vector3 v;
    Matrix3 dR;
    for (int i = 0; i < 3; ++i) v[i] = rate(points, k, c + i, h);
    for (int i = 0; i < 9; ++i) dR(i % 3, i / 3) = rate(points, k, c + 3 + i, h);
    const Matrix3 W = dR * run.poses[k][b].R.transpose();
    const Vector3 w(W(2, 1), W(0, 2), W(1, 0));
    power += forces[b].force.dot(v) + (forces[b].moment - run.poses[k][b].p.cross(forces[b].force)).dot(w);
  }
  return power;
}

/// Origins and axes of all bodies as columns, to be differentiated.
Samples pose_columns(const Run& run) {
  const long bodies = static_cast<long>(run.mechanism.bodies.size());
  Samples out(run.samples(), 12 * bodies);
  for (long k = 0; k < run.samples(); ++k)
    for (long b = 0; b < bodies; ++b) {
      const Pose& pose = run.poses[k][b];
      out.row(k).segment<3>(12 * b) = pose.p.transpose();
      out.row(k).segment<9>(12 * b + 3) = pose.R.reshaped().transpose();
    }
  return out;
}

}  // namespace

namespace {

/// Damping times the square of the rate of the length.
double damper_losses(const Run& run, long k) {
  double sum = 0;
  if (run.mechanism.force_elements.empty()) return sum;
  const auto bodies = balance::results::body_motions_at(run.mechanism, run.result.joint_position.row(k).transpose(),
                                                        run.result.joint_velocity.row(k).transpose(),
                                                        run.result.joint_acceleration.row(k).transpose());
  for (const balance::ForceElement& element : run.mechanism.force_elements) {
    if (!element.is_damper()) continue;
    const auto &a = bodies[element.first], &b = bodies[element.second];
    const Vector3 d = b.point_position(element.point_second) - a.point_position(element.point_first);
    const double rate =
        d.normalized().dot(b.point_velocity(element.point_second) - a.point_velocity(element.point_first));
    sum += element.damping * rate * rate;
  }
  return sum;
}

}  // namespace

TEST_CASE("motors and loads supply what friction takes and the change of kinetic and potential energy") {
  for_each_run(401, [](const Run& run) {
    const Samples columns = pose_columns(run);
    const Samples energy = run.result.kinetic_energy + run.result.potential_energy;
    const double h = run.step();
    Worst worst;
    double scale = 1e-9 * energy.cwiseAbs().maxCoeff() / h;  // of a steady motion no power is to be seen
    for (long k = 0; k < run.samples(); ++k)
      if (run.smooth[k])
        scale = std::max({scale, run.result.power.row(k).cwiseAbs().sum(),
                          std::abs(rate(run.result.kinetic_energy, k, 0, h)),
                          std::abs(rate(run.result.potential_energy, k, 0, h))});
    for (long k = 0; k < run.samples(); ++k) {
      if (!run.smooth[k]) continue;
      double power = load_power(run, columns, loads(run, k), k);
      for (std::size_t a = 0; a < run.mechanism.actuators.size(); ++a)
        power += run.result.torque(k, static_cast<long>(a)) * run.result.joint_velocity(k, run.mechanism.actuators[a]);
      for (const balance::Friction& friction : run.mechanism.friction) {
        const double v = run.result.joint_velocity(k, friction.coordinate);
        power -= friction.viscous * v * v + friction.dry_friction(v < 0 ? -1 : 1) * std::abs(v);
      }
      power -= damper_losses(run, k);
      worst.see(std::abs(power - rate(energy, k, 0, h)) / scale, k);
    }
    // energies are differentiated by differences of order six on 401 samples
    CHECK_MESSAGE(worst.error < 3e-5, run.name << " sample " << worst.sample << ": " << worst.error);
  });
}

TEST_CASE("kinetic energy is that of moving points, potential energy that of weight and springs") {
  for_each_run(401, [](const Run& run) {
    const Cloud points = cloud(run);
    const double most = run.result.kinetic_energy.maxCoeff();
    Worst kinetic, potential;
    for (long k = 0; k < run.samples(); ++k) {
      double height = 0, motion = 0, size = 0;
      for (std::size_t i = 0; i < points.mass.size(); ++i) {
        const double work = points.mass[i] * run.mechanism.gravity.dot(points.place(k, static_cast<long>(i)));
        height -= work, size += std::abs(work);
        if (run.smooth[k])
          motion += 0.5 * points.mass[i] * points.velocity(k, static_cast<long>(i), run.step()).squaredNorm();
      }
      for (const balance::Spring& spring : run.mechanism.springs) {
        if (spring.is_joint_spring()) {
          const double q = run.result.joint_position(k, spring.coordinate);
          height += (0.5 * spring.stiffness * q - spring.preload) * q;
          size += 0.5 * spring.stiffness * q * q + std::abs(spring.preload * q);
          continue;
        }
        const Pose &a = run.poses[k][spring.first], &b = run.poses[k][spring.second];
        const double stretch =
            (b.p + b.R * spring.point_second - a.p - a.R * spring.point_first).norm() - spring.free_length;
        height += 0.5 * spring.stiffness * stretch * stretch, size += 0.5 * spring.stiffness * stretch * stretch;
      }
      for (const balance::ForceElement& element : run.mechanism.force_elements) {
        if (element.is_damper()) continue;
        const balance::model::ForceLawOf<double> law(element.table);
        double stored = 0;
        if (element.is_in_joint()) {
          stored = -law.energy(run.result.joint_position(k, element.coordinate));
        } else {
          const Pose &a = run.poses[k][element.first], &b = run.poses[k][element.second];
          stored = law.energy((b.p + b.R * element.point_second - a.p - a.R * element.point_first).norm());
        }
        height += stored, size += std::abs(stored);
      }
      if (size > 0) potential.see(std::abs(height - run.result.potential_energy(k, 0)) / size, k);
      if (run.smooth[k]) kinetic.see(std::abs(motion - run.result.kinetic_energy(k, 0)) / most, k);
    }
    CHECK_MESSAGE(kinetic.error < 1e-6, run.name << " sample " << kinetic.sample << ": " << kinetic.error);
    // the points were walked to through every joint, each closed to 1e-12
    CHECK_MESSAGE(potential.error < 1e-10, run.name << " sample " << potential.sample << ": " << potential.error);
  });
}

TEST_CASE("power is effort times rate of the actuated coordinate") {
  for_each_run(51, [](const Run& run) {
    for (long k = 0; k < run.samples(); ++k)
      for (std::size_t a = 0; a < run.mechanism.actuators.size(); ++a)
        CHECK(run.result.power(k, static_cast<long>(a)) ==
              run.result.torque(k, static_cast<long>(a)) * run.result.joint_velocity(k, run.mechanism.actuators[a]));
  });
}
