// What a task leaves open: splines, momentum as a drive, the law of steady momentum. Numbers from a second program to the digits given.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::trajectory;

namespace {

/// A config with other trajectories.
Study with_trajectories(const std::string& config, const std::string& trajectories) {
  std::ifstream file(std::string(BALANCE_CONFIGS) + "/" + config);
  std::stringstream all;
  all << file.rdbuf();
  std::string text = all.str();
  text = text.substr(0, text.find("\ntrajectories:")) + "\ntrajectories:\n" + trajectories;
  return read_spec(text, config);
}

const Metric& figure(const RunResult& result, const std::string& quantity) {
  for (const Metric& metric : result.metrics)
    if (metric.quantity == quantity) return metric;
  FAIL("no figure of " << quantity);
  return result.metrics.front();
}

double rms_of_moment(const Study& study, const std::vector<double>& coefficients, long samples) {
  Trajectory trajectory = study.trajectories.front();
  trajectory.samples = samples;
  std::get<SplineTask>(trajectory.secondary_tasks.front().kind).coefficients = coefficients;
  const RunResult result = simulate(study.mechanism, trajectory);
  REQUIRE(result.outcome.status == MotionStatus::done);
  return figure(result, "shaking_moment").rms;
}

}  // namespace

TEST_CASE("a clamped spline is zero with its rate at both ends, and smooth but for its jump") {
  for (const bool jump : {false, true}) {
    const numerics::PiecewiseChebyshevSeries course = make_clamped_bspline({0.3, -1.2, 0.7, 0.4}, jump);
    for (const auto& [place, side] : {std::pair{0.0, Side::after}, std::pair{1.0, Side::before}}) {
      CHECK(std::abs(evaluate_with_derivatives(course, place, side).value) < 1e-15);
      CHECK(std::abs(evaluate_with_derivatives(course, place, side).first) < 1e-13);
    }
    for (const numerics::Panel& panel : course.panels()) {
      if (panel.begin == 0) continue;
      const ValueWithDerivatives before = evaluate_with_derivatives(course, panel.begin, Side::before),
                                 after = evaluate_with_derivatives(course, panel.begin, Side::after);
      CHECK(after.value == doctest::Approx(before.value).epsilon(1e-13));
      CHECK(after.first == doctest::Approx(before.first).epsilon(1e-12));
      const bool jumps = std::abs(after.second - before.second) > 1e-9 * std::abs(before.second);
      CHECK(jumps == (jump && panel.begin == 0.5));
    }
    for (double x = 0.01; x < 1; x += 0.0173) {  // the derivatives are those of the value
      const double h = 1e-5;
      const auto at = [&](double place) { return evaluate_with_derivatives(course, place, Side::after); };
      CHECK(at(x).first == doctest::Approx((at(x + h).value - at(x - h).value) / (2 * h)).epsilon(1e-6));
    }
  }
}

TEST_CASE("B-splines add up to one where the ends do not count") {
  // with all coefficients 1 of many, the middle is covered by four full B-splines whose sum is 1
  const numerics::PiecewiseChebyshevSeries course = make_clamped_bspline(std::vector<double>(9, 1.0), false);
  for (double x = 0.4; x < 0.6; x += 0.01)
    CHECK(evaluate_with_derivatives(course, x, Side::after).value == doctest::Approx(1).epsilon(1e-14));
}

TEST_CASE("the guided 3RRR with the best splines shakes by the known moments, and by either formulation") {
  struct Known {
    std::string course;
    double rms;
  };
  const Study three = with_trajectories(
      "3rrr.yaml",
      "  calm: {law: bang-bang, drive: com, remaining: {angle: {spline: [0.2225976, 0.7124682, 0.4718127]}}}\n");
  const std::vector<double> best =
      std::get<SplineTask>(three.trajectories.front().secondary_tasks.front().kind).coefficients;
  const double least = rms_of_moment(three, best, 20001);
  CHECK(least == doctest::Approx(7.615992).epsilon(1e-6));
  for (std::size_t k = 0; k < best.size(); ++k)  // a minimum: any step makes it larger
    for (const double step : {-0.01, 0.01}) {
      std::vector<double> other = best;
      other[k] += step;
      CHECK(rms_of_moment(three, other, 20001) > least);
    }
  const RunResult tree = simulate(three.mechanism, three.trajectories.front());
  const RunResult natural = verification::simulate_natural(three.mechanism, three.trajectories.front());
  REQUIRE(natural.outcome.status == MotionStatus::done);
  const double size = figure(tree, "shaking_moment").peak;
  CHECK((tree.shaking_moment - natural.shaking_moment).cwiseAbs().maxCoeff() < 1e-9 * size);
  CHECK(figure(tree, "shaking_force").peak ==
        doctest::Approx(549.2528818391).epsilon(1e-9));  // the spline leaves the force alone
}

TEST_CASE("momentum kept at zero leaves no shaking moment, whatever the law") {
  Study study = with_trajectories("3rrr.yaml",
                                  "  still: {law: bang-bang, drive: com, remaining: {angle: {momentum: zero}}}\n"
                                  "  soft: {law: cycloidal, drive: com, remaining: {angle: {momentum: zero}}}\n"
                                  "  plain: {law: bang-bang, drive: com}\n");
  for (Body& body : study.mechanism.bodies)
    if (body.name == "platform") body.inertia(2, 2) = 0.02;
  const RunResult plain = simulate(study.mechanism, study.trajectories[2]);
  const double before = figure(plain, "shaking_moment").peak;
  for (int k = 0; k < 2; ++k) {
    const RunResult still = simulate(study.mechanism, study.trajectories[static_cast<std::size_t>(k)]);
    REQUIRE(still.outcome.status == MotionStatus::done);
    CHECK(still.shaking_moment.cwiseAbs().maxCoeff() < 1e-10 * before);
    const Eigen::Index last = still.tool_position.rows() - 1;
    CHECK(still.tool_position(last, 0) == doctest::Approx(0.09610128).epsilon(1e-7));
    CHECK(still.tool_position(last, 1) == doctest::Approx(0.05038704).epsilon(1e-7));
  }
  const RunResult natural = verification::simulate_natural(study.mechanism, study.trajectories[0]);
  REQUIRE(natural.outcome.status == MotionStatus::done);
  CHECK(natural.shaking_moment.cwiseAbs().maxCoeff() < 1e-9 * before);
}

TEST_CASE("momentum cannot be kept where the open coordinate no longer changes it") {
  const Study study =
      with_trajectories("3rrr.yaml", "  still: {law: bang-bang, drive: com, remaining: {angle: {momentum: zero}}}\n");
  const RunResult result = simulate(study.mechanism, study.trajectories.front());
  CHECK(result.outcome.status == MotionStatus::drive_singularity);
  CHECK(result.outcome.reason.find("at 0.1") == 0);  // % of the path
  CHECK(result.outcome.reason.find("-0.00053976") != std::string::npos);
}

TEST_CASE("a law of steady momentum needs a flywheel, and then takes the shaking moment away") {
  const std::string even =
      "  even: {law: steady-momentum, drive: joints, turns: 1, duration: 0.5}\n"
      "  steady: {law: uniform, drive: joints}\n";
  Study study = with_trajectories("four-bar-force-balance.yaml", even);
  for (Attachment& one : study.mechanism.attachments) {  // Berkof and Lowen's counterweights, see the config
    const Vector3 moment = one.name == "cw1" ? Vector3(-0.07 - 0.02, 0.008, 0) : Vector3(-0.175 - 0.125, -0.02, 0);
    one.mass = moment.norm() / 0.1;
    one.position = moment / one.mass;
  }
  const RunResult without = simulate(study.mechanism, study.trajectories[0]);
  CHECK(without.outcome.status == MotionStatus::limits_not_held);
  INFO(without.outcome.reason);
  CHECK(without.outcome.reason.find("from -0.0269271") != std::string::npos);
  CHECK(without.outcome.reason.find("to 0.0617903") != std::string::npos);
  for (Body& body : study.mechanism.bodies)
    if (body.name == "crank") body.inertia(2, 2) += 0.06;
  const RunResult steady = simulate(study.mechanism, study.trajectories[1]);
  const RunResult kept = simulate(study.mechanism, study.trajectories[0]);
  REQUIRE(kept.outcome.status == MotionStatus::done);
  CHECK(kept.optimised_law->momentum == doctest::Approx(0.973500179).epsilon(1e-8));
  CHECK(figure(steady, "shaking_moment").peak == doctest::Approx(9.604799).epsilon(1e-4));
  CHECK(figure(kept, "shaking_moment").peak < 1e-7 * figure(steady, "shaking_moment").peak);
  CHECK(figure(kept, "torque").rms == doctest::Approx(13.874490).epsilon(1e-5));
}
