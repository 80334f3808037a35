#include "balance/base/error.hpp"
#include "balance/write/result_hdf5.hpp"
#include "balance/write/sha256.hpp"
#include "sample.hpp"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <doctest/doctest.h>

#include <sys/resource.h>
#include <csignal>

using namespace balance;
using sample::Folder;

namespace {

/// Reads a file back with HDF5's own functions; wrong names fail the test.
class Reader {
 public:
  explicit Reader(const std::string& path) : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {
    REQUIRE(file_ >= 0);
  }
  ~Reader() { H5Fclose(file_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  bool has(const std::string& name) const { return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0; }

  std::vector<hsize_t> sizes(const std::string& name) const {
    const hid_t dataset = open(name), space = H5Dget_space(dataset);
    std::vector<hsize_t> result(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, result.data(), nullptr);
    H5Sclose(space);
    H5Dclose(dataset);
    return result;
  }

  std::vector<double> numbers(const std::string& name) const {
    hsize_t count = 1;
    for (const hsize_t size : sizes(name)) count *= size;
    std::vector<double> values(count);
    const hid_t dataset = open(name);
    REQUIRE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    H5Dclose(dataset);
    return values;
  }

  std::vector<std::string> texts(const std::string& name) const {
    std::vector<char*> pointers(sizes(name).at(0));
    const hid_t dataset = open(name), type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    REQUIRE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0);
    const std::vector<std::string> result(pointers.begin(), pointers.end());
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(dataset);
    return result;
  }

  std::string text_attribute(const std::string& object, const std::string& name) const {
    const hid_t attribute = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(attribute >= 0);
    const hid_t type = H5Aget_type(attribute);
    char* text = nullptr;
    REQUIRE(H5Aread(attribute, type, &text) >= 0);
    const std::string result = text;
    H5free_memory(text);
    H5Tclose(type);
    H5Aclose(attribute);
    return result;
  }

  std::vector<double> number_attribute(const std::string& object, const std::string& name) const {
    const hid_t attribute = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(attribute >= 0);
    std::vector<double> values(H5Aget_storage_size(attribute) / sizeof(double));
    REQUIRE(H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()) >= 0);
    H5Aclose(attribute);
    return values;
  }

  /// The names of the scales attached to each dimension, "-" for a dimension without exactly one.
  std::vector<std::string> dimensions(const std::string& name) const {
    const std::string group = name.substr(0, name.rfind('/') + 1);
    const hid_t dataset = open(name);
    std::vector<std::string> result;
    const bool scale = H5DSis_scale(dataset) > 0;
    if (scale) result.push_back(name.substr(group.size()));
    for (unsigned i = 0; !scale && i < sizes(name).size(); ++i) {
      std::string found = "-";
      H5DSiterate_scales(dataset, i, nullptr, note_scale, &found);
      result.push_back(H5DSget_num_scales(dataset, i) == 1 && belong_together(dataset, group + found, i) ? found : "-");
    }
    H5Dclose(dataset);
    return result;
  }

  std::vector<std::string> datasets() const {
    std::vector<std::string> names;
    H5Ovisit2(file_, H5_INDEX_CRT_ORDER, H5_ITER_INC, note_dataset, &names, H5O_INFO_BASIC);
    return names;
  }

  hid_t open(const std::string& name) const {
    const hid_t dataset = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    REQUIRE_MESSAGE(dataset >= 0, name);
    return dataset;
  }

 private:
  /// HDF5 agrees only if the dataset names the scale and the scale names the dataset.
  bool belong_together(hid_t dataset, const std::string& scale_name, unsigned dimension) const {
    const hid_t scale = open(scale_name);
    const bool attached = H5DSis_attached(dataset, scale, dimension) > 0;
    H5Dclose(scale);
    return attached;
  }
  static herr_t note_scale(hid_t, unsigned, hid_t scale, void* data) {
    char name[64] = "";
    H5DSget_scale_name(scale, name, sizeof name);
    *static_cast<std::string*>(data) = name;
    return 0;
  }
  static herr_t note_dataset(hid_t, const char* name, const H5O_info_t* info, void* data) {
    if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(data)->push_back(name);
    return 0;
  }

  hid_t file_;
};

std::vector<double> flat(const Samples& samples) { return {samples.data(), samples.data() + samples.size()}; }

using Names = std::vector<std::string>;

/// Everything that one file must hold, whatever way it is stored.
void check_file(const Reader& file, const Result& r) {
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
      const Result r = sample::result(space);
      write_result(folder / "out.h5", r, sample::description(), with(compression));
      check_file(Reader(folder / "out.h5"), r);
      CHECK(folder.entries() == 1);
    }
  }
}

TEST_CASE("every dimension of every dataset has one scale that knows it") {
  const Folder folder;
  write_result(folder / "planar", sample::result(SpaceKind::planar), sample::description());
  write_result(folder / "spatial", sample::result(SpaceKind::spatial), sample::description());
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
  write_result(folder / "out.h5", sample::result(SpaceKind::spatial), sample::description());
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
  Result r = sample::result(SpaceKind::planar);
  write_result(folder / "mixed", r, sample::description());
  r.coordinate_units = {"rad", "rad"};
  r.actuator_units = {"N m", "N m"};
  write_result(folder / "alike", r, sample::description());
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
  FileDescription description = sample::description();
  description.spec_text =
      "name: long\n#" + std::string(200000, 'x');  // an HDF5 attribute in the usual place ends at 64 kB
  write_result(folder / "out.h5", sample::result(SpaceKind::planar), description);
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
  Result r = sample::result(SpaceKind::planar);
  r.actuator_names.clear();
  r.actuator_units.clear();
  r.torque.resize(r.time.size(), 0);
  r.power.resize(r.time.size(), 0);
  r.tool_position.resize(0, 0);
  r.tool_orientation.resize(0, 0);
  r.metrics.clear();
  write_result(folder / "out.h5", r, sample::description());
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
    const Result r = sample::result(SpaceKind::spatial, 300);
    write_result(folder / "a", r, sample::description(), with(compression));
    write_result(folder / "b", r, sample::description(), with(compression));
    CHECK(sample::content(folder / "a") == sample::content(folder / "b"));
  }
}

TEST_CASE("plain samples take no more room than their numbers, and compressed ones less") {
  const Folder folder;
  const Result r = sample::result(SpaceKind::spatial, 5000);
  write_result(folder / "plain", r, sample::description());
  write_result(folder / "compressed", r, sample::description(), with(Compression::gzip));
  const hid_t file = H5Fopen((folder / "plain").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "joint_force", H5P_DEFAULT);
  CHECK(H5Dget_storage_size(dataset) == r.joint_force.size() * sizeof(double));
  CHECK(H5Dget_offset(dataset) != HADDR_UNDEF);  // contiguous
  H5Dclose(dataset);
  H5Fclose(file);
  CHECK(std::filesystem::file_size(folder / "compressed") < std::filesystem::file_size(folder / "plain"));
}

TEST_CASE("a result that is not done, or whose sizes contradict each other, is misuse and leaves no file") {
  const Folder folder;
  Result unsolved = sample::result(SpaceKind::planar);
  unsolved.outcome.status = MotionStatus::unsolved;
  CHECK_THROWS_AS(write_result(folder / "out.h5", unsolved, sample::description()), std::invalid_argument);
  Result short_rows = sample::result(SpaceKind::planar);
  short_rows.torque.resize(2, 2);
  CHECK_THROWS_AS(write_result(folder / "out.h5", short_rows, sample::description()), std::invalid_argument);
  CHECK(folder.entries() == 0);
}

TEST_CASE("a user who stops the writing finds the older file and nothing else") {
  const Folder folder;
  std::ofstream(folder / "out.h5") << "old";
  WriteOptions options;
  options.existing = Existing::replace;
  int questions = 0;
  options.cancelled = [&] { return ++questions == 5; };
  CHECK_THROWS_AS(write_result(folder / "out.h5", sample::result(SpaceKind::planar), sample::description(), options),
                  Cancelled);
  CHECK(questions == 5);
  CHECK(sample::content(folder / "out.h5") == "old");
  CHECK(folder.entries() == 1);
}

TEST_CASE("a file that outgrows its room at any byte is refused with the system's reason and leaves nothing") {
  const Folder folder;
  std::ofstream(folder / "out.h5") << "old";
  const Result r = sample::result(SpaceKind::spatial, 50);
  WriteOptions options;
  options.existing = Existing::replace;
  write_result(folder / "whole", r, sample::description());
  const auto whole = static_cast<rlim_t>(std::filesystem::file_size(folder / "whole"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (rlim_t room = 0; room < whole; room += whole / 40 + 1) {
    const rlimit limit{room, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::string message;
    try {
      write_result(folder / "out.h5", r, sample::description(), options);
    } catch (const SystemError& error) {
      message = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    CHECK(message == "cannot write " + (folder / "out.h5") + ": File too large");
    CHECK(sample::content(folder / "out.h5") == "old");
    CHECK(folder.entries() == 2);
  }
  std::signal(SIGXFSZ, handler);
  write_result(folder / "out.h5", r, sample::description(), options);  // the failures have not harmed what follows
  CHECK(sample::content(folder / "out.h5") == sample::content(folder / "whole"));
}
