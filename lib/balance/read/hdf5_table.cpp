// The only place of this room that knows HDF5.

#include "balance/read/nearest.hpp"
#include "balance/read/table.hpp"

#include <fmt/format.h>
#include <hdf5.h>

namespace balance::read {

namespace {

constexpr hsize_t most_rows = 10'000'000;

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

std::vector<double> read_column(hid_t file, const std::string& name) {
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.valid())
    throw TableError(fmt::format("expected a dataset {}, found something else of that name", in_quotes(name)));
  const Handle space(H5Dget_space(dataset.id()), H5Sclose);
  const Handle type(H5Dget_type(dataset.id()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.id());
  if (kind != H5T_FLOAT && kind != H5T_INTEGER)
    throw TableError(fmt::format("{}: expected numbers, found another type", in_quotes(name)));
  if (H5Sget_simple_extent_ndims(space.id()) != 1)
    throw TableError(
        fmt::format("{}: expected one dimension, found {}", in_quotes(name), H5Sget_simple_extent_ndims(space.id())));
  hsize_t size = 0;
  H5Sget_simple_extent_dims(space.id(), &size, nullptr);
  if (size > most_rows)
    throw TableError(fmt::format("{}: expected at most {} values, found {}", in_quotes(name), most_rows, size));
  std::vector<double> values(size);
  if (H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    throw TableError(fmt::format("{}: cannot be read", in_quotes(name)));
  return values;
}

}  // namespace

RawTable read_hdf5_table(const std::string& path, const std::vector<std::string>& names) {
  const Silence silence;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) throw TableError("expected an HDF5 file, found one that cannot be opened as such");
  RawTable table;
  for (const std::string& name : names) {
    if (H5Lexists(file.id(), name.c_str(), H5P_DEFAULT) <= 0) continue;
    const auto values = read_column(file.id(), name);
    if (table.columns.empty()) table.rows.resize(values.size());
    if (values.size() != table.rows.size())
      throw TableError(fmt::format("{}: expected {} values as in {}, found {}", in_quotes(name), table.rows.size(),
                                   in_quotes(table.columns[0]), values.size()));
    table.columns.push_back(name);
    for (std::size_t i = 0; i < values.size(); ++i) table.rows[i].push_back(values[i]);
  }
  return table;
}

}  // namespace balance::read
