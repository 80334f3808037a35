// 3RRR of P3 (Table 1 with the corrections of docs/errata.md): numbers that two independent formulations agree on.

#include "published.hpp"

#include "balance/mechanics/dynamics/tree_motion_source.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace published;

namespace {

/// To all printed digits of a figure: half a unit of the last one.
void check_digits(double got, double want, double last_digit) { CHECK(std::abs(got - want) <= 0.5001 * last_digit); }
/// To 1e-10, which is what thirteen printed digits and a motion solved to 1e-12 leave.
void check_close(double got, double want) { CHECK(std::abs(got - want) < 1e-10 * std::abs(want)); }

/// Root of the plain average over the samples, which the published figures are; the result's own rms averages over time.
double plain_rms(const RunResult& r) {
  return std::sqrt(r.shaking_moment.squaredNorm() / static_cast<double>(r.time.size()));
}

/// Shaking force and moment on one side of a time.
struct Shake {
  double force, moment;
};
Shake shake_at(const std::string& file, const std::string& name, double time, balance::trajectory::Side side) {
  using namespace balance;
  const Study study = load(file);
  const Trajectory t = make_trajectory(study, name);
  const kinematics::CompiledMotion<kinematics::Planar> motion(study.mechanism, t);
  dynamics::TreeMotionSource<kinematics::Planar> source(study.mechanism, motion, t.about, dynamics::Detail::forces);
  REQUIRE(source.begin());
  for (int k = 1; k <= 100; ++k) REQUIRE(source.advance(time * k / 100));
  source.update_accelerations(side);
  REQUIRE(source.evaluate());
  return {source.sample().shaking_force.norm(), source.sample().shaking_moment.z()};
}

}  // namespace

TEST_CASE("3RRR: the centre of mass starts and ends where P3 says") {
  const RunResult r = run("3rrr.yaml", "cycloid", 11);
  const Eigen::Vector2d start = r.com_position.row(0), end = r.com_position.row(10);
  CHECK((start - Eigen::Vector2d(-0.0669026392, -0.0386231395)).cwiseAbs().maxCoeff() < 0.5001e-10);
  CHECK((end - Eigen::Vector2d(0.0564875650, 0.0511127906)).cwiseAbs().maxCoeff() < 0.5001e-10);
}

TEST_CASE("3RRR: torques, shaking force and moment at t = 0.03 s of the cycloidal motion") {
  const RunResult r = run("3rrr.yaml", "cycloid", 101);
  const long k = 30;
  CHECK(r.time[k] == doctest::Approx(0.03).epsilon(1e-14));
  check_close(r.torque(k, 0), -64.97649026082);
  check_close(r.torque(k, 1), -32.09674328625);
  check_close(r.torque(k, 2), 103.2428123385);
  check_close(r.shaking_force(k, 0), 661.6027130426);
  check_close(r.shaking_force(k, 1), 433.8951170309);
  check_close(r.shaking_moment(k, 0), -4.490699595200);
}

TEST_CASE("3RRR: peaks of the cycloidal motion on 2,001 samples") {
  const RunResult r = run("3rrr.yaml", "cycloid", 2001);
  check_close(metric(r, "shaking_force").peak, 869.7458473278);
  CHECK(metric(r, "shaking_force").peak_time == doctest::Approx(0.07505).epsilon(1e-12));
  check_close(metric(r, "shaking_moment").peak, 57.30320609995);
  check_digits(plain_rms(r), 27.68, 0.01);
}

TEST_CASE("3RRR: with the centre of mass on bang-bang the shaking force is constant, 4 m L / T^2") {
  const balance::Study study = load("3rrr.yaml");
  const RunResult r = run(study.mechanism, make_trajectory(study, "bang-bang", 2001));
  const double L = (r.com_position.row(2000) - r.com_position.row(0)).norm();
  for (long k = 0; k < 2001; ++k) {
    const double force = r.shaking_force.row(k).norm();
    check_close(force, 549.2528818391);
    check_close(force, 4 * balance::model::total_mass(study.mechanism) * L / 0.01);
  }
  CHECK(r.tool_orientation.cwiseAbs().maxCoeff() < 1e-11);
}

TEST_CASE("3RRR: with the centre of mass on bang-bang the tool leaves its chord by 12.21 mm") {
  const RunResult r = run("3rrr.yaml", "bang-bang", 2001);
  const Eigen::Vector2d from = r.tool_position.row(0), along = Eigen::Vector2d(2, 1).normalized();
  CHECK((r.tool_position.row(2000).transpose() - Eigen::Vector2d(0.1, 0.05)).norm() < 1e-11);
  double most = 0;
  for (long k = 0; k < 2001; ++k) {
    const Eigen::Vector2d d = r.tool_position.row(k).transpose() - from;
    most = std::max(most, std::abs(along.x() * d.y() - along.y() * d.x()));
  }
  check_digits(1000 * most, 12.21, 0.01);
}

TEST_CASE("3RRR: both sides of the tool's jump at T/2") {
  check_digits(shake_at("3rrr.yaml", "tool-bang", 0.05, balance::trajectory::Side::before).force, 627.8637745, 1e-7);
  check_digits(shake_at("3rrr.yaml", "tool-bang", 0.05, balance::trajectory::Side::after).force, 627.9160195, 1e-7);
}

TEST_CASE("3RRR: the moment under the guided centre of mass at T/2, on both sides and one sample later") {
  const Shake left = shake_at("3rrr.yaml", "bang-bang", 0.05, balance::trajectory::Side::before);
  const Shake right = shake_at("3rrr.yaml", "bang-bang", 0.05, balance::trajectory::Side::after);
  check_digits(right.moment, 58.1842, 1e-4);
  const RunResult r = run("3rrr.yaml", "bang-bang", 2001);
  check_digits(r.shaking_moment(1000, 0), 58.1842, 1e-4);
  check_digits(r.shaking_moment(1001, 0), 58.1217, 1e-4);
  // the left value continues the samples before it: cubic extrapolation over steps of T / 2000
  const auto m = [&](long k) { return r.shaking_moment(k, 0); };
  CHECK(std::abs(left.moment - (4 * m(999) - 6 * m(998) + 4 * m(997) - m(996))) < 1e-6 * right.moment);
  CHECK(left.moment < right.moment);
}

TEST_CASE("3RRR: peaks count both sides of a jump, whether it falls on a sample or between two") {
  for (const long samples : {2001, 2000}) {
    CAPTURE(samples);
    check_digits(metric(run("3rrr.yaml", "tool-bang", samples), "shaking_force").peak, 627.9160195, 1e-7);
    check_digits(metric(run("3rrr.yaml", "bang-bang", samples), "shaking_moment").peak, 58.1842, 1e-4);
  }
}

TEST_CASE("3RRR: guiding the centre of mass lowers the moment's rms and raises its peak") {
  const RunResult tool = run("3rrr.yaml", "cycloid", 2001), com = run("3rrr.yaml", "bang-bang", 2001);
  // published with the value before the jump at T/2, where the sample holds the one after it
  const double before = shake_at("3rrr.yaml", "bang-bang", 0.05, balance::trajectory::Side::before).moment,
               after = com.shaking_moment(1000, 0);
  check_digits(std::sqrt(plain_rms(com) * plain_rms(com) + (before * before - after * after) / 2001), 23.83, 0.01);
  CHECK(metric(com, "shaking_moment").rms < metric(tool, "shaking_moment").rms);
  CHECK(metric(com, "shaking_moment").peak > metric(tool, "shaking_moment").peak);
}

TEST_CASE("3RRR redistributed: the centre of mass moves at half the tool's displacement") {
  for (const std::string name : {"cycloid", "tool-bang", "bang-bang"}) {
    CAPTURE(name);
    const RunResult r = run("3rrr-redistributed.yaml", name, 201);
    for (long k = 0; k < 201; ++k) {
      const auto com = (r.com_position.row(k) - r.com_position.row(0)).eval();
      const auto tool = (r.tool_position.row(k) - r.tool_position.row(0)).eval();
      // Table 1 gives the bearings to five digits, which does not matter; P3 eq. 53 to 60 are exact
      CHECK((com - 0.5 * tool).norm() < 1e-12);
    }
  }
}

TEST_CASE("3RRR redistributed: the tool's bang-bang gives a constant force of 360 sqrt(1.25) N") {
  const RunResult r = run("3rrr-redistributed.yaml", "tool-bang", 2001);
  for (long k = 0; k < 2001; ++k) check_close(r.shaking_force.row(k).norm(), 360 * std::sqrt(1.25));
  check_close(360 * std::sqrt(1.25), 402.4922359500);
}

TEST_CASE("3RRR redistributed: the torques are those of the original mechanism") {
  for (const std::string name : {"cycloid", "tool-bang"}) {
    const RunResult a = run("3rrr.yaml", name, 201), b = run("3rrr-redistributed.yaml", name, 201);
    CHECK((a.torque - b.torque).cwiseAbs().maxCoeff() < 1e-10 * a.torque.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("3RRR redistributed: peak force of the cycloidal motion") {
  check_digits(metric(run("3rrr-redistributed.yaml", "cycloid", 2001), "shaking_force").peak, 632.2333, 1e-4);
}
