#pragma once
/// Reading HDF5 files. The only place of this room that knows the library.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::read {

/// A file or a part of it is not what was asked for; the message does not name the file.
struct Hdf5Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// An open file. Paths are `group/name` from the root, "" the root itself.
class Hdf5Source {
 public:
  /// Whoever opens one holds a Hdf5Turn: use read_hdf5. @throws Hdf5Error if it is no HDF5 file or cannot be opened
  explicit Hdf5Source(const std::string& file);
  ~Hdf5Source();
  Hdf5Source(const Hdf5Source&) = delete;
  Hdf5Source& operator=(const Hdf5Source&) = delete;

  bool has(const std::string& path) const;

  /// A dataset of numbers, the last dimension varying fastest; a scalar has no sizes.
  struct Numbers {
    std::vector<std::size_t> sizes;
    std::vector<double> values;
  };
  /// @throws Hdf5Error if there is none at `path` or it has more dimensions or values than allowed
  Numbers numbers(const std::string& path, std::size_t most_sizes = 3, std::size_t most_values = 1'000'000'000) const;

  /// A dataset of texts with one dimension. @throws Hdf5Error
  std::vector<std::string> texts(const std::string& path) const;

  /// An attribute of a group or dataset; nothing if it does not exist. @throws Hdf5Error if it is something else
  std::optional<std::string> text_attribute(const std::string& path, const std::string& name) const;
  std::optional<std::vector<double>> numbers_attribute(const std::string& path, const std::string& name) const;

  /// Names of the groups in a group, in the order of the alphabet.
  std::vector<std::string> groups(const std::string& path) const;

 private:
  std::int64_t file_ = -1;
  std::size_t bytes_ = 0;  ///< of the file
};

/// Reads a file, in turn with other threads. HDF5 may crash, hang or leak on a damaged file, so a file without an intact seal (base/seal.hpp)
/// is read in a child process first, and here only if that went well.
/// @param read is called with the open file, possibly twice in two processes
/// @throws Hdf5Error what `read` throws, or that the file is damaged
void read_hdf5(const std::string& path, const std::function<void(const Hdf5Source&)>& read);

}  // namespace balance::read
