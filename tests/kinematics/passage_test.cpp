// What a motion passes on its way is said, with times and figures that do not depend on the samples.

#include "side_by_side.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace side_by_side;
using balance::MotionStatus;

/// The mobility and the time that the note of a near pass tells.
std::pair<double, double> near_pass(const std::vector<std::string>& notes) {
  const auto after = [](const std::string& note, const std::string& words) {
    const std::size_t at = note.find(words);
    REQUIRE(at != std::string::npos);
    return std::stod(note.substr(at + words.size()));
  };
  for (const std::string& note : notes)
    if (note.find("comes near a singularity of actuation") == 0)
      return {after(note, "drops to "), after(note, "at t = ")};
  REQUIRE_MESSAGE(false, "no note of a near pass");
  return {};
}

}  // namespace

TEST_CASE("a dead centre of one motor that another one helps over is passed and said, at any sampling (A1)") {
  for (const bool space : {false, true})
    for (const long samples : {2L, 5L, 100L, 1001L}) {
      const balance::Study study =
          balance::read_spec(spec(std::vector<Part>(2), space, "law: uniform", "AX"), "parts.yaml");
      const balance::MotionOutcome outcome = go(study, samples);
      CHECK_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
      for (const char* helper : {"A0", "A1"}) {
        const std::string note =
            std::string("passes a singularity of the actuators other than ") + helper + " at t = 0.5 s: ";
        const auto has = [&](const std::string& text) { return text.find(note) == 0; };
        CHECK(std::count_if(outcome.notes.begin(), outcome.notes.end(), has) == 1);
      }
      CHECK(std::count_if(outcome.notes.begin(), outcome.notes.end(),
                          [](const std::string& text) { return text.find("passes a") == 0; }) == 2);
    }
}

TEST_CASE("a motion that comes near a singularity says so, and how good its figures are there (A1)") {
  for (const bool space : {false, true}) {
    Part part;
    part.to = 1e-4;
    const auto notes = go(balance::read_spec(spec({part}, space), "near.yaml"), 101).notes;
    const auto near = [](const std::string& note) {
      return note.find("comes near a singularity") != std::string::npos;
    };
    CHECK(std::any_of(notes.begin(), notes.end(), near));
    part.to = 0.1;
    const auto far = go(balance::read_spec(spec({part}, space), "far.yaml"), 101).notes;
    CHECK(std::none_of(far.begin(), far.end(), near));
  }
}

TEST_CASE("the note of a near pass gives the least mobility there, whatever the samples (A1)") {
  // The crank goes past its dead centre at a small distance: there and back, nearest at 0.37 s.
  for (const bool space : {false, true})
    for (const double distance : {2e-4, 5e-5}) {
      Part part;
      part.from = 1, part.to = 0.7;
      const std::string way =
          "law: cycloidal, path: {waypoints: [{joints: {A0: " + exact(distance) + "}}], times: [0.37]}";
      const balance::Study study = balance::read_spec(spec({part}, space, way), "near.yaml");
      double first = 0;
      for (const long samples : {2L, 5L, 10L, 101L, 2000L}) {
        const auto [mobility, when] = near_pass(go(study, samples).notes);
        INFO(samples << " samples: " << mobility << " at " << when);
        CHECK(std::abs(when - 0.37) < 2e-4);  // the mechanism is nearly at rest there
        if (first == 0) first = mobility;
        CHECK(std::abs(mobility - first) <= 2e-3 * first);  // three digits are told
      }
      // as the cranks' joint drives nothing there, the smallest singular value of closures and actuator is proportional to the angle
      CHECK(first > 0.1 * distance);
      CHECK(first < 10 * distance);
    }
}

namespace {

struct Place {
  double x, y;
};

/// A bar on equal parallel cranks, the first of which is turned from one angle to another in one second.
std::string cranks(const std::vector<Place>& pivots, bool space, double from, double to, int copies = 1,
                   const std::string& law = "law: uniform") {
  const std::string inertia = space ? "[0.01, 0.01, 0.01]" : "0.01";
  std::string ground, bodies, joints, motors, at, start, end;
  const auto link = [&](const std::string& name, const std::string& points) {
    bodies += "  " + name + ": {mass: 1, com: " + point(0.01, 0.02, space) + ", inertia: " + inertia + ", points: {" +
              points + "}}\n";
  };
  for (int copy = 0; copy < copies; ++copy) {
    const std::string c = std::to_string(copy);
    std::string ends;
    for (std::size_t k = 0; k < pivots.size(); ++k) {
      const std::string n = c + std::to_string(k), separator = ground.empty() ? "" : ", ";
      ground += separator + "P" + n + ": " + point(pivots[k].x, pivots[k].y + copy, space);
      ends += (k > 0 ? ", E" : "E") + n + ": " + point(pivots[k].x, pivots[k].y, space);
      link("c" + n, "O: " + point(0, 0, space) + ", E: " + point(0.1, 0, space));
      joints += "  A" + n + ": {type: revolute, connects: [ground.P" + n + ", c" + n + ".O]}\n  B" + n +
                ": {type: revolute, connects: [c" + n + ".E, bar" + c + ".E" + n + "]}\n";
      at += separator + "A" + n + ": " + exact(from);
    }
    link("bar" + c, ends);
    at += ", B" + c + "0: " + exact(-from);
    motors += (copy > 0 ? ", A" : "A") + c + "0";
    start += (copy > 0 ? ", A" : "A") + c + "0: " + exact(from);
    end += (copy > 0 ? ", A" : "A") + c + "0: " + exact(to);
  }
  return std::string("name: cranks\nspace: ") + (space ? "spatial" : "planar") +
         "\ngravity: " + point(0, -9.81, space) + "\nground: {points: {" + ground + "}}\nbodies:\n" + bodies +
         "joints:\n" + joints + "actuators: [" + motors + "]\nassembly: {" + at +
         "}\nmotion: {duration: 1, samples: 2, from: {joints: {" + start + "}}, to: {joints: {" + end +
         "}}}\ntrajectories: {go: {" + law + ", drive: joints}}\n";
}

/// The times at which the note says that a pair of cranks passes its change point.
std::vector<double> change_points(const std::vector<std::string>& notes, const std::string& a, const std::string& b) {
  for (const std::string& note : notes) {
    if (note.find("passes a change point of the loop ") != 0) continue;
    const std::string loop = note.substr(0, note.find(" at t = "));
    if (loop.find("A" + a) == std::string::npos || loop.find("A" + b) == std::string::npos) continue;
    CHECK(note.find("keep the motion determinate") != std::string::npos);
    std::vector<double> times;
    const std::size_t begin = note.find(" at t = ") + 8;
    std::istringstream list(note.substr(begin, note.find(" s: ") - begin));
    for (std::string one; std::getline(list, one, ',');) times.push_back(std::stod(one));
    return times;
  }
  return {};
}

/// The line through two pivots is that of the cranks at these times.
std::vector<double> flat(const Place& a, const Place& b, double from, double to) {
  const double line = std::atan2(b.y - a.y, b.x - a.x), pi = std::numbers::pi;
  std::vector<double> times;
  for (int half = -10; half <= 10; ++half) {
    const double time = (line + half * pi - from) / (to - from);
    if (time >= -1e-12 && time <= 1 + 1e-12) times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  return times;
}

}  // namespace

TEST_CASE("parallel cranks out of line pass the change points of each pair, and say so at any sampling (A1)") {
  const std::vector<Place> three = {{0, 0}, {0.3, 0}, {0.15, 0.1}}, four = {{0, 0}, {0.3, 0}, {0.15, 0.1}, {0.1, -0.2}};
  for (const bool space : {false, true})
    for (const std::vector<Place>& pivots : {three, four})
      for (const int copies : {1, 2}) {
        if (copies == 2 && pivots.size() == 4) continue;
        const balance::Study study = balance::read_spec(cranks(pivots, space, 1, -6, copies), "cranks.yaml");
        for (const long samples : {2L, 10L, 101L, 1000L}) {
          const balance::MotionOutcome outcome = go(study, samples);
          INFO((space ? "space, " : "plane, ") << copies << " copies of " << pivots.size() << ", " << samples);
          REQUIRE_MESSAGE(outcome.status == MotionStatus::done, outcome.reason);
          for (int copy = 0; copy < copies; ++copy)
            for (std::size_t a = 0; a < pivots.size(); ++a)
              for (std::size_t b = a + 1; b < pivots.size(); ++b) {
                const std::string c = std::to_string(copy);
                const auto found = change_points(outcome.notes, c + std::to_string(a), c + std::to_string(b));
                const auto wanted = flat(pivots[a], pivots[b], 1, -6);
                REQUIRE(found.size() == wanted.size());
                for (std::size_t k = 0; k < found.size(); ++k) CHECK(std::abs(found[k] - wanted[k]) < 1e-5);
              }
        }
      }
}

TEST_CASE(
    "a change point at the start, at the end or only touched is said as well, and none where there is none (A1)") {
  const std::vector<Place> pivots = {{0, 0}, {0.3, 0}, {0.15, 0.1}};
  const auto times = [&](double from, double to, const std::string& law, long samples) {
    return change_points(go(balance::read_spec(cranks(pivots, false, from, to, 1, law), "cranks.yaml"), samples).notes,
                         "00", "01");
  };
  for (const long samples : {2L, 10L, 101L, 1000L}) {
    INFO(samples << " samples");
    CHECK(times(0, 0.5, "law: uniform", samples) == std::vector<double>{0});
    CHECK(times(-0.5, 0, "law: uniform", samples) == std::vector<double>{1});
    CHECK(times(0.1, 0.5, "law: uniform", samples).empty());
    const auto touched =
        times(0.3, 0.3, "law: cycloidal, path: {waypoints: [{joints: {A00: 0}}], times: [0.37]}", samples);
    REQUIRE(touched.size() == 1);
    CHECK(std::abs(touched[0] - 0.37) < 1e-2);  // at rest there
  }
}
