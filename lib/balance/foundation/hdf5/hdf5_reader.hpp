#pragma once
/// Reads HDF5 files from untrusted sources. HDF5 may crash, hang or corrupt memory on a damaged file. A child process
/// therefore reads the file through the library, and this process checks the plain values that it receives.

#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::hdf5 {

/// A file or a part of it is not what was requested; the message does not name the file.
struct Hdf5Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Limits on the memory that a file may take in this process.
struct Hdf5ReadLimits {
  std::size_t max_labels = 100'000;           ///< texts per dataset, groups per group
  std::size_t max_label_bytes = 4096;         ///< bytes per label
  std::size_t max_attribute_bytes = 8 << 20;  ///< bytes per attribute
  std::size_t max_values = 8 << 20;           ///< in all datasets read, plus one per byte of the file
};

/// An open file. Paths are `group/name` from the root, "" the root itself.
/// @throws Hdf5Error from every member but the destructor, also if the child dies: the file is damaged
class Hdf5Reader {
 public:
  /// @throws Hdf5Error if it is not an HDF5 file, cannot be opened or does not have the checksum that it was written
  /// with (foundation/hdf5/file_checksum.hpp)
  explicit Hdf5Reader(const std::string& file, const Hdf5ReadLimits& limits = {});

  bool has(const std::string& path) const;

  /// A numeric dataset, the last dimension varying fastest; a scalar has no sizes.
  struct Dataset {
    std::vector<std::size_t> sizes;
    std::vector<double> values;
  };
  /// @throws Hdf5Error if there is none at `path` or it has more dimensions or values than allowed
  Dataset numbers(const std::string& path, std::size_t max_dimensions = 3,
                  std::size_t max_values = 1'000'000'000) const;

  /// A one-dimensional dataset of printable lines. @throws Hdf5Error
  std::vector<std::string> texts(const std::string& path) const;

  /// An attribute of a group or dataset; std::nullopt if it does not exist. @throws Hdf5Error if it has another type or
  /// is not UTF-8
  std::optional<std::string> text_attribute(const std::string& path, const std::string& name) const;
  std::optional<std::vector<double>> numbers_attribute(const std::string& path, const std::string& name) const;
  /// An attribute of several printable lines; empty if it does not exist. @throws Hdf5Error if it has another type
  std::vector<std::string> texts_attribute(const std::string& path, const std::string& name) const;

  /// Names of the groups in a group, in alphabetical order.
  std::vector<std::string> groups(const std::string& path) const;

 private:
  Message request(const Message& question, std::size_t max_bytes) const;
  std::vector<std::size_t> checked_sizes(Message& answer, const std::string& path, std::size_t max_dimensions,
                                         std::size_t max_values) const;
  std::vector<std::string> labels(const Message& question, const std::string& path) const;

  Hdf5ReadLimits limits_;
  std::size_t value_limit_ = 0;  ///< maximum number that may be read
  mutable std::size_t remaining_values_ = 0;
  std::optional<SandboxProcess> child_;
};

}  // namespace balance::hdf5
