#include "balance/foundation/hdf5/hdf5_writer.hpp"

#include "balance/foundation/base/file_error.hpp"
#include "balance/foundation/hdf5/file_checksum.hpp"
#include "balance/foundation/hdf5/hdf5_handle.hpp"
#include "balance/foundation/hdf5/hdf5_lock.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace balance::hdf5 {

// A file driver that writes to an open descriptor and never reports a failure to HDF5. HDF5 cannot release a file that
// it failed to write: it keeps the memory and crashes when the program ends. This driver records the first failure and
// pretends success from then on; the writer checks the record.

/// Must outlive the files that use it: HDF5 still accesses it after closing the last one.
Hdf5Handle register_file_driver();

/// @param descriptor of an empty file, open for reading and writing; not closed here
/// @param error receives the system's error number if something fails; must outlive the file
/// @return a file access list; the file name passed to H5Fcreate with it is only a label
Hdf5Handle make_file_access_list(const Hdf5Handle& driver, int descriptor, int& error);

namespace {

struct DriverSettings {
  int descriptor = -1;
  int* error = nullptr;
};

/// HDF5 sees and fills the first member; the others are private to this driver.
struct DriverFile {
  H5FD_t base{};
  DriverSettings settings;
  haddr_t end_of_allocation = 0;
  haddr_t end_of_file = 0;

  bool failed() const { return *settings.error != 0; }
};

DriverFile& file_of(H5FD_t* base) { return *reinterpret_cast<DriverFile*>(base); }
const DriverFile& file_of(const H5FD_t* base) { return *reinterpret_cast<const DriverFile*>(base); }

/// HDF5 opens twice, first to check whether the file is open already; an empty file needs no truncation.
H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const void* settings = H5Pget_driver_info(access);
  if (settings == nullptr) return nullptr;
  DriverFile* file = new DriverFile;
  file->settings = *static_cast<const DriverSettings*>(settings);
  return &file->base;
}

herr_t close_file(H5FD_t* base) {
  delete &file_of(base);
  return 0;
}

/// The same features as HDF5's own POSIX driver.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr) {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  }
  return 0;
}

haddr_t get_end_of_allocation(const H5FD_t* base, H5FD_mem_t) { return file_of(base).end_of_allocation; }

herr_t set_end_of_allocation(H5FD_t* base, H5FD_mem_t, haddr_t address) {
  file_of(base).end_of_allocation = address;
  return 0;
}

haddr_t get_end_of_file(const H5FD_t* base, H5FD_mem_t) { return file_of(base).end_of_file; }

/// Unwritten bytes read as zero, as they do past the end of a file.
herr_t read_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* data) {
  DriverFile& file = file_of(base);
  auto* destination = static_cast<char*>(data);
  while (size > 0 && !file.failed()) {
    const ssize_t count = ::pread(file.settings.descriptor, destination, size, static_cast<off_t>(address));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) *file.settings.error = errno;
    if (count <= 0) break;
    destination += count;
    address += static_cast<haddr_t>(count);
    size -= static_cast<std::size_t>(count);
  }
  std::memset(destination, 0, size);
  return 0;
}

herr_t write_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* data) {
  DriverFile& file = file_of(base);
  const auto* source = static_cast<const char*>(data);
  file.end_of_file = std::max(file.end_of_file, address + size);
  while (size > 0 && !file.failed()) {
    const ssize_t count = ::pwrite(file.settings.descriptor, source, size, static_cast<off_t>(address));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      *file.settings.error = errno;
      break;
    }
    source += count;
    address += static_cast<haddr_t>(count);
    size -= static_cast<std::size_t>(count);
  }
  return 0;
}

/// The file ends where HDF5's last allocation ends.
herr_t truncate_file(H5FD_t* base, hid_t, hbool_t) {
  DriverFile& file = file_of(base);
  if (file.end_of_file != file.end_of_allocation && !file.failed() &&
      ::ftruncate(file.settings.descriptor, static_cast<off_t>(file.end_of_allocation)) != 0) {
    *file.settings.error = errno;
  }
  file.end_of_file = file.end_of_allocation;
  return 0;
}

H5FD_class_t make_class() {
  H5FD_class_t driver{};
  driver.name = "balance";
  driver.maxaddr = static_cast<haddr_t>(std::numeric_limits<off_t>::max());
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(DriverSettings);
  driver.open = open_file;
  driver.close = close_file;
  driver.query = query;
  driver.get_eoa = get_end_of_allocation;
  driver.set_eoa = set_end_of_allocation;
  driver.get_eof = get_end_of_file;
  driver.read = read_bytes;
  driver.write = write_bytes;
  driver.truncate = truncate_file;
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), std::begin(driver.fl_map));
  return driver;
}

}  // namespace

Hdf5Handle register_file_driver() {
  const H5FD_class_t driver_class = make_class();
  return Hdf5Handle(H5FDregister(&driver_class), H5FDunregister);
}

Hdf5Handle make_file_access_list(const Hdf5Handle& driver, int descriptor, int& error) {
  const DriverSettings settings{descriptor, &error};
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  check_status(H5Pset_driver(access.get(), driver.get(), &settings));
  return access;
}

using hdf5::check_status;
using hdf5::Hdf5Handle;

namespace {

constexpr unsigned creation_order_flags = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
constexpr hsize_t chunk_values =
    65536;  // half a megabyte: large enough to compress well, small enough for HDF5's cache
constexpr unsigned gzip_level = 4;

/// Creation order without times, for the root (in the file creation list) and for groups.
Hdf5Handle group_properties(hid_t property_class) {
  Hdf5Handle properties(H5Pcreate(property_class), H5Pclose);
  check_status(H5Pset_link_creation_order(properties.get(), creation_order_flags));
  check_status(H5Pset_attr_creation_order(properties.get(), creation_order_flags));
  check_status(H5Pset_obj_track_times(properties.get(), false));
  return properties;
}

/// Compresses samples in chunks of whole rows.
void set_chunks(hid_t properties, std::vector<hsize_t> sizes) {
  hsize_t row = 1;
  for (std::size_t i = 1; i < sizes.size(); ++i) row *= sizes[i];
  sizes[0] = std::clamp<hsize_t>(chunk_values / row, 1, sizes[0]);
  check_status(H5Pset_chunk(properties, static_cast<int>(sizes.size()), sizes.data()));
  check_status(H5Pset_shuffle(properties));
  check_status(H5Pset_deflate(properties, gzip_level));
}

/// HDF5 converts texts in pieces and clears a buffer for each: by default a megabyte, even for three labels.
Hdf5Handle transfer_properties(bool is_text, std::size_t count) {
  Hdf5Handle properties(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  constexpr std::size_t bytes_per_text = 32, min_buffer_bytes = 4096, max_buffer_bytes = std::size_t{1} << 20;
  if (is_text) {
    const std::size_t size = std::clamp(bytes_per_text * count, min_buffer_bytes, max_buffer_bytes);
    check_status(H5Pset_buffer(properties.get(), size, nullptr, nullptr));
  }
  return properties;
}

/// Storage layout of a dataset. Variable-length text needs fill values; numbers do not, because all are written.
enum class Layout { text, contiguous, compressed };

Hdf5Handle dataset_properties(const std::vector<hsize_t>& sizes, Layout layout) {
  Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  check_status(H5Pset_attr_creation_order(properties.get(), creation_order_flags));
  check_status(H5Pset_obj_track_times(properties.get(), false));
  if (layout != Layout::text) check_status(H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER));
  if (layout == Layout::compressed) set_chunks(properties.get(), sizes);
  return properties;
}

}  // namespace

struct Hdf5Writer::Implementation {
  struct Scale {
    Hdf5Handle dataset;
    hobj_ref_t reference = 0;
    hsize_t size = 0;
    std::vector<ScaleReference> uses;
  };

  Hdf5Lock lock;
  ErrorSilencer silence;  // declared first, destroyed last: closing may fail too
  std::string shown_name;
  Storage storage = Storage::contiguous;
  int descriptor = -1;
  int system_error = 0;  // recorded by the driver
  Hdf5Handle driver;
  Hdf5Handle file;
  std::vector<Hdf5Handle> groups;
  std::vector<Scale> scales;

  [[noreturn]] void fail(const std::string& reason) const {
    throw SystemError(fmt::format("cannot write {}: {}", shown_name, reason));
  }

  /// Runs `work`; a failure throws with the file's name and the reason.
  void with_error_context(const std::function<void()>& work) {
    std::string reason;
    try {
      work();
    } catch (const SystemError& error) {
      reason = error.what();
    }
    if (system_error != 0)
      throw FileError(fmt::format("cannot write {}: {}", shown_name, std::strerror(system_error)), system_error);
    if (!reason.empty()) fail(reason);
  }

  std::vector<hsize_t> sizes_of(const Variable& variable) const {
    std::vector<hsize_t> sizes;
    for (const Dimension dimension : variable.dimensions) sizes.push_back(scales.at(dimension.index).size);
    return sizes;
  }

  /// Creates a dataset with the attributes that every dataset has.
  Hdf5Handle create(Group group, const Variable& variable, const std::vector<hsize_t>& sizes, hid_t type,
                    hid_t memory_type, const void* data) {
    const bool is_text = H5Tget_class(type) == H5T_STRING;
    const bool compress = storage == Storage::compressed && !sizes.empty();
    const Hdf5Handle properties = dataset_properties(sizes, is_text    ? Layout::text
                                                            : compress ? Layout::compressed
                                                                       : Layout::contiguous);
    Hdf5Handle dataset(H5Dcreate2(groups.at(group.index).get(), variable.name.c_str(), type,
                                  make_dataspace(sizes).get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                       H5Dclose);
    const hsize_t count = std::accumulate(sizes.begin(), sizes.end(), hsize_t{1}, std::multiplies<>());
    const Hdf5Handle transfer = transfer_properties(is_text, count);
    check_status(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, transfer.get(), data));
    hdf5::write_text(dataset.get(), "long_name", variable.long_name);
    hdf5::write_text(dataset.get(), "units", variable.units);
    for (const NumericAttribute& numbers_attribute : variable.attributes) {
      write_attribute(dataset.get(), numbers_attribute.name.c_str(), H5T_NATIVE_DOUBLE,
                      make_dataspace({numbers_attribute.values.size()}).get(), numbers_attribute.values.data());
    }
    return dataset;
  }

  Dimension add_scale(Hdf5Handle dataset, const std::string& name, hsize_t size) {
    make_dimension_scale(dataset.get(), name);
    Scale scale;
    check_status(H5Rcreate(&scale.reference, dataset.get(), ".", H5R_OBJECT, -1));
    scale.dataset = std::move(dataset);
    scale.size = size;
    scales.push_back(std::move(scale));
    return {static_cast<int>(scales.size()) - 1};
  }

  void attach(const Hdf5Handle& dataset, const std::vector<Dimension>& dimensions) {
    if (dimensions.empty()) return;
    hobj_ref_t dataset_reference = 0;
    check_status(H5Rcreate(&dataset_reference, dataset.get(), ".", H5R_OBJECT, -1));
    std::vector<hobj_ref_t> references;
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      Scale& scale = scales.at(dimensions[i].index);
      references.push_back(scale.reference);
      scale.uses.push_back({dataset_reference, static_cast<int>(i)});
    }
    write_dimension_list(dataset.get(), references);
  }

  void add(Group group, const Variable& variable, std::size_t count, hid_t type, hid_t memory_type, const void* data) {
    const std::vector<hsize_t> sizes = sizes_of(variable);
    hsize_t expected = 1;
    for (const hsize_t size : sizes) expected *= size;
    if (count != expected) {
      throw std::invalid_argument(fmt::format("{}: {} values for {} places", variable.name, count, expected));
    }
    with_error_context([&] {
      Hdf5Handle dataset = create(group, variable, sizes, type, memory_type, data);
      attach(dataset, variable.dimensions);
      dataset.close();
    });
  }

  Dimension add_dimension(Group group, const Variable& variable, std::size_t count, hid_t type, hid_t memory_type,
                          const void* data) {
    if (count == 0) throw std::invalid_argument(variable.name + ": a dimension cannot be empty");
    if (!variable.dimensions.empty()) throw std::invalid_argument(variable.name + ": a dimension has only itself");
    Dimension dimension;
    with_error_context([&] {
      dimension = add_scale(create(group, variable, {count}, type, memory_type, data), variable.name, count);
    });
    return dimension;
  }
};

namespace {

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> result;
  for (const std::string& text : texts) result.push_back(text.c_str());
  return result;
}

}  // namespace

Hdf5Writer::Hdf5Writer(int descriptor, const std::string& shown_name, Storage storage)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.shown_name = shown_name;
  self.descriptor = descriptor;
  self.storage = storage;
  self.with_error_context([&] {
    self.driver = register_file_driver();
    const Hdf5Handle access = make_file_access_list(self.driver, descriptor, self.system_error);
    // The oldest format that can hold everything, and none that HDF5 1.8 and its users cannot read.
    check_status(H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_V18));
    const Hdf5Handle creation = group_properties(H5P_FILE_CREATE);
    self.file = Hdf5Handle(H5Fcreate(shown_name.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
    self.groups.emplace_back(H5Gopen2(self.file.get(), "/", H5P_DEFAULT), H5Gclose);
  });
}

Hdf5Writer::~Hdf5Writer() = default;

Hdf5Writer::Group Hdf5Writer::add_group(Group parent, const std::string& name) {
  Implementation& self = *implementation_;
  self.with_error_context([&] {
    const Hdf5Handle properties = group_properties(H5P_GROUP_CREATE);
    self.groups.emplace_back(
        H5Gcreate2(self.groups.at(parent.index).get(), name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
        H5Gclose);
  });
  return {static_cast<int>(self.groups.size()) - 1};
}

void Hdf5Writer::set_attribute(Group group, const std::string& name, const std::string& text) {
  Implementation& self = *implementation_;
  self.with_error_context([&] { hdf5::write_text(self.groups.at(group.index).get(), name.c_str(), text); });
}

void Hdf5Writer::set_attribute(Group group, const std::string& name, const std::vector<std::string>& texts) {
  Implementation& self = *implementation_;
  self.with_error_context([&] {
    write_attribute(self.groups.at(group.index).get(), name.c_str(), make_utf8_type().get(),
                    make_dataspace({texts.size()}).get(), pointers(texts).data());
  });
}

Hdf5Writer::Dimension Hdf5Writer::add_dimension(Group group, const Variable& variable, std::span<const double> values) {
  return implementation_->add_dimension(group, variable, values.size(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                        values.data());
}

Hdf5Writer::Dimension Hdf5Writer::add_dimension(Group group, const Variable& variable,
                                                const std::vector<std::string>& labels) {
  const Hdf5Handle type = make_utf8_type();
  return implementation_->add_dimension(group, variable, labels.size(), type.get(), type.get(),
                                        pointers(labels).data());
}

void Hdf5Writer::add_variable(Group group, const Variable& variable, std::span<const double> values) {
  implementation_->add(group, variable, values.size(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data());
}

void Hdf5Writer::add_variable(Group group, const Variable& variable, std::span<const int> values) {
  implementation_->add(group, variable, values.size(), H5T_STD_I32LE, H5T_NATIVE_INT, values.data());
}

void Hdf5Writer::add_variable(Group group, const Variable& variable, const std::vector<std::string>& values) {
  const Hdf5Handle type = make_utf8_type();
  implementation_->add(group, variable, values.size(), type.get(), type.get(), pointers(values).data());
}

void Hdf5Writer::close() {
  Implementation& self = *implementation_;
  self.with_error_context([&] {
    for (Implementation::Scale& scale : self.scales) {
      write_reference_list(scale.dataset.get(), scale.uses);
      scale.dataset.close();
    }
    for (Hdf5Handle& group : self.groups) group.close();
    check_status(H5Fflush(self.file.get(), H5F_SCOPE_GLOBAL));
    self.file.close();
    if (self.system_error == 0) self.system_error = append_checksum(self.descriptor);
  });
}

}  // namespace balance::hdf5
