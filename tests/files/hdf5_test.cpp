#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/sha256.hpp"
#include "hdf5_reader.hpp"
#include "sample.hpp"

#include <doctest/doctest.h>

using namespace balance;
using namespace balance::files;
using sample::Folder;
using sample::Reader;

namespace {

std::vector<double> flat(const Samples& samples) { return {samples.data(), samples.data() + samples.size()}; }

using Names = std::vector<std::string>;

/// Everything that one file must hold, whatever way it is stored.
void check_file(const Reader& file, const RunResult& r) {
  CHECK(file.numbers("time") == std::vector<double>(r.time.begin(), r.time.end()));
  CHECK(file.numbers("joint_position") == flat(r.joint_position));
  CHECK(file.numbers("joint_velocity") == flat(r.joint_velocity));
  CHECK(file.numbers("joint_acceleration") == flat(r.joint_acceleration));
  CHECK(file.numbers("torque") == flat(r.torque));
  CHECK(file.numbers("power") == flat(r.power));
  CHECK(file.numbers("com_position") == flat(r.com_position));
  CHECK(file.numbers("com_velocity") == flat(r.com_velocity));
  CHECK(file.numbers("com_acceleration") == flat(r.com_acceleration));
  CHECK(file.numbers("tool_position") == flat(r.tool_position));
  CHECK(file.numbers("tool_orientation") == flat(r.tool_orientation));
  CHECK(file.numbers("shaking_force") == flat(r.shaking_force));
  CHECK(file.numbers("shaking_moment") == flat(r.shaking_moment));
  CHECK(file.numbers("ground_force") == flat(r.ground_force));
  CHECK(file.numbers("ground_moment") == flat(r.ground_moment));
  CHECK(file.numbers("joint_force") == flat(r.joint_force));
  CHECK(file.numbers("joint_moment") == flat(r.joint_moment));
  CHECK(file.numbers("kinetic_energy") == flat(r.kinetic_energy));
  CHECK(file.numbers("potential_energy") == flat(r.potential_energy));
  CHECK(file.numbers("mobility") == flat(r.mobility));
  CHECK(file.numbers("newton_iterations") ==
        std::vector<double>(r.newton_iterations.begin(), r.newton_iterations.end()));
  CHECK(file.texts("coordinate") == r.coordinate_names);
  CHECK(file.texts("joint") == r.joint_names);
  CHECK(file.texts("actuator") == r.actuator_names);
  CHECK(file.numbers("metrics/energy") == std::vector<double>{12.5});
  CHECK(file.texts("metrics/quantity") == Names{"torque[A]", "shaking_force"});
  CHECK(file.texts("metrics/unit") == Names{"N m", "N"});
  CHECK(file.numbers("metrics/peak") == std::vector<double>{103.24281233, 869.7458});
  CHECK(file.numbers("metrics/peak_time") == std::vector<double>{0.03, 0.07505});
  CHECK(file.numbers("metrics/rms") == std::vector<double>{50.5, 500});
  CHECK(file.numbers("metrics/mean") == std::vector<double>{40.25, 400});
  CHECK(file.numbers("metrics/range") == std::vector<double>{200, 860});
}

WriteOptions with(Compression compression) {
  WriteOptions options;
  options.compression = compression;
  return options;
}

}  // namespace

TEST_CASE("what is read back is what was written, to the last bit, stored plainly or compressed") {
  for (const SpaceKind space : {SpaceKind::planar, SpaceKind::spatial}) {
    for (const Compression compression : {Compression::none, Compression::gzip}) {
      const Folder folder;
      const RunResult r = sample::result(space);
      write_result_hdf5(folder / "out.h5", r, sample::description(), with(compression));
      check_file(Reader(folder / "out.h5"), r);
      CHECK(folder.entries() == 1);
    }
  }
}

TEST_CASE("every dimension of every dataset has one scale that knows it") {
  const Folder folder;
  write_result_hdf5(folder / "planar", sample::result(SpaceKind::planar), sample::description());
  write_result_hdf5(folder / "spatial", sample::result(SpaceKind::spatial), sample::description());
  for (const std::string name : {"planar", "spatial"}) {
    const Reader file(folder / name);
    for (const std::string& dataset : file.datasets()) {
      for (const std::string& dimension : file.dimensions(dataset)) CHECK_MESSAGE(dimension != "-", dataset);
    }
  }
  const Reader planar(folder / "planar"), spatial(folder / "spatial");
  CHECK(planar.dimensions("joint_position") == Names{"time", "coordinate"});
  CHECK(planar.dimensions("torque") == Names{"time", "actuator"});
  CHECK(planar.dimensions("tool_orientation") == Names{"time"});
  CHECK(planar.dimensions("shaking_moment") == Names{"time"});
  CHECK(planar.dimensions("joint_force") == Names{"time", "joint", "axis"});
  CHECK(planar.dimensions("joint_moment") == Names{"time", "joint"});
  CHECK(planar.texts("axis") == Names{"x", "y"});
  CHECK(planar.dimensions("metrics/peak") == Names{"quantity"});
  CHECK(spatial.dimensions("tool_orientation") == Names{"time", "quaternion"});
  CHECK(spatial.texts("quaternion") == Names{"w", "x", "y", "z"});
  CHECK(spatial.dimensions("shaking_moment") == Names{"time", "axis"});
  CHECK(spatial.dimensions("joint_moment") == Names{"time", "joint", "axis"});
  CHECK(spatial.texts("axis") == Names{"x", "y", "z"});
}

TEST_CASE("every dataset has a unit and a long name") {
  const Folder folder;
  write_result_hdf5(folder / "out.h5", sample::result(SpaceKind::spatial), sample::description());
  const Reader file(folder / "out.h5");
  for (const std::string& dataset : file.datasets()) {
    CHECK_MESSAGE(!file.text_attribute(dataset, "units").empty(), dataset);
    CHECK_MESSAGE(!file.text_attribute(dataset, "long_name").empty(), dataset);
  }
  CHECK(file.text_attribute("shaking_moment", "units") == "N m");
  CHECK(file.text_attribute("mobility", "units") == "1");
  CHECK(file.number_attribute("shaking_moment", "about") == std::vector<double>{0.5, -0.25, 0});
  CHECK(file.number_attribute("ground_moment", "about") == std::vector<double>{0.5, -0.25, 0});
}

TEST_CASE("units that differ between columns are said column by column, and only then") {
  const Folder folder;
  RunResult r = sample::result(SpaceKind::planar);
  write_result_hdf5(folder / "mixed", r, sample::description());
  r.coordinate_units = {"rad", "rad"};
  r.actuator_units = {"N m", "N m"};
  write_result_hdf5(folder / "alike", r, sample::description());
  const Reader mixed(folder / "mixed"), alike(folder / "alike");
  CHECK(mixed.text_attribute("joint_velocity", "units") == "mixed");
  CHECK(mixed.texts("coordinate_unit") == Names{"rad", "m"});
  CHECK(mixed.texts("actuator_unit") == Names{"N m", "N"});
  CHECK(alike.text_attribute("joint_position", "units") == "rad");
  CHECK(alike.text_attribute("joint_acceleration", "units") == "rad/s^2");
  CHECK(alike.text_attribute("torque", "units") == "N m");
  CHECK_FALSE(alike.has("coordinate_unit"));
  CHECK_FALSE(alike.has("actuator_unit"));
}

TEST_CASE("the root says where the result comes from, however long the spec is") {
  const Folder folder;
  Provenance description = sample::description();
  description.spec_text =
      "name: long\n#" + std::string(200000, 'x');  // an HDF5 attribute in the usual place ends at 64 kB
  write_result_hdf5(folder / "out.h5", sample::result(SpaceKind::planar), description);
  const Reader file(folder / "out.h5");
  CHECK(file.text_attribute("/", "title") == description.title);
  CHECK(file.text_attribute("/", "Conventions") == "balance-1");
  CHECK(file.text_attribute("/", "balance_version") == "0.1.0");
  CHECK(file.text_attribute("/", "spec") == description.spec_text);
  CHECK(file.text_attribute("/", "spec_sha256") == sha256(description.spec_text));
  CHECK(file.text_attribute("/", "command_line") == "balance simulate a.yaml");
  CHECK(file.text_attribute("/", "trajectory") == "cycloid");
  CHECK(file.text_attribute("/", "law") == "cycloidal");
  CHECK(file.text_attribute("/", "drive") == "tool");
  CHECK(file.text_attribute("/", "formulation") == "tree");
}

TEST_CASE("quantities that a mechanism does not have are left out") {
  const Folder folder;
  RunResult r = sample::result(SpaceKind::planar);
  r.actuator_names.clear();
  r.actuator_units.clear();
  r.torque.resize(r.time.size(), 0);
  r.power.resize(r.time.size(), 0);
  r.tool_position.resize(0, 0);
  r.tool_orientation.resize(0, 0);
  r.metrics.clear();
  write_result_hdf5(folder / "out.h5", r, sample::description());
  const Reader file(folder / "out.h5");
  for (const std::string name :
       {"torque", "power", "actuator", "tool_position", "tool_orientation", "metrics/quantity"}) {
    CHECK_MESSAGE(!file.has(name), name);
  }
  CHECK(file.numbers("shaking_force") == flat(r.shaking_force));
}

TEST_CASE("the same result gives the same bytes") {
  for (const Compression compression : {Compression::none, Compression::gzip}) {
    const Folder folder;
    const RunResult r = sample::result(SpaceKind::spatial, 300);
    write_result_hdf5(folder / "a", r, sample::description(), with(compression));
    write_result_hdf5(folder / "b", r, sample::description(), with(compression));
    CHECK(sample::content(folder / "a") == sample::content(folder / "b"));
  }
}

TEST_CASE("plain samples take no more room than their numbers, and compressed ones less") {
  const Folder folder;
  const RunResult r = sample::result(SpaceKind::spatial, 5000);
  write_result_hdf5(folder / "plain", r, sample::description());
  write_result_hdf5(folder / "compressed", r, sample::description(), with(Compression::gzip));
  const hid_t file = H5Fopen((folder / "plain").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "joint_force", H5P_DEFAULT);
  CHECK(H5Dget_storage_size(dataset) == r.joint_force.size() * sizeof(double));
  CHECK(H5Dget_offset(dataset) != HADDR_UNDEF);  // contiguous
  H5Dclose(dataset);
  H5Fclose(file);
  CHECK(std::filesystem::file_size(folder / "compressed") < std::filesystem::file_size(folder / "plain"));
}
