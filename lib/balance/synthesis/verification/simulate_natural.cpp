#include "balance/synthesis/verification/simulate_natural.hpp"

#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/kinematics/joint_coordinates.hpp"
#include "balance/motion/simulation/run_recorder.hpp"
#include "balance/synthesis/verification/natural_motion_source.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance::verification {

NaturalStart find_natural_start(const Mechanism& mechanism, const Trajectory& trajectory) {
  const kinematics::CompiledMotion<kinematics::Planar> motion(mechanism, trajectory);
  dynamics::TreeMotionSource<kinematics::Planar> source(mechanism, motion, trajectory.about,
                                                        dynamics::Detail::kinematics);
  if (source.outcome().status != MotionStatus::done) return {source.outcome(), {}};
  if (const std::string& mismatch = source.evaluator().actuation().mismatch(); !mismatch.empty())
    return {{MotionStatus::mismatch, 0, mismatch, {}}, {}};
  if (!source.begin()) return {source.outcome(), {}};
  source.evaluate();
  const Sample& sample = source.sample();
  return {source.outcome(), {{sample.position.begin(), sample.position.end()}, sample.tool_angle}};
}

NaturalStart find_natural_start(const Mechanism& mechanism) {
  const kinematics::Tree<kinematics::Planar> tree = kinematics::compile_tree<kinematics::Planar>(mechanism, {});
  kinematics::ConstraintSystem<kinematics::Planar> closures(tree, kinematics::Drive<kinematics::Planar>{});
  const kinematics::AssemblySolution assembly = kinematics::solve_pose(mechanism, tree, closures, {});
  NaturalStart result;
  if (!assembly.found) {
    result.outcome = {MotionStatus::not_assembled, 0, "the loops cannot be closed", {}};
    return result;
  }
  result.outcome.status = MotionStatus::done;
  result.start.coordinates = compute_coordinates(mechanism, tree, assembly.y);
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const kinematics::LinearQuantity& expression = tree.coordinate_expressions[c];
    if (expression.has_terms())  // with its whole turns
      result.start.coordinates[c] = expression.value(assembly.y.data());
  }
  return result;
}

namespace {

class NaturalRun : public simulation::RunRecorder {
 public:
  NaturalRun(const Mechanism& mechanism, const Trajectory& trajectory, const natural::InitialCoordinates& start,
             const simulation::Progress& progress)
      : simulation::RunRecorder(mechanism, trajectory, progress), source_(mechanism, trajectory, start) {}

  RunResult run() { return record(source_, {.reactions = false}, 1 << 8); }

 private:
  /// Magnitudes of terms depend on the mechanism, not on the formulation: the first one measures them at a few samples.
  void set_term_magnitudes(RunResult& result) override {
    Trajectory coarse = trajectory_;
    coarse.samples = std::min(coarse.samples, 101L);
    const RunResult measured = simulate(mechanism_, coarse);
    result.term_magnitudes = measured.term_magnitudes;
    result.round_off = measured.round_off;
  }

  std::vector<std::string> actuation_notes() override { return source_.notes(); }

  natural::NaturalMotionSource source_;
};

}  // namespace

RunResult simulate_natural(const Mechanism& mechanism, const Trajectory& trajectory,
                           const simulation::Progress& progress) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("natural coordinates do not support constraints on speeds");
  return simulation::run_resolved(mechanism, trajectory, [&](const Mechanism& modelled, const Trajectory& resolved) {
    const NaturalStart start = find_natural_start(modelled, resolved);
    if (start.outcome.status == MotionStatus::done) return NaturalRun(modelled, resolved, start.start, progress).run();
    RunResult result;
    result.outcome = start.outcome;
    return result;
  });
}

}  // namespace balance::verification
