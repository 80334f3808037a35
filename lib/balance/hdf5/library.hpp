#pragma once
/// HDF5 itself, to be called where it may crash. The only place of this room that knows the library.

#include "balance/hdf5/source.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace balance {

/// From here on the library neither follows links into other files nor loads filters, anywhere in this process.
void disable_links_and_filters();

/// An open file, or one that cannot be opened. Paths as in Hdf5Source; every member throws Hdf5Error.
class Hdf5DirectReader {
 public:
  explicit Hdf5DirectReader(const std::string& file);
  ~Hdf5DirectReader();
  Hdf5DirectReader(const Hdf5DirectReader&) = delete;
  Hdf5DirectReader& operator=(const Hdf5DirectReader&) = delete;

  bool is_open() const { return file_ >= 0; }
  bool has(const std::string& path) const;

  /// Numbers in this file.
  class Dataset {
   public:
    struct Open;
    explicit Dataset(std::unique_ptr<Open> open);
    ~Dataset();
    Dataset(Dataset&&) noexcept;
    Dataset& operator=(Dataset&&) noexcept;
    const std::vector<std::uint64_t>& sizes() const;
    /// Hands over all values, some at a time. @return whether all could be read
    bool read(const std::function<void(std::span<const double>)>& take) const;

   private:
    std::unique_ptr<Open> open_;
  };
  Dataset dataset(const std::string& path) const;

  std::vector<std::string> texts(const std::string& path, std::size_t most) const;
  std::optional<std::string> text_attribute(const std::string& path, const std::string& name, std::size_t most) const;
  std::optional<std::vector<double>> numbers_attribute(const std::string& path, const std::string& name,
                                                       std::size_t most) const;
  std::vector<std::string> groups(const std::string& path, std::size_t most) const;

 private:
  std::int64_t file_ = -1;
};

}  // namespace balance
