// What torques add up from.

#include "configs.hpp"

#include "balance/mechanics/dynamics/effort_breakdown.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::dynamics;
using namespace equations;

TEST_CASE("the parts of every torque add up to it along every trajectory of every config") {
  for (const std::string& file : doors::every_config()) {
    const Study study = read_spec_file(file);
    for (Trajectory trajectory : study.trajectories) {
      CAPTURE(file);
      CAPTURE(trajectory.name);
      trajectory.samples = 9;
      const RunResult run = simulate(study.mechanism, trajectory);
      if (run.outcome.status != MotionStatus::done) continue;
      InverseOptions options;
      options.time_scale = run.time[run.time.size() - 1] - run.time[0];
      EquationTerms terms(study.mechanism, options);
      const StateTable states = extract_independent_states(terms, run);
      REQUIRE(assemble_at_row(terms, run).status == MotionStatus::done);
      for (Eigen::Index k = 0; k < states.q.rows(); ++k) {
        const auto split = terms.split_efforts(states.q.row(k), states.dq.row(k), states.ddq.row(k), run.time[k]);
        REQUIRE_MESSAGE(split, split.outcome.reason);
        const double size = largest(split.value.parts) + run.term_magnitudes.effort.maxCoeff();
        const VectorX sum = split.value.parts.rowwise().sum();
        CHECK(largest(sum - split.value.effort) <= 1e-12 * size);
        // rates and forces of the two ways differ by the loops' round-off, which grows near singularities
        CHECK(largest(sum - run.torque.row(k).transpose()) <= 1e-12 * size);
      }
    }
  }
}

TEST_CASE("a run's torques and the samples of their parts") {
  for (const char* file : {"3rrr.yaml", "spring-press.yaml", "delta.yaml", "control-5r.yaml"}) {
    CAPTURE(file);
    const Study study = doors::config(file);
    Trajectory trajectory = study.trajectories.front();
    trajectory.samples = 21;
    RunResult run = simulate(study.mechanism, trajectory);
    REQUIRE(run.outcome.status == MotionStatus::done);
    CHECK(run.torque_inertia.size() == 0);
    REQUIRE(add_effort_breakdown(study.mechanism, run).status == MotionStatus::done);
    const Samples sum = run.torque_inertia + run.torque_velocity + run.torque_friction + run.torque_weight +
                        run.torque_spring + run.torque_load;
    CHECK(largest(sum - run.torque) <= 1e-9 * (largest(run.torque) + run.term_magnitudes.effort.maxCoeff()));
    int parts = 0;
    for (const Quantity& quantity : list_sampled_quantities(run))
      parts += quantity.name.rfind("torque_", 0) == 0 ? 1 : 0;
    CHECK(parts == 6);
  }
}

TEST_CASE("each part is what its own cause does") {
  const Study study = doors::config("spring-press.yaml");
  const Mechanism& whole = study.mechanism;
  const auto all = start_of(study);
  EquationTerms terms(whole);
  const VectorX q = own(terms, all), dq = wave(q.size(), 0.2), ddq = 3 * wave(q.size(), 0.9);
  terms.assemble(q, all);
  const auto split = terms.split_efforts(q, dq, ddq, 0.1);
  REQUIRE(split);
  const auto effort_without = [&](auto&& change) {
    Mechanism less = whole;
    change(less);
    InverseDynamics door(less);
    std::vector<CoordinateGuess> near;
    for (const CoordinateValue& v : all)
      near.push_back({whole.coordinates[static_cast<std::size_t>(v.coordinate)].name, v.value});
    door.assemble(q, near);
    return VectorX(door.at(q, dq, ddq, 0.1).value.effort);
  };
  const auto part = [&](EffortPart p) { return VectorX(split.value.parts.col(static_cast<int>(p))); };
  const double size = largest(split.value.parts);
  const VectorX full = effort_without([](Mechanism&) {});
  CHECK(largest(full - effort_without([](Mechanism& m) { m.gravity.setZero(); }) - part(EffortPart::weight)) <=
        1e-10 * size);
  CHECK(largest(full - effort_without([](Mechanism& m) { m.springs.clear(); }) - part(EffortPart::spring)) <=
        1e-10 * size);
  CHECK(largest(full - effort_without([](Mechanism& m) { m.loads.clear(); }) - part(EffortPart::load)) <= 1e-10 * size);
  CHECK(largest(full - effort_without([](Mechanism& m) { m.friction.clear(); }) - part(EffortPart::friction)) <=
        1e-10 * size);
}

TEST_CASE("the inertia's part follows the accelerations, the velocities' part the squares of the rates") {
  for (const char* file : {"5r.yaml", "spatial-rrr.yaml", "delta.yaml"}) {
    CAPTURE(file);
    const Study study = doors::config(file);
    const auto all = start_of(study);
    EquationTerms terms(study.mechanism);
    const VectorX q = own(terms, all), dq = wave(q.size(), 0.2), ddq = wave(q.size(), 0.9);
    terms.assemble(q, all);
    const auto one = terms.split_efforts(q, dq, ddq), two = terms.split_efforts(q, 2 * dq, 3 * ddq);
    const auto own_terms = terms.independent_terms(q);
    REQUIRE(one);
    REQUIRE(two);
    const auto inertia = static_cast<int>(EffortPart::inertia), velocity = static_cast<int>(EffortPart::velocity);
    const double size = largest(two.value.parts);
    CHECK(largest(3 * one.value.parts.col(inertia) - two.value.parts.col(inertia)) <= 1e-12 * size);
    CHECK(largest(4 * one.value.parts.col(velocity) - two.value.parts.col(velocity)) <= 1e-12 * size);
    // motors at the independent coordinates: P0 eq. 62
    CHECK(largest(own_terms.value.mass * ddq - one.value.parts.col(inertia)) <= 1e-10 * size);
    for (Eigen::Index k = 0; k < q.size(); ++k)
      CHECK(std::abs(dq.dot(own_terms.value.velocity[static_cast<std::size_t>(k)] * dq) -
                     one.value.parts(k, velocity)) <= 1e-10 * size);
  }
}
