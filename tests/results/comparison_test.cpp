#include "balance/interface/comparison/comparison.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace balance;
using namespace balance::comparison;

namespace {

NamedRun run(const std::string& name, const std::string& trajectory, int samples, double duration = 0.1) {
  const Study study = read_spec_file(BALANCE_CONFIGS "/3rrr.yaml");
  const auto found = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                                  [&](const Trajectory& one) { return one.name == trajectory; });
  REQUIRE(found != study.trajectories.end());
  Trajectory changed = *found;
  changed.samples = samples;
  changed.duration = duration;
  return {name, name + ".h5", "3RRR", trajectory, "", "", simulate(study.mechanism, changed)};
}

const ComparedQuantity& find(const ComparedRuns& compared, const std::string& quantity) {
  const auto found = std::find_if(compared.quantities.begin(), compared.quantities.end(),
                                  [&](const ComparedQuantity& one) { return one.quantity == quantity; });
  REQUIRE(found != compared.quantities.end());
  return *found;
}

}  // namespace

TEST_CASE("a run is no different from itself") {
  const NamedRun one = run("a", "bang-bang", 51);
  NamedRun same = one;
  same.name = "b";
  const ComparedRuns compared = compare_runs({one, same});
  for (const ComparedQuantity& quantity : compared.quantities) {
    INFO(quantity.quantity);
    REQUIRE(quantity.differences[1]);
    CHECK(quantity.differences[1]->largest == 0);
    CHECK(quantity.differences[1]->rms == 0);
    if (quantity.metrics[0]->peak > 0) CHECK(ratio_to_base(quantity, 1, Statistic::peak) == 1);
  }
  CHECK(compared.notes.empty());
}

TEST_CASE("the same motion on other samples is the same, jumps and all") {
  // 500 samples have none at the jump in the middle, the others have.
  for (const int samples : {101, 64}) {
    const ComparedRuns compared = compare_runs({run("fine", "bang-bang", 500), run("coarse", "bang-bang", samples)});
    for (const char* quantity : {"torque[A1]", "torque", "shaking_force", "shaking_moment", "joint_force"}) {
      INFO(quantity, " ", samples);
      const ComparedQuantity& one = find(compared, quantity);
      REQUIRE(one.differences[1]);
      // Fourth derivatives of the torques are about 1e3 per duration^4: (1/500)^4 of it.
      CHECK(one.differences[1]->largest < 1e-7 * one.metrics[0]->peak);
    }
    CHECK(compared.notes.size() == 1);
  }
}

TEST_CASE("in twice the time every force is a quarter, at equal fractions of the time") {
  const ComparedRuns compared = compare_runs({run("fast", "cycloid", 401), run("slow", "cycloid", 401, 0.2)});
  for (const char* quantity : {"torque[A3]", "shaking_force", "shaking_moment", "joint_force[B1]"}) {
    INFO(quantity);
    const ComparedQuantity& one = find(compared, quantity);
    for (const Statistic figure : {Statistic::peak, Statistic::rms, Statistic::mean, Statistic::range})
      CHECK(ratio_to_base(one, 1, figure) == doctest::Approx(0.25).epsilon(1e-9));
    CHECK(one.differences[1]->largest == doctest::Approx(0.75 * one.metrics[0]->peak).epsilon(1e-9));
    CHECK(one.differences[1]->rms == doctest::Approx(0.75 * one.metrics[0]->rms).epsilon(1e-9));
    CHECK(one.differences[1]->time == doctest::Approx(one.metrics[0]->peak_time));
  }
  REQUIRE(compared.notes.size() == 1);
  CHECK(compared.notes[0].find("equal fractions") != std::string::npos);
}

TEST_CASE("differences are of vectors, not of their magnitudes") {
  NamedRun one = run("a", "cycloid", 21), turned = one;
  turned.name = "turned";
  turned.result.shaking_force *= -1;
  const ComparedRuns compared = compare_runs({one, turned});
  const ComparedQuantity& force = find(compared, "shaking_force");
  CHECK(force.differences[1]->largest == doctest::Approx(2 * force.metrics[0]->peak).epsilon(1e-14));
  CHECK(find(compared, "torque").differences[1]->largest == 0);
}

TEST_CASE("the worst is the worst of its parts") {
  NamedRun one = run("a", "cycloid", 21), other = one;
  other.name = "other";
  other.result.torque.col(1).array() += 3;
  other.result.torque.col(2).array() += 2;
  const ComparedRuns compared = compare_runs({one, other});
  CHECK(find(compared, "torque").differences[1]->largest == doctest::Approx(3));
  CHECK(find(compared, "torque").differences[1]->rms == doctest::Approx(3));
  CHECK(find(compared, "torque[A3]").differences[1]->rms == doctest::Approx(2));
  const ComparedQuantity& reaction = find(compared, "joint_force");
  double peak = 0, rms = 0;
  for (const ComparedQuantity& quantity : compared.quantities) {
    if (!quantity.quantity.starts_with("joint_force[")) continue;
    peak = std::max(peak, quantity.metrics[0]->peak);
    rms = std::max(rms, quantity.metrics[0]->rms);
  }
  CHECK(reaction.metrics[0]->peak == peak);
  CHECK(reaction.metrics[0]->rms == rms);
}

TEST_CASE("what one run lacks is missing, not zero") {
  NamedRun one = run("a", "cycloid", 11), other = one;
  other.name = "other";
  std::erase_if(other.result.metrics, [](const Metric& metric) { return metric.quantity == "torque[A1]"; });
  other.result.joint_force.resize(0, 0);
  other.result.actuator_names[1] = "B1";
  const ComparedRuns compared = compare_runs({one, other});
  CHECK_FALSE(find(compared, "torque[A1]").metrics[1]);
  CHECK_FALSE(find(compared, "torque[A1]").differences[1]);
  CHECK(std::isnan(ratio_to_base(find(compared, "torque[A1]"), 1, Statistic::peak)));
  CHECK_FALSE(find(compared, "joint_force").differences[1]);
  CHECK_FALSE(find(compared, "torque[A2]").differences[1]);
  CHECK(find(compared, "torque[A3]").differences[1]);
}

TEST_CASE("figures of different units are not compared") {
  NamedRun one = run("a", "cycloid", 11), other = one;
  other.name = "other";
  for (Metric& metric : other.result.metrics) metric.unit = metric.quantity == "torque[A1]" ? "N" : metric.unit;
  const ComparedQuantity torque = find(compare_runs({one, other}), "torque[A1]");
  CHECK(torque.metrics[0]);
  CHECK_FALSE(torque.metrics[1]);
  CHECK_FALSE(torque.differences[1]);
}

TEST_CASE("runs without samples and comparisons without runs do no harm") {
  NamedRun one = run("a", "cycloid", 11), empty;
  empty.name = "empty";
  const ComparedRuns compared = compare_runs({one, empty});
  CHECK_FALSE(find(compared, "torque").metrics[1]);
  CHECK(compare_runs({empty, one}).runs.size() == 2);
  CHECK_THROWS_AS(compare_runs({}), std::invalid_argument);
}
