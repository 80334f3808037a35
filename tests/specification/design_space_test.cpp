#include "numbers_of.hpp"
#include "specs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

using namespace balance;
using specs::numbers_of;

namespace {

DesignSpace space_of(const std::string& text, const ReadOptions& options = {}) {
  return read_design_space(text, "s.yaml", options);
}

VectorX start_of(const Study& study) {
  VectorX x(static_cast<Eigen::Index>(study.free_numbers.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = study.free_numbers[static_cast<std::size_t>(i)].start;
  return x;
}

/// The planar spec with free numbers in every kind of place that a number may have.
std::string free_everywhere() {
  std::string text = specs::planar;
  const std::pair<const char*, const char*> places[] = {
      {"gravity: [0, -9.81]", "gravity: [0, {free: [-20, 0]}]"},
      {"m: 2", "m: {free: [1, 4]}"},
      {"O: [0, 0]", "O: [{free: [-1, 1]}, 0]"},
      {"inertia: 0.01,", "inertia: {free: [0.01, 0.02]},"},
      {"mass: 0.2, com: [0, 0]", "mass: 0.2, com: [0, {free: [-1, 2]}]"},
      {"inertia: 0.001}\njoints", "inertia: {about: origin, value: {free: [1, 9], start: 2}}}\njoints"},
      {"[ground.O, upper.A]}", "[ground.O, upper.A], angle: {free: [0, 1]}}"},
      {"wheel.origin]}", "wheel.origin], axis: [1, {free: [-1, 0.5]}]}"},
      {"ratio: -1}", "ratio: {free: [-2, 0]}, offset: {free: [0, 1]}}"},
      {"assembly: {J1: 0.1", "assembly: {J1: {free: [0, 0.4]}"},
      {"motion: {duration: 1,", "motion: {duration: {free: [1, 3]}, about: [0, {free: [0, 8]}],"},
      {"ramp: 0.2", "ramp: {free: [0.1, 0.5]}"},
      {"to: {joints: {J1: 1, J2: 2}}", "to: {joints: {J1: {free: [0, 6]}, J2: 2}}"},
      {"times: [0.4]", "times: [{free: [0.2, 0.6]}]"},
      {"at: [-0.1, 0]", "at: [{free: [-0.3, 0]}, 0]"},
      {"ratio: -2, mass: 0.3", "ratio: {free: [-20, 0]}, mass: {free: [0, 1]}"},
      {"force: [5, 0]", "force: [{free: [0, 7]}, 0]"},
      {"[1, 3, 4]]", "[1, 3, {free: [0, 5]}]]"},
      {"stiffness: 100, free_length: 0.1", "stiffness: {free: [0, 500]}, free_length: {free: [0, 0.5]}"},
      {"coulomb: 0.2", "coulomb: {free: [0, 3]}"}};
  for (const auto& [find, replace] : places) text = specs::with(text, find, replace);
  return text;
}

}  // namespace

TEST_CASE("a study at the start values is the study that was read") {
  for (const std::string& text : {specs::planar, free_everywhere()}) {
    const DesignSpace space = space_of(text);
    const Study again = space.study_at(start_of(space.start));
    CHECK(numbers_of(again.mechanism) == numbers_of(space.start.mechanism));
    CHECK(numbers_of(again.trajectories) == numbers_of(space.start.trajectories));
    CHECK(again.design.goals == space.start.design.goals);
    CHECK(again.spec_text == text);
    CHECK(again.mechanism.name == space.start.mechanism.name);
    CHECK(again.free_numbers.size() == space.start.free_numbers.size());
  }
}

TEST_CASE("read_spec reads the start of the design space") {
  const Study read = specs::read(free_everywhere());
  const Study start = space_of(free_everywhere()).start;
  CHECK(numbers_of(read.mechanism) == numbers_of(start.mechanism));
  CHECK(read.free_numbers.size() == start.free_numbers.size());
}

TEST_CASE("a study at other values is what a spec with these numbers in their places says") {
  const std::string text = free_everywhere();
  const DesignSpace space = space_of(text);
  const auto& free = space.start.free_numbers;
  REQUIRE(free.size() == 25);
  VectorX x = start_of(space.start);
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] += 0.2 * (free[static_cast<std::size_t>(i)].upper - x[i]);
  std::string replaced = text;
  for (std::size_t i = free.size(); i-- > 0;)
    replaced.replace(free[i].begin, free[i].end - free[i].begin, fmt::format("{}", x[static_cast<Eigen::Index>(i)]));
  const Study expected = specs::read(replaced), found = space.study_at(x);
  CHECK(expected.free_numbers.empty());
  CHECK(numbers_of(found.mechanism) == numbers_of(expected.mechanism));
  CHECK(numbers_of(found.trajectories) == numbers_of(expected.trajectories));
  CHECK(numbers_of(found.mechanism) != numbers_of(space.start.mechanism));
}

TEST_CASE("every free number changes the study") {
  const DesignSpace space = space_of(free_everywhere());
  const VectorX start = start_of(space.start);
  for (Eigen::Index i = 0; i < start.size(); ++i) {
    const FreeNumber& number = space.start.free_numbers[static_cast<std::size_t>(i)];
    VectorX x = start;
    x[i] = number.start + 0.01 * (number.upper - number.start);
    const Study study = space.study_at(x);
    INFO(number.key_path);
    const bool moves = numbers_of(study.trajectories) != numbers_of(space.start.trajectories);
    CHECK((numbers_of(study.mechanism) != numbers_of(space.start.mechanism) || moves));
    CHECK(moves == (number.key_path.rfind("motion", 0) == 0 || number.key_path.rfind("trajectories", 0) == 0));
  }
}

TEST_CASE("free numbers are listed in the document's order, whatever depends on what") {
  const std::string text = R"(
space: planar
bodies: {a: {mass: {free: [1, 2]}, com: [p, 0], inertia: 1}}
parameters: {p: {free: ["q / 2", 3]}, q: {free: [0, 1], start: 0.5}}
joints: {J: {type: revolute, connects: [ground.origin, a.origin]}}
)";
  const auto free = specs::read(text).free_numbers;
  REQUIRE(free.size() == 3);
  CHECK(free[0].key_path == "bodies.a.mass");
  CHECK(free[1].key_path == "parameters.p");
  CHECK(free[1].lower == 0.25);
  CHECK(free[2].key_path == "parameters.q");
}

TEST_CASE("expressions follow the parameters that are free") {
  const std::string text =
      specs::with(specs::planar, "{l: 0.5, m: 2, k: \"l / 2\"}", "{k: \"l / 2\", l: {free: [0.4, 0.6]}, m: 2}");
  const DesignSpace space = space_of(text);
  const Study study = space.study_at((VectorX(2) << 0.44, 1).finished());
  CHECK(study.mechanism.bodies[1].com.x() == 0.22);
  CHECK(study.mechanism.bodies[1].points[1].position.x() == 0.44);
  CHECK(study.mechanism.joints[1].point_first.x() == 0.44);
  CHECK(study.mechanism.tool->position.x() == 0.44);
  CHECK(study.mechanism.springs[0].point_second.x() == 0.44);
}

TEST_CASE("--set holds in the whole design space") {
  const std::string text = specs::with(specs::planar, "l: 0.5", "l: {free: [0.4, 0.6]}");
  const DesignSpace tied = space_of(text, {.set = {{"m", "4 * l"}}});
  CHECK(tied.study_at((VectorX(2) << 0.41, 1).finished()).mechanism.bodies[1].mass == 4 * 0.41);
  const DesignSpace fixed = space_of(text, {.set = {{"l", "0.7"}}});
  REQUIRE(fixed.start.free_numbers.size() == 1);
  CHECK(fixed.study_at(VectorX::Constant(1, 3)).mechanism.bodies[1].points[1].position.x() == 0.7);
}

TEST_CASE("a trajectory follows a free number that --set brings into it") {
  const std::string text = specs::with(specs::with(specs::planar, "m: 2", "m: {free: [1, 3]}, T: 1"),
                                       "motion: {duration: 1", "motion: {duration: T");
  const DesignSpace space = space_of(text, {.set = {{"T", "m / 2"}}});
  CHECK(space.study_at((VectorX(2) << 3, 1).finished()).trajectories[0].duration == 1.5);
}

TEST_CASE("nothing of a study in the design space is judged for physical sense") {
  const std::string text = specs::with(
      specs::with(specs::with(specs::planar, "mass: 1, com: [k, 0], inertia: 0.01",
                              "mass: {free: [0, 3]}, com: [k, {free: [-9, 9]}], inertia: {about: origin, value: {free: "
                              "[0, 30], start: 29}}"),
                  "wheel.origin]}", "wheel.origin], axis: [{free: [0, 1]}, 0]}"),
      "m: 2", "m: {free: [-2, 6]}");
  const DesignSpace space = space_of(text);
  const VectorX x = (VectorX(6) << -2, 0, 9, 0, 0, 0).finished();
  REQUIRE(space.start.free_numbers.size() == x.size());
  const Study study = space.study_at(x);
  CHECK(study.mechanism.bodies[1].mass == -2);
  CHECK(study.mechanism.bodies[2].mass == 0);
  CHECK(study.mechanism.bodies[2].com.y() == 9);
  CHECK(study.mechanism.bodies[2].inertia(2, 2) == 0);
  CHECK(study.mechanism.joints[2].axis == Vector3::UnitX());
}

TEST_CASE("the start of a design space makes sense") {
  const auto complaint = [](const char* find, const char* replace) {
    return specs::complaint(specs::with(specs::planar, find, replace));
  };
  CHECK(complaint("mass: {free: [0, 10]}", "mass: {free: [0, 10], start: 0}").empty());
  CHECK(complaint("mass: 1, com", "mass: {free: [0, 10]}, com").empty());
  CHECK(complaint("mass: 1, com", "mass: {free: [0, 10], start: 0}, com").find("must be positive") !=
        std::string::npos);
  CHECK(complaint("inertia: 0.01,", "inertia: {free: [0, 0.1]},").empty());
  CHECK(complaint("inertia: 0.01,", "inertia: {free: [-1, 0.1]},").find("no body can have this inertia") !=
        std::string::npos);
}

TEST_CASE("a free parameter may have the name of anything else") {
  for (const char* name : {"J1", "J2", "upper", "lower", "wheel", "cw", "cargo", "disc", "s", "H", "cut", "line"}) {
    const std::string parameters = std::string("parameters: {") + name + ": {free: [0, 1]}, ";
    const DesignSpace space = space_of(specs::with(specs::planar, "parameters: {", parameters));
    CHECK(numbers_of(space.study_at(start_of(space.start)).mechanism) == numbers_of(space.start.mechanism));
    CHECK(numbers_of(space.study_at(start_of(space.start)).trajectories) == numbers_of(space.start.trajectories));
  }
}

TEST_CASE("a space of another dimension is refused") {
  const DesignSpace space = space_of(specs::planar);
  CHECK_THROWS_AS(space.study_at(VectorX(0)), std::invalid_argument);
  CHECK_THROWS_AS(space.study_at(VectorX::Zero(2)), std::invalid_argument);
}

TEST_CASE("a design space may be asked in any order, and outlives what it was read from") {
  DesignSpace copy;
  {
    const DesignSpace space = space_of(specs::planar);
    copy = space;
  }
  const double first = copy.study_at(VectorX::Constant(1, 3)).mechanism.attachments[0].mass;
  const double second = copy.study_at(VectorX::Constant(1, 4)).mechanism.attachments[0].mass;
  CHECK(first == 3);
  CHECK(second == 4);
  CHECK(copy.study_at(VectorX::Constant(1, 3)).mechanism.attachments[0].mass == 3);
  CHECK(copy.start.mechanism.attachments[0].mass == 0);
}

TEST_CASE("table files are read once") {
  const auto folder = std::filesystem::temp_directory_path() / ("balance-design-space-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto file = folder / "forces.csv";
  std::ofstream(file) << "time, fx\n0, 1\n1, 2\n";
  const std::string text = specs::with(specs::planar, "tide: {on: lower, table: [[0, 1, 2], [1, 3, 4]]}",
                                       "tide: {on: lower, file: forces.csv}");
  const DesignSpace space = read_design_space(text, (folder / "s.yaml").string());
  std::filesystem::remove_all(folder);
  const Study study = space.study_at(VectorX::Constant(1, 3));
  CHECK(study.mechanism.loads[1].force[1].x() == 2);
}
