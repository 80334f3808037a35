#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/derivatives/state_gradient.hpp"
#include "balance/motion/vibration/forced_response.hpp"
#include "balance/motion/vibration/speed_sweep.hpp"
#include "balance/motion/vibration/vibration_modes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

using namespace balance;
using vibration::LinearMotion;

namespace {

double largest(const MatrixX& matrix) { return matrix.size() > 0 ? matrix.cwiseAbs().maxCoeff() : 0; }

/// A chain of bodies in general position, with springs and dampers in joints, of which the first may turn at constant speed.
std::string random_chain(std::mt19937& generator, bool is_spatial, bool is_turning, bool has_dampers) {
  std::uniform_real_distribution<double> between(-1, 1);
  const auto draw = [&](double middle, double width) { return std::to_string(middle + width * between(generator)); };
  const auto vector = [&](double width) {
    return "[" + draw(0, width) + ", " + draw(0, width) + (is_spatial ? ", " + draw(0, width) : "") + "]";
  };
  const auto direction = [&] { return is_spatial ? ", axis: [" + draw(0.4, 1) + ", " + draw(0.6, 1) + ", 1]" : ""; };
  const int bodies = 3;
  std::string text = std::string("space: ") + (is_spatial ? "spatial" : "planar") + "\nbodies:\n", joints = "joints:\n",
              springs = "springs:\n";
  for (int b = 0; b < bodies; ++b) {
    const std::string name = "b" + std::to_string(b),
                      before = b == 0 ? "ground.origin" : "b" + std::to_string(b - 1) + ".Q",
                      joint = "J" + std::to_string(b);
    const std::string inertia = is_spatial
                                    ? "[" + draw(0.05, 0.01) + ", " + draw(0.06, 0.01) + ", " + draw(0.07, 0.01) + "]"
                                    : draw(0.05, 0.02);
    text += "  " + name + ": {mass: " + draw(2, 1) + ", com: " + vector(0.2) + ", inertia: " + inertia +
            ", points: {P: " + vector(0.1) + ", Q: " + vector(0.4) + "}}\n";
    joints += "  " + joint + ": {type: " + (b == 1 ? "prismatic" : "revolute") + ", connects: [" + before + ", " +
              name + ".P]" + direction() + (b == 1 && !is_spatial ? ", axis: [" + draw(0, 1) + ", 1]" : "") + "}\n";
    springs += "  s" + std::to_string(b) + ": {joint: " + joint + ", stiffness: " + draw(60, 40) +
               ", rest: " + draw(0, 0.1) + (has_dampers ? ", damping: " + draw(0.4, 0.3) : "") + "}\n";
  }
  text += joints + springs;
  if (!is_turning) return text + "gravity: " + vector(2) + "\n";
  return text + "actuators: [J0]\ntrajectories:\n  run: {drive: joints, speed: {J0: " + draw(2, 1) +
         "}, from: {joints: {J0: 0}}, free: [J1, J2]}\n";
}

}  // namespace

TEST_CASE("the linear equations at an equilibrium have the exact derivatives of the equations of motion") {
  std::mt19937 generator(7);
  int compared = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const Study study = read_spec(random_chain(generator, trial % 2 == 1, false, true), "chain.yaml");
    const LinearMotion motion = vibration::linearise_motion(study.mechanism, nullptr);
    INFO("trial ", trial, ": ", motion.outcome.reason);
    if (motion.outcome.status != MotionStatus::done) continue;
    ++compared;
    Mechanism actuated = study.mechanism;
    actuated.actuators = motion.coordinates;
    dynamics::InverseOptions options;
    for (const CoordinateId coordinate : motion.coordinates)
      options.independent.push_back(actuated.coordinates[coordinate].name);
    InverseDynamics inverse(actuated, options);
    const auto n = static_cast<int>(motion.free_count);
    const VectorX rest = VectorX::Zero(n);
    std::vector<derivatives::DifferentiationVariable> variables;
    for (const auto kind : {StateVariable::Kind::q, StateVariable::Kind::dq, StateVariable::Kind::ddq})
      for (int k = 0; k < n; ++k) variables.push_back(StateVariable{kind, k});
    REQUIRE(inverse.at(motion.position, rest, rest));
    const auto exact = differentiate_state(inverse, motion.position, rest, rest, variables);
    REQUIRE(exact);
    MatrixX derivatives(n, 3 * n);
    for (int k = 0; k < 3 * n; ++k) derivatives.col(k) = exact.value.derivatives[static_cast<std::size_t>(k)].effort;
    // truncation (0.02)^8 and round-off of forces over a step of 0.02, both in units of the largest entry
    const auto& at = motion.coefficients;
    CHECK(largest(at.stiffness - derivatives.leftCols(n)) < 1e-11 * largest(at.stiffness));
    CHECK(largest(at.damping - derivatives.middleCols(n, n)) < 1e-11 * std::max(largest(at.damping), largest(at.mass)));
    CHECK(largest(at.mass - derivatives.rightCols(n)) < 1e-12 * largest(at.mass));
    CHECK(largest(exact.value.sample.effort) < 1e-8 * largest(at.stiffness));
  }
  CHECK(compared >= 10);
}

TEST_CASE("modes without dampers neither grow nor decay, with dampers all decay") {
  std::mt19937 generator(11);
  int compared = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const bool has_dampers = trial % 2 == 0;
    const Study study = read_spec(random_chain(generator, trial % 4 > 1, false, has_dampers), "chain.yaml");
    const vibration::VibrationModes modes = vibration::find_vibration_modes(study.mechanism, nullptr);
    if (modes.motion.outcome.status != MotionStatus::done || modes.stability() == vibration::Stability::unstable)
      continue;
    ++compared;
    double size = 0;
    for (const auto value : modes.eigenvalues) size = std::max(size, std::abs(value));
    for (const auto value : modes.eigenvalues) {
      // an eigenvalue's round-off with coefficients to 1e-12
      const bool is_right = has_dampers ? value.real() < 0 : std::abs(value.real()) < 1e-10 * size;
      CHECK_MESSAGE(is_right, value.real(), " of ", size);
    }
  }
  CHECK(compared >= 8);
}

TEST_CASE("in steady motion the gyroscopic terms do no work") {
  // without dampers the energy in the frame that turns with the first body is conserved (Jacobi's integral), so that eigenvalues
  // come as ±λ; gravity is left out because it does not turn
  std::mt19937 generator(13);
  int compared = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const Study study = read_spec(random_chain(generator, trial % 2 == 1, true, false), "chain.yaml");
    const vibration::VibrationModes modes =
        vibration::find_vibration_modes(study.mechanism, &study.trajectories.front());
    INFO("trial ", trial, ": ", modes.motion.outcome.reason);
    if (modes.motion.outcome.status != MotionStatus::done) continue;
    ++compared;
    CHECK(modes.motion.reference == vibration::Reference::steady);
    CHECK(modes.motion.variation == 0);
    double size = 0;
    for (const auto value : modes.eigenvalues) size = std::max(size, std::abs(value));
    for (const auto value : modes.eigenvalues) {
      double nearest = INFINITY;
      for (const auto other : modes.eigenvalues) nearest = std::min(nearest, std::abs(value + other));
      CHECK(nearest < 1e-9 * size);
    }
  }
  CHECK(compared >= 6);
}
