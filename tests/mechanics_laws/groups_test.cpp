// Moments that are found many at once are those that the stepper finds one after another.

#include "runs.hpp"

#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/recorder.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/group_stepper.hpp"
#include "balance/motion/time_optimal/resolve_trajectory.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <optional>

using namespace laws;
using namespace balance;
using namespace balance::results;

namespace {

struct Tracked {
  RunResult result;
  long in_groups = 0;
};

/// The samples, in groups with one of the instruction sets or without groups.
template <class S>
Tracked follow(const Run& run, std::optional<InstructionSet> set) {
  const Trajectory trajectory = time_optimal::resolve_trajectory(run.mechanism, run.trajectory).trajectory;
  const kinematics::CompiledMotion<S> motion(run.mechanism, trajectory);
  dynamics::TreeMotionSource<S> source(run.mechanism, motion, trajectory.about, dynamics::Detail::all);
  Tracked out;
  name_columns(run.mechanism, out.result);
  resize_arrays(run.mechanism, trajectory.samples, {}, out.result);
  ResultRecorder recorder(out.result);
  const auto record = [&](trajectory::MotionSource& leader) {
    CHECK(visit_time_grid(leader, trajectory.samples, [&](const trajectory::TimeGridPoint& stop) {
      if (!leader.evaluate()) return false;
      if (!set) source.evaluator().sample().mobility = source.stepper().mobility();
      if (stop.kind == trajectory::TimeGridPoint::Kind::sample) recorder.write(leader.sample(), stop.index, out.result);
      return true;
    }));
  };
  if (!set) {
    record(source);
    return out;
  }
  simulation::GroupStepper<S> leader(source, trajectory.samples, *set);
  record(leader);
  out.in_groups = leader.group_step_count();
  return out;
}

Tracked follow(const Run& run, std::optional<InstructionSet> set) {
  return run.mechanism.space == SpaceKind::planar ? follow<kinematics::Planar>(run, set)
                                                  : follow<kinematics::Spatial>(run, set);
}

bool same_bits(const Samples& a, const Samples& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * 8) == 0;
}

/// What of an array's numbers may differ: a motion is solved when its equations miss by 1e-12 of the ground's extent, and rates are off
/// by the inverse of the mobility times that, in both of two runs; the stepper proves a mobility to 2e-9 (MinSingularValue::compute_from_factors).
double allowed(const Run& run, const RunResult& result, Samples RunResult::*array) {
  if (array == &RunResult::mobility) return 2e-9;
  return 2e-12 * std::max(1.0, ground_extent(run.mechanism)) / std::min(1.0, result.mobility.minCoeff());
}

/// Largest difference of an array by the size of the terms that its numbers are sums of.
double difference(const Run& run, const Samples& a, const Samples& b, Samples RunResult::*array) {
  double worst = 0;
  for (Eigen::Index c = 0; c < a.cols(); ++c) {
    const double terms = std::max(column_term_magnitude(run.result, run.result.term_magnitudes, array, c),
                                  a.col(c).cwiseAbs().maxCoeff());
    if (terms > 0) worst = std::max(worst, (a.col(c) - b.col(c)).cwiseAbs().maxCoeff() / terms);
  }
  return worst;
}

}  // namespace

TEST_CASE(
    "what is found of many moments at once is what the stepper finds, with every instruction set to the same bits") {
  long in_groups = 0, all = 0;
  for_each_run(161, [&](const Run& run) {
    CAPTURE(run.name);
    const Tracked alone = follow(run, {}), baseline = follow(run, InstructionSet::baseline);
    in_groups += baseline.in_groups;
    all += run.samples();
    for (const QuantityDefinition& kind : quantity_table()) {
      const Samples &expected = alone.result.*kind.member, &found = baseline.result.*kind.member;
      if (expected.size() == 0) continue;
      CAPTURE(std::string(kind.name));
      CHECK(difference(run, expected, found, kind.member) <= allowed(run, alone.result, kind.member));
    }
    for (const InstructionSet set : list_instruction_sets()) {
      const Tracked other = follow(run, set);
      for (const QuantityDefinition& kind : quantity_table())
        CHECK(same_bits(other.result.*kind.member, baseline.result.*kind.member));
    }
  });
  CHECK(in_groups > all / 4);
}
