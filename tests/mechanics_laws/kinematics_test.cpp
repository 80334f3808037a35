// Positions, velocities and accelerations of the joints, of the tool and of the centre of mass belong together.

#include "runs.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace laws;

TEST_CASE("every joint's coordinates say how its two bodies lie to each other, so every loop stays closed") {
  // The motion is solved to 1e-12 of the mechanism's size; walking through a loop adds up several of these, enlarged by
  // levers longer than the size.
  for_each_run(201, [](const Run& run) {
    Worst worst;
    for (long k = 0; k < run.samples(); ++k) {
      long c = 0;
      for (const balance::Joint& joint : run.mechanism.joints) {
        const VectorX q = run.result.joint_position.row(k).transpose();
        const Pose d = displacement(joint, run.result.axes == 2, q.data() + c);
        c += balance::model::joint_degrees_of_freedom(joint.type);
        const Pose &a = run.poses[k][joint.first], &b = run.poses[k][joint.second];
        const Vector3 P = a.p + a.R * (joint.point_first + d.p), Q = b.p + b.R * joint.point_second;
        worst.see((Q - P).norm() / run.length(), k);
        worst.see((a.R * d.R - b.R).cwiseAbs().maxCoeff(), k);
      }
    }
    CHECK_MESSAGE(worst.error < 1e-10, run.name << " sample " << worst.sample << ": " << worst.error);
  });
}

TEST_CASE("coupled coordinates keep their ratio") {
  for_each_run(51, [](const Run& run) {
    for (const balance::Coupling& coupling : run.mechanism.couplings)
      for (long k = 0; k < run.samples(); ++k) {
        const auto& q = run.result.joint_position;
        const double want = coupling.ratio * coupling.leader.evaluate(q.row(k)) + coupling.offset;
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
      CHECK_MESSAGE(acceleration.error < 3e-5,
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
    CHECK_MESSAGE(place.error < 1e-10, run.name << " sample " << place.sample << ": " << place.error);
    CHECK_MESSAGE(turn.error < 1e-10, run.name << " sample " << turn.sample << ": " << turn.error);
  });
}

namespace {

/// How far a straight run from the first to the last row is from following the law.
double off_course(const Samples& array, const VectorX& s, long columns) {
  const long last = array.rows() - 1;
  const Samples way = s * (array.row(last) - array.row(0)) + VectorX::Ones(s.size()) * array.row(0);
  return (array - way).leftCols(columns).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("what is driven goes straight from its start to its end by the law") {
  for_each_run(101, [](const Run& run) {
    const balance::Trajectory& t = run.trajectory;
    if (!std::holds_alternative<balance::trajectory::LinePath>(t.path)) return;
    VectorX s(run.samples());
    for (long k = 0; k < run.samples(); ++k)
      s[k] = balance::trajectory::evaluate(t.law, run.result.time[k] / t.duration).s;
    const long position = std::min<long>(run.result.axes, static_cast<long>(run.mechanism.actuators.size()));
    const double allowed = 1e-10 * run.length();
    if (t.drive == balance::DriveKind::com)
      CHECK_MESSAGE(off_course(run.result.com_position, s, position) < allowed, run.name);
    if (t.drive == balance::DriveKind::tool && t.components.empty()) {
      CHECK_MESSAGE(off_course(run.result.tool_position, s, position) < allowed, run.name);
      const Eigen::Index end = run.samples() - 1;
      if (t.from.tool) CHECK((run.row(run.result.tool_position, 0) - *t.from.tool).norm() < allowed);
      if (t.to.tool) CHECK((run.row(run.result.tool_position, end) - *t.to.tool).norm() < allowed);
      if (t.from.orientation && t.to.orientation)  // the shortest rotation, by the same law
        for (long k = 0; k <= end; ++k) {
          const Vector3 turn = balance::rotation_vector_of(t.from.orientation->transpose() * *t.to.orientation);
          const Matrix3 want = *t.from.orientation * balance::rotation_from_rotation_vector(s[k] * turn);
          CHECK((run.poses[k][run.mechanism.tool->body].R - want).cwiseAbs().maxCoeff() < 1e-10);
        }
    }
    if (t.drive == balance::DriveKind::joints)
      for (const balance::CoordinateValue& from : t.from.joints)
        for (const balance::CoordinateValue& to : t.to.joints) {
          if (from.coordinate != to.coordinate) continue;
          const VectorX want = VectorX::Constant(s.size(), from.value) + (to.value - from.value) * s;
          CHECK_MESSAGE((run.result.joint_position.col(from.coordinate) - want).cwiseAbs().maxCoeff() < 1e-10,
                        run.name);
        }
  });
}
