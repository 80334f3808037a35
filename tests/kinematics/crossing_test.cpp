// A singular configuration between two samples is found whatever the samples are, however many parts pass theirs at once, in the
// plane and in space. The times come from closed forms: where crank and rod lie in one line the slider stands still.

#include "side_by_side.hpp"

#include "balance/synthesis/verification/simulate_natural.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

namespace {

using namespace side_by_side;
using balance::MotionStatus;

double unit(std::uint64_t& seed) {
  seed = seed * 6364136223846793005u + 1442695040888963407u;
  return static_cast<double>(seed >> 11) * 0x1.0p-53;
}

/// A part in which the crank can turn all round, passing its dead centre at a part of the duration.
Part random_part(std::uint64_t& seed, double when) {
  Part part;
  part.r = 0.05 + 0.1 * unit(seed);
  part.l = part.r + 0.1 + 0.3 * unit(seed);
  if (unit(seed) < 0.5) {
    part.offset = 0.05 * (2 * unit(seed) - 1);
  } else {  // the crank is the shortest, the base the longest: it turns all round
    part.rocker = part.l * (0.9 + 0.2 * unit(seed));
    part.base = part.l + part.rocker - part.r - 0.02 - 0.02 * unit(seed);
    part.base = std::max(part.base, std::max(part.l, part.rocker));
  }
  const double sweep = 0.3 + 1.0 * unit(seed);
  part.from = part.dead() + sweep * when;
  part.to = part.dead() - sweep * (1 - when);
  return part;
}

void check_refused(const balance::Study& study, double when, double tolerance = 1e-6,
                   MotionStatus status = MotionStatus::actuation_singularity) {
  for (const long samples : {2L, 3L, 5L, 10L, 64L, 101L, 1000L}) {
    const balance::MotionOutcome outcome = go(study, samples);
    INFO(samples << " samples: " << outcome.reason);
    CHECK(outcome.status == status);
    CHECK(std::abs(outcome.time - when) < tolerance);
  }
}

}  // namespace

TEST_CASE(
    "one, two and three simultaneous dead centres are refused at their time, in the plane and in space (A1, A2)") {
  for (const bool space : {false, true})
    for (const std::size_t copies : {1u, 2u, 3u}) {
      INFO((space ? "space, " : "plane, ") << copies << " copies");
      check_refused(balance::read_spec(spec(std::vector<Part>(copies), space), "parts.yaml"), 0.5);
    }
}

TEST_CASE("random slider-cranks and four-bars are refused at their common dead centre (A1, A2)") {
  std::uint64_t seed = 20240607;
  for (int k = 0; k < 24; ++k) {
    const double when = 0.1 + 0.8 * unit(seed);
    std::vector<Part> parts;
    for (int copy = 0; copy <= k % 3; ++copy) parts.push_back(random_part(seed, when));
    const bool space = k % 2 == 1;
    INFO("case " << k << "\n" << spec(parts, space));
    check_refused(balance::read_spec(spec(parts, space), "parts.yaml"), when);
  }
}

TEST_CASE("two dead centres shortly after each other are refused at the first (A1)") {
  for (const bool space : {false, true})
    for (const double apart : {1e-2, 1e-4, 1e-6, 1e-9}) {
      std::vector<Part> parts(2);
      parts[0].from = 1, parts[0].to = -1;
      parts[1].from = 1 + apart, parts[1].to = -1 + apart;
      check_refused(balance::read_spec(spec(parts, space), "parts.yaml"), 0.5);
    }
}

TEST_CASE(
    "of two change points shortly after each other the first is reported, whichever comes to its own faster (A1)") {
  for (const bool space : {false, true})
    for (const double faster : {0.3, 1.07, 3.0}) {
      std::vector<Part> parts(2);
      for (Part& part : parts) part.rocker = part.r, part.base = part.l;
      parts[0].from = 0.25 * faster, parts[0].to = -0.75 * faster;
      parts[1].from = 0.251 * 0.3, parts[1].to = -0.749 * 0.3;
      check_refused(balance::read_spec(spec(parts, space, "law: uniform", "A"), "parts.yaml"), 0.25, 2e-5,
                    MotionStatus::constraint_singularity);
    }
}

TEST_CASE("closures that lose rank at a dead centre of another part are called so (A1, A2)") {
  for (const bool space : {false, true})
    for (const bool first : {false, true}) {
      std::vector<Part> parts(2);
      Part& flat = parts[first ? 0 : 1];
      flat.rocker = flat.r, flat.base = flat.l;
      std::string text = spec(parts, space);
      const std::string motors = "actuators: [X0, X1]";
      text.replace(text.find(motors), motors.size(), first ? "actuators: [A0, X1]" : "actuators: [X0, A1]");
      check_refused(balance::read_spec(text, "parts.yaml"), 0.5, 2e-5, MotionStatus::constraint_singularity);
    }
}

TEST_CASE("a dead centre at the start, at the end, and a touch of it are refused whatever the samples (A1)") {
  for (const bool space : {false, true}) {
    Part part;
    part.from = 0, part.to = 1;
    check_refused(balance::read_spec(spec({part}, space), "start.yaml"), 0);
    part.from = 1, part.to = 0;
    check_refused(balance::read_spec(spec({part}, space), "end.yaml"), 1);
    // there and back, so that the sign of no determinant changes: at a third of the way, on no sample of most grids
    part.from = 1, part.to = 0.7;
    const std::string touch = "law: cycloidal, path: {waypoints: [{joints: {A0: 0}}], times: [0.37]}";
    const std::string text = spec({part}, space, touch);
    check_refused(balance::read_spec(text, "touch.yaml"), 0.37, 0.02);  // the crank is nearly at rest there
  }
}

TEST_CASE("what stays away from its dead centres is followed, and coarse samples are those of a fine grid") {
  for (const bool space : {false, true}) {
    std::vector<Part> parts(2);
    parts[0].from = 1, parts[0].to = 0.02;
    parts[1].from = -2.5, parts[1].to = -0.02;
    const balance::Study study = balance::read_spec(spec(parts, space), "parts.yaml");
    balance::Trajectory fine = study.trajectories.front(), coarse = fine;
    fine.samples = 1001, coarse.samples = 2;
    const balance::RunResult a = balance::simulate(study.mechanism, fine),
                             b = balance::simulate(study.mechanism, coarse);
    REQUIRE(a.outcome.status == MotionStatus::done);
    REQUIRE(b.outcome.status == MotionStatus::done);
    CHECK((a.torque.row(1000) - b.torque.row(1)).norm() < 1e-8 * a.torque.norm());
  }
}

TEST_CASE("parallelograms that become flat at once gain a freedom, which is refused at its time (A1, A2)") {
  for (const bool space : {false, true})
    for (const std::size_t copies : {1u, 2u, 3u})
      for (const double to : {-1.0, -3.0, 1.0 - 4 * std::numbers::pi}) {
        std::vector<Part> parts(copies);
        for (Part& part : parts) part.rocker = part.r, part.base = part.l, part.to = to;
        INFO((space ? "space, " : "plane, ") << copies << " copies, to " << to);
        const double flat = 1 / (1 - to);
        check_refused(balance::read_spec(spec(parts, space, "law: uniform", "A"), "parts.yaml"), flat, 1e-6,
                      MotionStatus::constraint_singularity);
      }
}

TEST_CASE("natural coordinates refuse the same, at the same time (A1)") {
  for (const bool flat : {false, true})
    for (const std::size_t copies : {1u, 2u, 3u}) {
      std::vector<Part> parts(copies);
      for (Part& part : parts)
        if (flat) part.rocker = part.r, part.base = part.l;
      const balance::Study study =
          balance::read_spec(spec(parts, false, "law: uniform", flat ? "A" : "X"), "parts.yaml");
      for (const long samples : {2L, 64L, 101L}) {
        balance::Trajectory trajectory = study.trajectories.front();
        trajectory.samples = samples;
        const balance::MotionOutcome outcome =
            balance::verification::simulate_natural(study.mechanism, trajectory).outcome;
        INFO(copies << " copies, " << samples << " samples: " << outcome.reason);
        CHECK(outcome.status == (flat ? MotionStatus::constraint_singularity : MotionStatus::actuation_singularity));
        CHECK(std::abs(outcome.time - 0.5) < 1e-5);
      }
    }
}
