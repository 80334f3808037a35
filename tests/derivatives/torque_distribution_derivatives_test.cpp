// Derivatives of distributed efforts and of the reactions that they cause are what differences of runs come to, except
// where the active bounds change.

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/model/mechanism_conversion.hpp"
#include "balance/mechanics/trajectory/trajectory_conversion.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

using namespace balance;
using derivatives::DualNumber;

namespace {

/// A number of any mechanism.
template <class T>
T& number(MechanismOf<T>& mechanism, std::size_t k) {
  model::EffortShareOf<T>&first = mechanism.torque_distribution->shares[0],
  &second = mechanism.torque_distribution->shares[1];
  switch (k) {
    case 0: return mechanism.bodies[2].mass;
    case 1: return mechanism.joints[1].point_first.x();
    case 2: return first.weight;
    case 3: return second.upper ? *second.upper : second.weight;
    default: return first.preload ? *first.preload : second.weight;
  }
}
constexpr std::size_t numbers = 5;

struct Redundant {
  std::string config, actuators;
};

Study read(const Redundant& which, const std::string& distribution) {
  const Study plain = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + which.config);
  std::string text = plain.spec_text;
  const std::size_t begin = text.find("actuators:"), end = text.find('\n', begin);
  text.replace(begin, end - begin, "actuators: " + which.actuators + "\ntorque_distribution: " + distribution);
  return read_spec(text, which.config);
}

}  // namespace

TEST_CASE("derivatives of every distribution of efforts are differences of runs") {
  const Redundant five_bar{"5r.yaml", "[A1, A2, B1]"}, three_legs{"3rrr.yaml", "[A1, A2, A3, B1, B2]"};
  const std::vector<std::pair<Redundant, std::string>> cases = {
      {five_bar, "{method: least-peak}"},
      {five_bar, "{weights: {A1: 2}}"},
      {five_bar, "{limits: {A1: 4, A2: 3.5, B1: 1}, weights: {B1: 3}}"},  // exceeded
      {five_bar, "{method: least-peak, limits: {A2: 2.5}, weights: {A1: 2}}"},
      {five_bar, "{preload: {A1: 2}, limits: {A2: 6}}"},
      {three_legs, "{method: least-peak, limits: {B1: 1}}"},
      {three_legs, "{limits: [30, 20, 30, 3, 30], preload: {A1: 1}}"}};
  for (const auto& [which, distribution] : cases) {
    CAPTURE(which.config);
    CAPTURE(distribution);
    const Study study = read(which, distribution);
    Trajectory trajectory = study.trajectories[0];
    trajectory.samples = 31;
    MechanismOf<DualNumber> dual =
        model::convert_mechanism<DualNumber>(study.mechanism, [](double x) { return DualNumber(x); });
    for (std::size_t k = 0; k < numbers; ++k) number(dual, k).d[k] += 1;
    const derivatives::RunGradient gradient = derivatives::differentiate_run(
        dual, trajectory::cast_scalar<DualNumber>(trajectory, [](double x) { return DualNumber(x); }));
    REQUIRE(gradient.run.outcome.status == MotionStatus::done);
    Eigen::Index smooth = 0;
    for (std::size_t k = 0; k < numbers; ++k) {
      CAPTURE(k);
      constexpr double h = 1e-5;
      const auto moved = [&](double step) {
        Mechanism mechanism = study.mechanism;
        number(mechanism, k) += step;
        return simulate(mechanism, trajectory);
      };
      const RunResult up = moved(h), down = moved(-h);
      for (Samples RunResult::*array : {&RunResult::torque, &RunResult::power, &RunResult::joint_force}) {
        const Samples slope = (up.*array - down.*array) / (2 * h), &now = gradient.run.*array;
        // round-off of the runs over h, and h² of a third derivative
        const double tolerance = 1e-6 * slope.cwiseAbs().maxCoeff() + 1e-7 * now.cwiseAbs().maxCoeff();
        for (Eigen::Index row = 0; row < slope.rows(); ++row) {
          const double kink =
              ((up.*array).row(row) - 2 * now.row(row) + (down.*array).row(row)).cwiseAbs().maxCoeff() / h;
          if (kink > 1e3 * tolerance) continue;
          ++smooth;
          CHECK((gradient.derivatives[k].*array - slope).row(row).cwiseAbs().maxCoeff() < tolerance);
        }
      }
    }
    CHECK(smooth > 3 * 31 * static_cast<Eigen::Index>(numbers) * 9 / 10);
  }
}
