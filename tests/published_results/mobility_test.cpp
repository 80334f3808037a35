// Degrees of freedom, by rank and by counting.

#include "published.hpp"

#include "balance/synthesis/verification/mechanism_check.hpp"

#include <doctest/doctest.h>

using namespace published;

namespace {

struct Expected {
  const char* file;
  int freedoms, counted, redundant, loops;
};

}  // namespace

TEST_CASE("degrees of freedom by rank and by counting, and redundant constraints") {
  const Expected all[] = {{"bricard.yaml", 1, 0, 1, 1},
                          {"four-bar-in-space.yaml", 1, -2, 3, 1},
                          {"four-bar.yaml", 1, 1, 0, 1},
                          {"parallelogram.yaml", 1, 0, 1, 2},
                          {"stewart.yaml", 6, 6, 0, 5},
                          {"delta.yaml", 3, 3, 0, 5},
                          {"3rrr.yaml", 3, 3, 0, 2},
                          {"5r.yaml", 2, 2, 0, 1},
                          {"geared-five-bar.yaml", 1, 1, 0, 1},
                          {"watt-six-bar.yaml", 1, 1, 0, 2},
                          {"whitworth.yaml", 1, 1, 0, 2},
                          {"scotch-yoke.yaml", 1, 1, 0, 1},
                          {"rccc.yaml", 1, 1, 0, 1},
                          {"spatial-slider-crank.yaml", 1, 1, 0, 1},
                          {"scara.yaml", 3, 3, 0, 0},
                          {"double-pendulum.yaml", 2, 2, 0, 0}};
  for (const Expected& want : all) {
    CAPTURE(std::string(want.file));
    const balance::CheckReport report = balance::check_mechanism(load(want.file));
    CHECK(report.outcome.status == MotionStatus::done);
    CHECK(report.degrees_of_freedom == want.freedoms);
    CHECK(report.gruebler_degrees_of_freedom == want.counted);
    CHECK(static_cast<int>(report.redundant.size()) == want.redundant);
    CHECK(static_cast<int>(report.loops.size()) == want.loops);
    CHECK(report.tree_coordinates - report.closure_rank == want.freedoms);
    for (const std::string& line : report.redundant) CHECK(line.find(": ") != std::string::npos);
  }
}

TEST_CASE("four-bar in space: the force along the axes and the moments across them are redundant") {
  const balance::CheckReport report = balance::check_mechanism(load("four-bar-in-space.yaml"));
  REQUIRE(report.redundant.size() == 3);
  int forces = 0, moments = 0;
  for (const std::string& line : report.redundant) {
    forces += line.find("force along z") != std::string::npos;
    moments += line.find("moment about x") != std::string::npos || line.find("moment about y") != std::string::npos;
  }
  CHECK(forces == 1);
  CHECK(moments == 2);
}

TEST_CASE("over-constrained mechanisms say that their reactions are of least norm, others say nothing") {
  for (const std::string file : {"bricard.yaml", "four-bar-in-space.yaml", "parallelogram.yaml"}) {
    const RunResult r = run(file, "cycloid", 21);
    REQUIRE_MESSAGE(r.outcome.notes.size() == 1, file);
    CHECK(r.outcome.notes[0].find("over-constrained") != std::string::npos);
  }
  for (const std::string file : {"four-bar.yaml", "3rrr.yaml", "stewart.yaml", "delta.yaml"})
    CHECK(run(file, "cycloid", 21).outcome.notes.empty());
}

TEST_CASE("3RRR: eight ways to assemble it at the start, one of them picked; each line picks its own") {
  balance::Study study = load("3rrr.yaml");
  const balance::CheckReport report = balance::check_mechanism(study);
  CHECK(report.modes.size() == 8);  // each leg bends to either side
  int selected = 0;
  for (const balance::verification::AssemblyMode& mode : report.modes) {
    selected += mode.is_selected;
    balance::Study other = study;
    other.mechanism.assembly.clear();
    for (std::size_t c = 0; c < mode.coordinates.size(); ++c)
      other.mechanism.assembly.push_back({static_cast<int>(c), mode.coordinates[c]});
    const balance::CheckReport again = balance::check_mechanism(other);
    for (std::size_t c = 0; c < mode.coordinates.size(); ++c)
      CHECK(again.start[c] == doctest::Approx(mode.coordinates[c]).epsilon(1e-9));
  }
  CHECK(selected == 1);
}
