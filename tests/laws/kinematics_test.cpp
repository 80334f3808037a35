// Positions, velocities and accelerations of the joints, of the tool and of the centre of mass belong together.

#include "runs.hpp"

#include "balance/base/rotation.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace laws;

TEST_CASE("every joint's coordinates say how its two bodies lie to each other, so every loop stays closed") {
  // The motion is solved to 1e-12 of the mechanism's size; walking through a loop adds up a few of these.
  for_each_run(201, [](const Run& run) {
    Worst worst;
    for (long k = 0; k < run.samples(); ++k) {
      long c = 0;
      for (const balance::Joint& joint : run.mechanism.joints) {
        const VectorX q = run.result.joint_position.row(k).transpose();
        const Pose d = displacement(joint, run.result.axes == 2, q.data() + c);
        c += balance::freedom(joint.type);
        const Pose &a = run.poses[k][joint.first], &b = run.poses[k][joint.second];
        const Vector3 P = a.p + a.R * (joint.point_first + d.p), Q = b.p + b.R * joint.point_second;
        worst.see((Q - P).norm() / run.length(), k);
        worst.see((a.R * d.R - b.R).cwiseAbs().maxCoeff(), k);
      }
    }
    CHECK_MESSAGE(worst.error < 1e-11, run.name << " sample " << worst.sample << ": " << worst.error);
  });
}

TEST_CASE("coupled coordinates keep their ratio") {
  for_each_run(51, [](const Run& run) {
    for (const balance::Coupling& coupling : run.mechanism.couplings)
      for (long k = 0; k < run.samples(); ++k) {
        const auto& q = run.result.joint_position;
        const double want = coupling.ratio * q(k, coupling.leader) + coupling.offset;
        CHECK(q(k, coupling.follower) == doctest::Approx(want).epsilon(1e-14));
      }
  });
}

TEST_CASE("joint velocities and accelerations are the rates of the joint coordinates") {
  // 401 samples and differences of order six: below 1e-6 of the largest rate, also where a mechanism hurries.
  for_each_run(401, [](const Run& run) {
    const double h = run.step();
    for (long c = 0; c < run.result.joint_position.cols(); ++c) {
      const double v = run.result.joint_velocity.col(c).cwiseAbs().maxCoeff();
      const double a = run.result.joint_acceleration.col(c).cwiseAbs().maxCoeff();
      const double T = run.result.time[run.samples() - 1];
      const double unit = run.mechanism.coordinates[c].kind == balance::CoordinateKind::length ? run.length() : 1;
      Worst velocity, acceleration;
      for (long k = 0; k < run.samples(); ++k) {
        if (!run.smooth[k]) continue;
        const auto& q = run.result.joint_position;
        velocity.see(std::abs(rate(q, k, c, h) - run.result.joint_velocity(k, c)) / (v + unit / T), k);
        acceleration.see(std::abs(second_rate(q, k, c, h) - run.result.joint_acceleration(k, c)) / (a + unit / T / T),
                         k);
      }
      const std::string where = run.name + ", " + run.result.coordinate_names[c];
      CHECK_MESSAGE(velocity.error < 1e-6, where << " sample " << velocity.sample << ": " << velocity.error);
      CHECK_MESSAGE(acceleration.error < 1e-5,
                    where << " sample " << acceleration.sample << ": " << acceleration.error);
    }
  });
}

TEST_CASE("the tool lies where its body carries it") {
  for_each_run(101, [](const Run& run) {
    if (!run.mechanism.tool) return;
    const balance::Tool& tool = *run.mechanism.tool;
    Worst place, turn;
    for (long k = 0; k < run.samples(); ++k) {
      const Pose& body = run.poses[k][tool.body];
      place.see((run.row(run.result.tool_position, k) - body.p - body.R * tool.position).norm() / run.length(), k);
      const auto o = run.result.tool_orientation.row(k);
      const Matrix3 R = run.result.axes == 2 ? balance::rotation_about(Vector3::UnitZ(), o[0])
                                             : Eigen::Quaterniond(o[0], o[1], o[2], o[3]).toRotationMatrix();
      turn.see((R - body.R).cwiseAbs().maxCoeff(), k);
    }
    CHECK_MESSAGE(place.error < 1e-11, run.name << " sample " << place.sample << ": " << place.error);
    CHECK_MESSAGE(turn.error < 1e-11, run.name << " sample " << turn.sample << ": " << turn.error);
  });
}
