#include "balance/read/hdf5_source.hpp"

#include "balance/base/hdf5_turn.hpp"
#include "balance/base/seal.hpp"
#include "balance/read/nearest.hpp"
#include "balance/read/rehearsal.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace balance::read {

namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

/// An identifier that is closed at the end of its scope.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  hid_t id() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Keeps the library from printing while it is in scope.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

const char* name_in_file(const std::string& path) { return path.empty() ? "/" : path.c_str(); }

[[noreturn]] void unreadable(const std::string& path) {
  throw Hdf5Error(fmt::format("{}: cannot be read", in_quotes(path)));
}

/// Sizes of a space. @throws Hdf5Error if there are too many dimensions or values
std::vector<std::size_t> sizes_of(hid_t space, const std::string& path, std::size_t most_sizes,
                                  std::size_t most_values) {
  const int count = H5Sget_simple_extent_ndims(space);
  if (count < 0) unreadable(path);
  std::vector<hsize_t> extent(static_cast<std::size_t>(count));
  H5Sget_simple_extent_dims(space, extent.data(), nullptr);
  if (extent.size() > most_sizes) {
    const std::string expected = most_sizes == 1 ? "one dimension" : fmt::format("at most {} dimensions", most_sizes);
    throw Hdf5Error(fmt::format("{}: expected {}, found {}", in_quotes(path), expected, count));
  }
  std::size_t total = 1;
  for (const hsize_t size : extent) {
    if (size > most_values || total * size > most_values)
      throw Hdf5Error(
          fmt::format("{}: expected at most {} values, found {}", in_quotes(path), most_values, total * size));
    total *= size;
  }
  return {extent.begin(), extent.end()};
}

std::size_t product(const std::vector<std::size_t>& sizes) {
  std::size_t total = 1;
  for (const std::size_t size : sizes) total *= size;
  return total;
}

bool is_number(hid_t type) { return H5Tget_class(type) == H5T_FLOAT || H5Tget_class(type) == H5T_INTEGER; }

bool is_text(hid_t type) { return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) > 0; }

/// Copies texts that the library has made, and gives them back.
std::vector<std::string> take(std::vector<char*>& pointers, hid_t type, hid_t space) {
  std::vector<std::string> texts;
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, static_cast<void*>(pointers.data()));
  return texts;
}

herr_t note_group(hid_t owner, const char* name, const H5L_info_t*, void* data) {
  const Silence silence;
  const Handle object(H5Oopen(owner, name, H5P_DEFAULT), H5Oclose);
  if (object.valid() && H5Iget_type(object.id()) == H5I_GROUP)
    static_cast<std::vector<std::string>*>(data)->emplace_back(name);
  return 0;
}

/// Whether it begins as HDF5 files do.
bool looks_right(const std::string& path) {
  char begin[8] = {};
  std::ifstream(path, std::ios::binary).read(begin, sizeof begin);
  return std::string(begin, sizeof begin) == "\x89HDF\r\n\x1a\n";
}

/// HDF5's packing makes nothing a thousand times smaller; more values than that are no honest file's.
std::size_t most_values_in(std::size_t bytes) { return std::max<std::size_t>(1000 * bytes, 1000); }

}  // namespace

Hdf5Source::Hdf5Source(const std::string& file) {
  const Silence silence;
  file_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0 && looks_right(file))
    throw Hdf5Error("expected a whole HDF5 file, found one that is damaged or cut off");
  if (file_ < 0) throw Hdf5Error("expected an HDF5 file, found one that cannot be opened as such");
  hsize_t bytes = 0;
  H5Fget_filesize(file_, &bytes);
  bytes_ = bytes;
}

Hdf5Source::~Hdf5Source() {
  const Silence silence;
  H5Fclose(file_);
}

bool Hdf5Source::has(const std::string& path) const {
  const Silence silence;
  std::istringstream parts(path);
  std::string part, here;
  while (std::getline(parts, part, '/')) {
    here += here.empty() ? part : "/" + part;
    if (part.empty() || H5Lexists(file_, here.c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return true;
}

Hdf5Source::Numbers Hdf5Source::numbers(const std::string& path, std::size_t most_sizes,
                                        std::size_t most_values) const {
  const Silence silence;
  const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.valid())
    throw Hdf5Error(fmt::format("expected a dataset {}, found something else of that name", in_quotes(path)));
  const Handle space(H5Dget_space(dataset.id()), H5Sclose), type(H5Dget_type(dataset.id()), H5Tclose);
  if (!is_number(type.id())) throw Hdf5Error(fmt::format("{}: expected numbers, found another type", in_quotes(path)));
  Numbers found;
  found.sizes = sizes_of(space.id(), path, most_sizes, std::min(most_values, most_values_in(bytes_)));
  found.values.resize(product(found.sizes));
  if (H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, found.values.data()) < 0)
    unreadable(path);
  return found;
}

std::vector<std::string> Hdf5Source::texts(const std::string& path) const {
  const Silence silence;
  const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle space(dataset.valid() ? H5Dget_space(dataset.id()) : -1, H5Sclose);
  const Handle type(dataset.valid() ? H5Dget_type(dataset.id()) : -1, H5Tclose);
  if (!type.valid() || !is_text(type.id()))
    throw Hdf5Error(fmt::format("{}: expected texts, found something else", in_quotes(path)));
  std::vector<char*> pointers(
      product(sizes_of(space.id(), path, 1, std::min<std::size_t>(1'000'000, most_values_in(bytes_)))), nullptr);
  if (H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(pointers.data())) < 0)
    unreadable(path);
  return take(pointers, type.id(), space.id());
}

std::optional<std::string> Hdf5Source::text_attribute(const std::string& path, const std::string& name) const {
  const Silence silence;
  if (H5Aexists_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
  const Handle attribute(H5Aopen_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Handle space(attribute.valid() ? H5Aget_space(attribute.id()) : -1, H5Sclose);
  const Handle type(attribute.valid() ? H5Aget_type(attribute.id()) : -1, H5Tclose);
  if (!type.valid() || !is_text(type.id()) || H5Sget_simple_extent_npoints(space.id()) != 1)
    throw Hdf5Error(fmt::format("attribute {}: expected a text, found something else", in_quotes(name)));
  std::vector<char*> pointers(1, nullptr);
  if (H5Aread(attribute.id(), type.id(), static_cast<void*>(pointers.data())) < 0) unreadable(name);
  return take(pointers, type.id(), space.id()).front();
}

std::optional<std::vector<double>> Hdf5Source::numbers_attribute(const std::string& path,
                                                                 const std::string& name) const {
  const Silence silence;
  if (H5Aexists_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
  const Handle attribute(H5Aopen_by_name(file_, name_in_file(path), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Handle space(attribute.valid() ? H5Aget_space(attribute.id()) : -1, H5Sclose);
  const Handle type(attribute.valid() ? H5Aget_type(attribute.id()) : -1, H5Tclose);
  if (!type.valid() || !is_number(type.id()))
    throw Hdf5Error(fmt::format("attribute {}: expected numbers, found something else", in_quotes(name)));
  std::vector<double> values(product(sizes_of(space.id(), name, 1, 1'000)));
  if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, values.data()) < 0) unreadable(name);
  return values;
}

std::vector<std::string> Hdf5Source::groups(const std::string& path) const {
  const Silence silence;
  std::vector<std::string> names;
  const Handle group(H5Gopen2(file_, name_in_file(path), H5P_DEFAULT), H5Gclose);
  if (group.valid()) H5Literate(group.id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, note_group, &names);
  return names;
}

void read_hdf5(const std::string& path, const std::function<void(const Hdf5Source&)>& read) {
  const Seal seal = seal_of(path);
  if (seal == Seal::broken)
    throw Hdf5Error("is damaged: its bytes do not have the checksum that they were written with");
  const Hdf5Turn turn;
  const auto work = [&] { read(Hdf5Source(path)); };
  if (seal == Seal::none) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(path, error);
    const Rehearsal rehearsal = rehearse(work, error ? 0 : bytes);
    if (rehearsal.end == Rehearsed::complained) throw Hdf5Error(rehearsal.message);
    if (rehearsal.end == Rehearsed::died) throw Hdf5Error("expected a whole HDF5 file, found one that is damaged");
  }
  work();
}

}  // namespace balance::read
