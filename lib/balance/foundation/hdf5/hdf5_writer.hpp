#pragma once
/// Writes HDF5 files of datasets with named dimensions that are valid netCDF-4 too.
///
/// Every dimension of every dataset has a dimension scale: a dataset with the dimension's name that holds its numbers
/// or labels. Creation order is tracked, but not times, so that the same calls give the same bytes.

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace balance::hdf5 {

class Hdf5Writer {
 public:
  enum class Storage { contiguous, compressed };  ///< compressed: chunks with shuffle and gzip

  struct Group {
    int index = 0;  ///< 0 is the root
  };
  struct Dimension {
    int index = 0;
  };
  /// An attribute of a few numbers.
  struct NumericAttribute {
    std::string name;
    std::vector<double> values;
  };
  /// Name, unit and dimensions of a dataset. The last dimension varies fastest; a scalar has none.
  struct Variable {
    std::string name, long_name, units;
    std::vector<Dimension> dimensions;
    std::vector<NumericAttribute> attributes;
  };
  /// @param descriptor of an empty file, open for reading and writing; stays open
  /// @param shown_name name of the file in messages
  /// @throws SystemError, like all other functions here, with HDF5's or the system's reason
  Hdf5Writer(int descriptor, const std::string& shown_name, Storage storage);

  /// Closes without reporting errors. Call close() to know whether the file is complete.
  ~Hdf5Writer();

  /// Adds a group to the root or to another group.
  Group add_group(const std::string& name) { return add_group({}, name); }
  Group add_group(Group parent, const std::string& name);
  void set_attribute(Group group, const std::string& name, const std::string& text);
  /// @param texts at least one, because netCDF has no empty text attributes
  void set_attribute(Group group, const std::string& name, const std::vector<std::string>& texts);

  /// Adds a dimension together with the dataset that holds its values or labels. `variable.dimensions` must be empty,
  /// and there must be at least one value because netCDF has no empty dimensions.
  Dimension add_dimension(Group group, const Variable& variable, std::span<const double> values);
  Dimension add_dimension(Group group, const Variable& variable, const std::vector<std::string>& labels);

  /// Adds a dataset, without copying the values.
  /// @throws std::invalid_argument if the number of values does not match the dimensions
  void add_variable(Group group, const Variable& variable, std::span<const double> values);
  void add_variable(Group group, const Variable& variable, std::span<const int> values);
  void add_variable(Group group, const Variable& variable, const std::vector<std::string>& values);

  /// Writes pending data and closes the file. Nothing may be added afterwards.
  void close();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

inline constexpr Hdf5Writer::Group root_group{};

/// The entries of a vector, or of a matrix row by row.
template <class RowMajor>
std::span<const double> entries_of(const RowMajor& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

}  // namespace balance::hdf5
