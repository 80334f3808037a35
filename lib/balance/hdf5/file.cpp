#include "balance/hdf5/file.hpp"

#include "balance/base/error.hpp"
#include "balance/hdf5/checksum.hpp"
#include "balance/hdf5/driver.hpp"
#include "balance/hdf5/handle.hpp"
#include "balance/hdf5/turn.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>
#include <stdexcept>

namespace balance {

using hdf5::check_status;
using hdf5::Hdf5Handle;

namespace {

constexpr unsigned creation_order_flags = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
constexpr hsize_t chunk_values =
    65536;  // half a megabyte: large enough to compress well, small enough for HDF5's cache
constexpr unsigned gzip_level = 4;

/// Creation order without times of day, for the root (a file's list) and for groups.
Hdf5Handle group_properties(hid_t property_class) {
  Hdf5Handle properties(H5Pcreate(property_class), H5Pclose);
  check_status(H5Pset_link_creation_order(properties.get(), creation_order_flags));
  check_status(H5Pset_attr_creation_order(properties.get(), creation_order_flags));
  check_status(H5Pset_obj_track_times(properties.get(), false));
  return properties;
}

/// Samples are compressed in chunks of whole rows.
void set_chunks(hid_t properties, std::vector<hsize_t> sizes) {
  hsize_t row = 1;
  for (std::size_t i = 1; i < sizes.size(); ++i) row *= sizes[i];
  sizes[0] = std::clamp<hsize_t>(chunk_values / row, 1, sizes[0]);
  check_status(H5Pset_chunk(properties, static_cast<int>(sizes.size()), sizes.data()));
  check_status(H5Pset_shuffle(properties));
  check_status(H5Pset_deflate(properties, gzip_level));
}

/// Texts are converted in pieces, for each of which HDF5 clears a buffer: of a megabyte if it is not told otherwise, for three labels.
Hdf5Handle transfer_properties(bool text, std::size_t count) {
  Hdf5Handle properties(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  constexpr std::size_t bytes_per_text = 32, min_buffer_bytes = 4096, max_buffer_bytes = std::size_t{1} << 20;
  if (text) {
    const std::size_t size = std::clamp(bytes_per_text * count, min_buffer_bytes, max_buffer_bytes);
    check_status(H5Pset_buffer(properties.get(), size, nullptr, nullptr));
  }
  return properties;
}

/// How the bytes of a dataset lie: text of any length cannot do without fill values, numbers are all written anyway.
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
    std::vector<hdf5::ScaleReference> uses;
  };

  Hdf5Lock turn;
  hdf5::ErrorSilencer silence;  // first in, last out: closing may fail too
  std::string shown_name;
  Storage storage = Storage::contiguous;
  int descriptor = -1;
  int system_error = 0;  // noted by the driver
  Hdf5Handle driver;
  Hdf5Handle file;
  std::vector<Hdf5Handle> groups;
  std::vector<Scale> scales;

  [[noreturn]] void fail(const std::string& reason) const {
    throw SystemError(fmt::format("cannot write {}: {}", shown_name, reason));
  }

  /// Runs something and says which file a failure belongs to and why.
  void with_error_context(const std::function<void()>& work) {
    std::string reason;
    try {
      work();
    } catch (const SystemError& error) {
      reason = error.what();
    }
    if (system_error != 0) fail(std::strerror(system_error));
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
    const bool text = H5Tget_class(type) == H5T_STRING;
    const bool compress = storage == Storage::compressed && !sizes.empty();
    const Hdf5Handle properties = dataset_properties(sizes, text       ? Layout::text
                                                            : compress ? Layout::compressed
                                                                       : Layout::contiguous);
    Hdf5Handle dataset(H5Dcreate2(groups.at(group.index).get(), variable.name.c_str(), type,
                                  hdf5::make_dataspace(sizes).get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                       H5Dclose);
    const hsize_t count = std::accumulate(sizes.begin(), sizes.end(), hsize_t{1}, std::multiplies<>());
    const Hdf5Handle transfer = transfer_properties(text, count);
    check_status(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, transfer.get(), data));
    hdf5::write_text(dataset.get(), "long_name", variable.long_name);
    hdf5::write_text(dataset.get(), "units", variable.units);
    for (const NumericAttribute& numbers_attribute : variable.attributes) {
      hdf5::write_attribute(dataset.get(), numbers_attribute.name.c_str(), H5T_NATIVE_DOUBLE,
                            hdf5::make_dataspace({numbers_attribute.values.size()}).get(),
                            numbers_attribute.values.data());
    }
    return dataset;
  }

  Dimension add_scale(Hdf5Handle dataset, const std::string& name, hsize_t size) {
    hdf5::make_dimension_scale(dataset.get(), name);
    Scale scale;
    check_status(H5Rcreate(&scale.reference, dataset.get(), ".", H5R_OBJECT, -1));
    scale.dataset = std::move(dataset);
    scale.size = size;
    scales.push_back(std::move(scale));
    return {static_cast<int>(scales.size()) - 1};
  }

  void attach(const Hdf5Handle& dataset, const std::vector<Dimension>& dimensions) {
    if (dimensions.empty()) return;
    hobj_ref_t own = 0;
    check_status(H5Rcreate(&own, dataset.get(), ".", H5R_OBJECT, -1));
    std::vector<hobj_ref_t> references;
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      Scale& scale = scales.at(dimensions[i].index);
      references.push_back(scale.reference);
      scale.uses.push_back({own, static_cast<int>(i)});
    }
    hdf5::write_dimension_list(dataset.get(), references);
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
    self.driver = hdf5::register_file_driver();
    const Hdf5Handle access = hdf5::make_file_access_list(self.driver, descriptor, self.system_error);
    // The oldest format that can hold everything, never one that HDF5 1.8 and its users cannot read.
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

Hdf5Writer::Dimension Hdf5Writer::add_dimension(Group group, const Variable& variable, std::span<const double> values) {
  return implementation_->add_dimension(group, variable, values.size(), H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                        values.data());
}

Hdf5Writer::Dimension Hdf5Writer::add_dimension(Group group, const Variable& variable,
                                                const std::vector<std::string>& labels) {
  const Hdf5Handle type = hdf5::make_utf8_type();
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
  const Hdf5Handle type = hdf5::make_utf8_type();
  implementation_->add(group, variable, values.size(), type.get(), type.get(), pointers(values).data());
}

void Hdf5Writer::close() {
  Implementation& self = *implementation_;
  self.with_error_context([&] {
    for (Implementation::Scale& scale : self.scales) {
      hdf5::write_reference_list(scale.dataset.get(), scale.uses);
      scale.dataset.close();
    }
    for (Hdf5Handle& group : self.groups) group.close();
    check_status(H5Fflush(self.file.get(), H5F_SCOPE_GLOBAL));
    self.file.close();
    if (self.system_error == 0) self.system_error = append_checksum(self.descriptor);
  });
}

}  // namespace balance
