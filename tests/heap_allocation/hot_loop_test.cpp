// The hot loop takes nothing from the heap: one step of the motion and all forces at it.

#include "heap.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/motion/control/plant.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <vector>

namespace {

using namespace balance;
using namespace balance::dynamics;

/// Requests made while the samples after the first few are computed.
template <class S>
long requests(const Mechanism& mechanism, const Trajectory& trajectory, Detail detail) {
  const kinematics::CompiledMotion<S> motion(mechanism, trajectory);
  TreeMotionSource<S> source(mechanism, motion, trajectory.about, detail);
  bool good = source.begin() && source.evaluate();
  REQUIRE_MESSAGE(good, source.outcome().reason);
  constexpr int samples = 400, warm = 3;
  long before = 0;
  for (int k = 1; k <= samples; ++k) {
    if (k == warm) before = heap::requests();
    good = good && source.advance(trajectory.duration * k / samples) && source.evaluate();
  }
  const long after = heap::requests();
  REQUIRE(good);
  return after - before;
}

long requests(const std::string& file, const std::string& name, Detail detail) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS "/") + file);
  for (const Trajectory& trajectory : study.trajectories) {
    if (trajectory.name != name) continue;
    return study.mechanism.space == SpaceKind::planar
               ? requests<kinematics::Planar>(study.mechanism, trajectory, detail)
               : requests<kinematics::Spatial>(study.mechanism, trajectory, detail);
  }
  FAIL("no trajectory " << name);
  return -1;
}

}  // namespace

TEST_CASE("the counter sees what Eigen and the standard library take") {
  if (!heap::counted()) return;
  const long start = heap::requests();
  const auto matrix = std::make_unique<MatrixX>(MatrixX::Zero(30, 30));
  CHECK(heap::requests() - start >= 2);
  const long middle = heap::requests();
  std::vector<double> values(100, 1.0);
  CHECK(heap::requests() > middle);
  CHECK((*matrix)(3, 3) + values[7] == 1);
}

TEST_CASE("after the first samples the hot loop makes no request to the heap") {
  if (!heap::counted()) return;
  // every kind of mechanism whose constraints are independent; the others are solved by singular values, at leisure
  const std::string files[] = {"3rrr.yaml",
                               "planar-rrr.yaml",
                               "spatial-rrr.yaml",
                               "5r.yaml",
                               "rr.yaml",
                               "scara.yaml",
                               "spatial-slider-crank.yaml",
                               "rccc.yaml",
                               "spring-press.yaml",
                               "whitworth.yaml",
                               "geared-five-bar.yaml",
                               "watt-six-bar.yaml",
                               "scotch-yoke.yaml",
                               "slider-crank.yaml",
                               "stewart.yaml",
                               "delta.yaml"};
  for (const std::string& file : files) {
    CAPTURE(file);
    CHECK(requests(file, "cycloid", Detail::forces) == 0);
    CHECK(requests(file, "cycloid", Detail::all) == 0);
  }
}

TEST_CASE("following the centre of mass takes nothing from the heap either") {
  if (!heap::counted()) return;
  for (const std::string file : {"3rrr.yaml", "5r.yaml", "rr.yaml"})
    CHECK(requests(file, "bang-bang", Detail::all) == 0);
}

TEST_CASE(
    "between two choices of coordinates the integration of a plant without dry friction takes nothing from the heap") {
  if (!heap::counted()) return;
  for (const std::string file :
       {"3rrr.yaml", "spatial-rrr.yaml", "bricard.yaml", "spring-press.yaml", "stewart.yaml", "parallelogram.yaml"}) {
    CAPTURE(file);
    balance::Study study = balance::read_spec_file(std::string(BALANCE_CONFIGS "/") + file);
    study.mechanism.friction.clear();  // with it, sticking or slipping is decided anew wherever efforts change
    balance::Trajectory trajectory = study.trajectories.at(0);
    trajectory.samples = 21;
    const balance::RunResult result = balance::simulate(study.mechanism, trajectory);
    REQUIRE_MESSAGE(result.outcome.status == balance::MotionStatus::done, result.outcome.reason);
    const VectorX efforts = result.torque.row(10).transpose();
    balance::control::Plant plant(study.mechanism);
    REQUIRE(
        plant.start(0, result.joint_position.row(10).transpose(), result.joint_velocity.row(10).transpose()).status ==
        balance::MotionStatus::done);
    const double step = trajectory.duration / 1000;
    REQUIRE(plant.advance(step, efforts).status == balance::MotionStatus::done);
    long requests = 0, looked = 0;
    for (int k = 2; k <= 40; ++k) {
      const long before = heap::requests(), choices = plant.cost().choices;
      REQUIRE(plant.advance(step * k, efforts).status == balance::MotionStatus::done);
      if (plant.cost().choices != choices) continue;
      requests += heap::requests() - before;
      ++looked;
    }
    CHECK(looked > 20);
    CHECK(requests == 0);
  }
}
