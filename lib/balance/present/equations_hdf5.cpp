#include "balance/hdf5/file.hpp"
#include "balance/present/equations_view.hpp"
#include "balance/write/pending_file.hpp"
#include "balance/write/result_group.hpp"

#include <span>

namespace balance {

namespace {

using Dimension = Hdf5Writer::Dimension;
constexpr Hdf5Writer::Group equations_root_group{};

std::span<const double> numbers_of(const Samples& samples) {
  return {samples.data(), static_cast<std::size_t>(samples.size())};
}

void add_all(Hdf5Writer& file, const EquationsAlongRun& along, const std::vector<std::string>& actuators) {
  const std::span<const double> times(along.time.data(), static_cast<std::size_t>(along.time.size()));
  const Dimension time = file.add_dimension(equations_root_group, {"time", "time", "s", {}, {}}, times);
  const Dimension own = file.add_dimension(equations_root_group, {"coordinate", "independent coordinate", "1", {}, {}},
                                           along.independent);
  const Dimension rate = file.add_dimension(
      equations_root_group, {"rate", "rate of an independent coordinate", "1", {}, {}}, along.independent);
  const Dimension rate2 = file.add_dimension(
      equations_root_group, {"second_rate", "rate of an independent coordinate", "1", {}, {}}, along.independent);
  const Dimension tree =
      file.add_dimension(equations_root_group, {"tree", "coordinate of the tree", "1", {}, {}}, along.redundant);
  const auto add = [&](const char* name, const char* long_name, const std::vector<Dimension>& dimensions,
                       const Samples& samples) {
    if (samples.size() > 0)
      file.add_variable(equations_root_group, {name, long_name, "mixed", dimensions, {}}, numbers_of(samples));
  };
  add("position", "independent coordinates [rad or m]", {time, own}, along.position);
  add("M", "M': inertia in the independent coordinates, P0 eq. 62", {time, own, rate}, along.mass);
  add("D", "D'_krs: velocity terms, P0 eq. 63", {time, own, rate, rate2}, along.velocity);
  add("B", "B': viscous friction, P0 eq. 63", {time, own, rate}, along.viscous);
  add("z", "z': weight, springs and loads, P0 eq. 62", {time, own}, along.static_terms);
  add("C", "rates of the tree's coordinates per independent rate, P0 eq. 16", {time, tree, own}, along.transformation);
  if (!along.closures.empty()) {
    const Dimension closure =
        file.add_dimension(equations_root_group, {"closure", "joint that is closed", "1", {}, {}}, along.closures);
    add("A", "closures' Jacobian, P0 eq. 7", {time, closure, tree}, along.constraints);
  }
  if (along.parts.size() == 0) return;
  const std::vector<std::string> parts(effort_part_names.begin(), effort_part_names.end());
  const Dimension actuator =
      file.add_dimension(equations_root_group, {"actuator", "actuated coordinate", "1", {}, {}}, actuators);
  const Dimension part = file.add_dimension(equations_root_group, {"part", "part of the torque", "1", {}, {}}, parts);
  add("torque", "parts of the torques, which add up to them [N m or N]", {time, actuator, part}, along.parts);
}

}  // namespace

void write_equations(const std::string& path, const EquationsAlongRun& along, const std::vector<std::string>& actuators,
                     const Provenance& description, const WriteOptions& options) {
  AtomicFile pending(path, options.existing, options.temporary_tag);
  {
    const bool compress = options.compression == Compression::gzip;
    Hdf5Writer file(pending.descriptor(), path,
                    compress ? Hdf5Writer::Storage::compressed : Hdf5Writer::Storage::contiguous);
    write_source_attributes(file, description);
    add_all(file, along, actuators);
    file.close();
  }  // others have their turn with HDF5 while this one waits for the disk
  throw_if_cancelled(options);
  pending.commit(options.durability);
}

}  // namespace balance
