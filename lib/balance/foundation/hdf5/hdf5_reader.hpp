#pragma once
/// Reading HDF5 files of strangers. HDF5 may crash, hang or write over its memory on a damaged file, so a child process has the
/// library read the file, and this process takes from it plain values, which it checks.

#include "balance/foundation/hdf5/sandbox_process.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// A file or a part of it is not what was asked for; the message does not name the file.
struct Hdf5Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a file may make of this process's memory.
struct Hdf5ReadLimits {
  std::size_t max_labels = 100'000;           ///< texts in one dataset, groups in one group
  std::size_t max_label_bytes = 4096;         ///< bytes of one of them
  std::size_t max_attribute_bytes = 8 << 20;  ///< bytes of an attribute
  std::size_t max_values = 8 << 20;           ///< of all datasets read, besides one for each byte of the file
};

/// An open file. Paths are `group/name` from the root, "" the root itself. Every member but the destructor
/// @throws Hdf5Error also if the child dies: the file is damaged
class Hdf5Reader {
 public:
  /// @throws Hdf5Error if it is no HDF5 file or cannot be opened, or has not the checksum that it was written with
  /// (foundation/hdf5/file_checksum.hpp)
  explicit Hdf5Reader(const std::string& file, const Hdf5ReadLimits& limits = {});

  bool has(const std::string& path) const;

  /// A dataset of numbers, the last dimension varying fastest; a scalar has no sizes.
  struct Dataset {
    std::vector<std::size_t> sizes;
    std::vector<double> values;
  };
  /// @throws Hdf5Error if there is none at `path` or it has more dimensions or values than allowed
  Dataset numbers(const std::string& path, std::size_t max_dimensions = 3,
                  std::size_t max_values = 1'000'000'000) const;

  /// A dataset of texts with one dimension: lines that can be printed. @throws Hdf5Error
  std::vector<std::string> texts(const std::string& path) const;

  /// An attribute of a group or dataset; nothing if it does not exist. @throws Hdf5Error if it is something else or no UTF-8
  std::optional<std::string> text_attribute(const std::string& path, const std::string& name) const;
  std::optional<std::vector<double>> numbers_attribute(const std::string& path, const std::string& name) const;
  /// An attribute of several lines that can be printed; none if it does not exist. @throws Hdf5Error if it is something else
  std::vector<std::string> texts_attribute(const std::string& path, const std::string& name) const;

  /// Names of the groups in a group, in the order of the alphabet.
  std::vector<std::string> groups(const std::string& path) const;

 private:
  Message request(const Message& question, std::size_t most) const;
  std::vector<std::size_t> checked_sizes(Message& answer, const std::string& path, std::size_t max_dimensions,
                                         std::size_t max_values) const;
  std::vector<std::string> labels(const Message& question, const std::string& path) const;

  Hdf5ReadLimits limits_;
  std::size_t values_ = 0;  ///< that may be read
  mutable std::size_t values_left_ = 0;
  std::optional<SandboxProcess> child_;
};

}  // namespace balance
