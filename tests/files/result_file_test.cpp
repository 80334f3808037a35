// What is written can be read back, and what cannot be read is said to be so.

#include "balance/interface/files/result_file.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace result_file_test {

namespace {

using namespace balance;
using namespace balance::files;
namespace fs = std::filesystem;

/// A folder that is gone at the end of the scope.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("balance-result-file-" + std::to_string(::getpid()));
  Folder() { fs::create_directory(path); }
  ~Folder() { fs::remove_all(path); }
  std::string operator()(const char* name) const { return (path / name).string(); }
};

RunResult run_of(const std::string& config) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config);
  Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 21;
  return simulate(study.mechanism, trajectory);
}

std::string message_of(const std::string& name) {
  try {
    read_result_file(name);
  } catch (const SystemError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a run that is read back is the run that was written") {
  const Folder folder;
  for (const char* config : {"3rrr.yaml", "slider-crank.yaml", "delta.yaml", "spatial-rrr.yaml"}) {
    CAPTURE(config);
    const balance::RunResult result = run_of(config);
    REQUIRE(result.outcome.status == balance::MotionStatus::done);
    Provenance description{.title = "a title", .version = "1.2", .spec_text = "name: x\n", .trajectory = "t"};
    description.law = "cycloidal";
    description.drive = "tool";
    write_result_hdf5(folder("run.h5"), result, description, {.existing = OverwritePolicy::replace});
    const StoredRun run = read_result_file(folder("run.h5"));
    CHECK(run.title == "a title");
    CHECK(run.spec_text == "name: x\n");
    CHECK(run.trajectory == "t");
    CHECK(run.drive == "tool");
    CHECK(run.result.coordinate_names == result.coordinate_names);
    CHECK(run.result.coordinate_units == result.coordinate_units);
    CHECK(run.result.actuator_units == result.actuator_units);
    CHECK(run.result.joint_names == result.joint_names);
    CHECK(run.result.time == result.time);
    CHECK(run.result.moment_reference == result.moment_reference);
    CHECK(run.result.newton_iterations == result.newton_iterations);
    CHECK(run.result.energy == result.energy);
    const auto before = list_all_quantities(result), after = list_all_quantities(run.result);
    for (std::size_t i = 0; i < before.size(); ++i) {
      CAPTURE(before[i].name);
      REQUIRE(before[i].samples->size() == after[i].samples->size());  // what has no columns has no rows in a file
      if (before[i].samples->size() > 0) CHECK(*before[i].samples == *after[i].samples);
    }
    REQUIRE(run.result.metrics.size() == result.metrics.size());
    for (std::size_t i = 0; i < result.metrics.size(); ++i) {
      CHECK(run.result.metrics[i].quantity == result.metrics[i].quantity);
      CHECK(run.result.metrics[i].unit == result.metrics[i].unit);
      CHECK(run.result.metrics[i].peak == result.metrics[i].peak);
      CHECK(run.result.metrics[i].range == result.metrics[i].range);
    }
  }
}

TEST_CASE("what is no result file is refused with its name") {
  const Folder folder;
  CHECK(message_of(folder("none.h5")) == folder("none.h5") + ": no such file");
  CHECK(message_of(folder.path.string()).find("is a folder") != std::string::npos);
  std::ofstream(folder("text.h5")) << "time,torque\n";
  CHECK(message_of(folder("text.h5")).find("expected an HDF5 file") != std::string::npos);
}

namespace {

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Cut off or with a bit turned, at random places. @return how many are refused
int refused_of(const std::string& whole, int trials, const std::string& path) {
  unsigned random = 1;
  int refused = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::string bytes = whole;
    random = random * 1664525U + 1013904223U;
    const std::size_t at = random % bytes.size();
    if (trial % 2 == 0)
      bytes.resize(at);
    else
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random >> 29)));
    std::ofstream(path, std::ios::binary) << bytes;
    refused += message_of(path).empty() ? 0 : 1;
  }
  return refused;
}

}  // namespace

TEST_CASE("a file of ours that was damaged anywhere is refused") {
  const Folder folder;
  write_result_hdf5(folder("run.h5"), run_of("four-bar.yaml"), {.title = "t"});
  const std::string whole = bytes_of(folder("run.h5"));
  CHECK(refused_of(whole, 100, folder("bad.h5")) == 100);
  std::string bytes = whole;
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(folder("bad.h5"), std::ios::binary) << bytes;
  CHECK(message_of(folder("bad.h5")) == folder("bad.h5") + ": is damaged: its contents do not match its checksum");
  std::ofstream(folder("bad.h5"), std::ios::binary) << whole.substr(0, whole.size() - 1000);
  CHECK(message_of(folder("bad.h5")) ==
        folder("bad.h5") + ": expected an intact HDF5 file, found one that is damaged or truncated");
}

TEST_CASE("a file that lost its checksum is read with care: refused or a run, and never anything worse") {
  const Folder folder;
  write_result_hdf5(folder("run.h5"), run_of("four-bar.yaml"), {.title = "t"});
  const std::string checked = bytes_of(folder("run.h5")), bare = checked.substr(0, checked.size() - 16);
  std::ofstream(folder("bare.h5"), std::ios::binary) << bare;
  CHECK(read_result_file(folder("bare.h5")).title == "t");
  CHECK(refused_of(bare, 60, folder("bad.h5")) >= 30);  // every one that is cut off at least
}

TEST_CASE("names of result files end as such") {
  CHECK(names_result_file("a/b.h5"));
  CHECK(names_result_file("design.h5:after/cycloid"));
  CHECK_FALSE(names_result_file("spec.yaml"));
}

TEST_CASE("the law of a run and its phase plane are read back as they were written") {
  const Folder folder;
  const balance::Study study = balance::read_spec_file(std::string(BALANCE_CONFIGS) + "/3rrr.yaml");
  balance::Trajectory trajectory = study.trajectories.at(0);
  trajectory.samples = 21;
  trajectory.law.kind = balance::MotionLawKind::min_peak;
  trajectory.min_peak_quantity = "shaking_force";
  trajectory.limits = {{"torque", 100}};
  const balance::RunResult result = balance::simulate(study.mechanism, trajectory);
  REQUIRE(result.outcome.status == balance::MotionStatus::done);
  write_result_hdf5(folder("law.h5"), result, {.title = "a title"}, {.existing = OverwritePolicy::replace});
  const balance::RunResult read = read_result_file(folder("law.h5")).result;
  REQUIRE(read.optimised_law.has_value());
  CHECK(read.optimised_law->duration == result.optimised_law->duration);
  CHECK(read.optimised_law->objective_value == result.optimised_law->objective_value);
  CHECK(read.optimised_law->unit == "N");
  CHECK(read.optimised_law->objective == "shaking_force");
  CHECK(read.optimised_law->switch_times == result.optimised_law->switch_times);
  REQUIRE(read.optimised_law->active_limits.size() == result.optimised_law->active_limits.size());
  for (std::size_t i = 0; i < read.optimised_law->active_limits.size(); ++i) {
    CHECK(read.optimised_law->active_limits[i].limit == result.optimised_law->active_limits[i].limit);
    CHECK(read.optimised_law->active_limits[i].begin == result.optimised_law->active_limits[i].begin);
    CHECK(read.optimised_law->active_limits[i].path_end == result.optimised_law->active_limits[i].path_end);
  }
  CHECK(read.phase_plane.time == result.phase_plane.time);
  CHECK(read.phase_plane.path_parameter == result.phase_plane.path_parameter);
  CHECK(read.phase_plane.path_rate == result.phase_plane.path_rate);
  CHECK(read.phase_plane.mvc_path_parameter == result.phase_plane.mvc_path_parameter);
  CHECK(read.phase_plane.mvc_path_rate == result.phase_plane.mvc_path_rate);
}

}  // namespace result_file_test
