#include "balance/interface/files/result_file.hpp"

#include "balance/foundation/base/error.hpp"
#include "sample.hpp"

#include <doctest/doctest.h>

#include <sstream>

using namespace balance;
using namespace balance::files;
using sample::Folder;

namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

std::vector<std::vector<std::string>> table(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream stream(sample::content(path));
  for (std::string line; std::getline(stream, line);) rows.push_back(split(line));
  return rows;
}

}  // namespace

TEST_CASE("a table has one row per sample and gives every number back") {
  const Folder folder;
  RunResult r = sample::result(SpaceKind::planar);
  r.torque(3, 1) = 1.0 / 3.0;
  r.torque(4, 1) = -1e-300;
  write_result_csv(folder / "out.csv", r);
  const auto rows = table(folder / "out.csv");
  REQUIRE(rows.size() == 6);
  const auto column = [&](const std::string& name) {
    for (std::size_t i = 0; i < rows[0].size(); ++i) {
      if (rows[0][i] == name) return i;
    }
    FAIL(name);
    return rows.size();
  };
  for (std::size_t k = 0; k < 5; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    CHECK(rows[k + 1].size() == rows[0].size());
    CHECK(std::stod(rows[k + 1][column("time [s]")]) == r.time[row]);
    CHECK(std::stod(rows[k + 1][column("S.position [m]")]) == r.joint_position(row, 1));
    CHECK(std::stod(rows[k + 1][column("A.acceleration [rad/s^2]")]) == r.joint_acceleration(row, 0));
    CHECK(std::stod(rows[k + 1][column("S.force [N]")]) == r.torque(row, 1));
    CHECK(std::stod(rows[k + 1][column("shaking_force.y [N]")]) == r.shaking_force(row, 1));
    CHECK(std::stod(rows[k + 1][column("weld.force.x [N]")]) == r.joint_force(row, 4));
    CHECK(std::stod(rows[k + 1][column("weld.moment [N m]")]) == r.joint_moment(row, 2));
    CHECK(std::stoi(rows[k + 1][column("newton_iterations [1]")]) == r.newton_iterations[row]);
  }
}

TEST_CASE("the columns of a spatial result name their axes") {
  const Folder folder;
  write_result_csv(folder / "out.csv", sample::result(SpaceKind::spatial));
  const std::string text = sample::content(folder / "out.csv");
  for (const std::string name : {"tool_orientation.w [1]", "shaking_moment.z [N m]", "weld.moment.z [N m]"}) {
    CHECK_MESSAGE(text.find(name) < text.find('\n'), name);
  }
}

TEST_CASE("a name with a comma stays one field") {
  const Folder folder;
  RunResult r = sample::result(SpaceKind::planar);
  r.joint_names[2] = "a \"b\", c";
  write_result_csv(folder / "out.csv", r);
  CHECK(sample::content(folder / "out.csv").find("\"a \"\"b\"\", c.moment [N m]\"") != std::string::npos);
}

TEST_CASE("a table is written whole or not at all") {
  const Folder folder;
  const RunResult r = sample::result(SpaceKind::planar);
  write_result_csv(folder / "out.csv", r);
  const std::string old = sample::content(folder / "out.csv");
  CHECK_THROWS_AS(write_result_csv(folder / "out.csv", r), SystemError);
  WriteOptions options;
  options.existing = OverwritePolicy::replace;
  options.is_cancelled = [] { return true; };
  CHECK_THROWS_AS(write_result_csv(folder / "out.csv", sample::result(SpaceKind::spatial), options), Cancelled);
  CHECK(sample::content(folder / "out.csv") == old);
  CHECK(folder.entries() == 1);
}
