/// Numbers that are known for the 3RRR of P3 with its corrected Table 1, by natural coordinates alone.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace balance;
using namespace balance::verification;

namespace {

RunResult run(const std::string& file, const std::string& name, long samples) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS "/") + file);
  for (Trajectory trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    trajectory.samples = samples;
    RunResult result = simulate_natural(study.mechanism, trajectory);
    REQUIRE_MESSAGE(result.outcome.status == MotionStatus::done, result.outcome.reason);
    return result;
  }
  FAIL("no such trajectory");
  return {};
}

double peak(const RunResult& result, const std::string& quantity) {
  return std::find_if(result.metrics.begin(), result.metrics.end(),
                      [&](const Metric& metric) { return metric.quantity == quantity; })
      ->peak;
}

/// The digits that are known end at the tenth.
doctest::Approx near(double value) { return doctest::Approx(value).epsilon(1e-10); }

}  // namespace

TEST_CASE("3RRR in natural coordinates: torques, shaking force and moment of the cycloidal tool at t = 0.03 s") {
  const RunResult r = run("3rrr.yaml", "cycloid", 1001);
  CHECK(r.time[300] == near(0.03));
  CHECK(r.torque(300, 0) == near(-64.97649026082));
  CHECK(r.torque(300, 1) == near(-32.09674328625));
  CHECK(r.torque(300, 2) == near(103.2428123385));
  CHECK(r.shaking_force(300, 0) == near(661.6027130426));
  CHECK(r.shaking_force(300, 1) == near(433.8951170309));
  CHECK(r.shaking_moment(300, 0) == near(-4.490699595200));
}

TEST_CASE("3RRR in natural coordinates: the centre of mass at the start and at the end") {
  const RunResult r = run("3rrr.yaml", "cycloid", 11);
  CHECK(r.com_position(0, 0) == doctest::Approx(-0.0669026392).epsilon(1e-9));
  CHECK(r.com_position(0, 1) == doctest::Approx(-0.0386231395).epsilon(1e-9));
  CHECK(r.com_position(10, 0) == doctest::Approx(0.0564875650).epsilon(1e-9));
  CHECK(r.com_position(10, 1) == doctest::Approx(0.0511127906).epsilon(1e-9));
}

TEST_CASE("3RRR in natural coordinates: with its centre of mass on bang-bang the force is constant") {
  const RunResult r = run("3rrr.yaml", "bang-bang", 201);
  CHECK(peak(r, "shaking_force") == near(549.2528818391));
  CHECK(r.shaking_force.rowwise().norm().minCoeff() == near(549.2528818391));
  CHECK(peak(r, "shaking_moment") == doctest::Approx(58.1842).epsilon(1e-6));
}

TEST_CASE(
    "3RRR in natural coordinates: redistributed cranks (P3 eq. 61) under a bang-bang tool give 360 sqrt(1.25) N") {
  const RunResult r = run("3rrr-redistributed.yaml", "tool-bang", 201);
  CHECK(peak(r, "shaking_force") == near(360 * std::sqrt(1.25)));
  CHECK(r.shaking_force.rowwise().norm().minCoeff() == near(360 * std::sqrt(1.25)));
}
