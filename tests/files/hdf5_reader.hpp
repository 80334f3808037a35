#pragma once
#include <hdf5.h>
#include <hdf5_hl.h>

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace sample {

/// Reads a file back with HDF5's own functions; wrong names fail the test.
class Reader {
 public:
  explicit Reader(const std::string& path) : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {
    REQUIRE(file_ >= 0);
  }
  ~Reader() { H5Fclose(file_); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  bool has(const std::string& name) const { return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0; }

  std::vector<hsize_t> sizes(const std::string& name) const {
    const hid_t dataset = open(name), space = H5Dget_space(dataset);
    std::vector<hsize_t> result(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, result.data(), nullptr);
    H5Sclose(space);
    H5Dclose(dataset);
    return result;
  }

  std::vector<double> numbers(const std::string& name) const {
    hsize_t count = 1;
    for (const hsize_t size : sizes(name)) count *= size;
    std::vector<double> values(count);
    const hid_t dataset = open(name);
    REQUIRE(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
    H5Dclose(dataset);
    return values;
  }

  std::vector<std::string> texts(const std::string& name) const {
    std::vector<char*> pointers(sizes(name).at(0));
    const hid_t dataset = open(name), type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    REQUIRE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0);
    const std::vector<std::string> result(pointers.begin(), pointers.end());
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
    H5Sclose(space);
    H5Tclose(type);
    H5Dclose(dataset);
    return result;
  }

  std::string text_attribute(const std::string& object, const std::string& name) const {
    const hid_t attribute = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(attribute >= 0);
    const hid_t type = H5Aget_type(attribute);
    char* text = nullptr;
    REQUIRE(H5Aread(attribute, type, &text) >= 0);
    const std::string result = text;
    H5free_memory(text);
    H5Tclose(type);
    H5Aclose(attribute);
    return result;
  }

  std::vector<double> number_attribute(const std::string& object, const std::string& name) const {
    const hid_t attribute = H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    REQUIRE(attribute >= 0);
    std::vector<double> values(H5Aget_storage_size(attribute) / sizeof(double));
    REQUIRE(H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()) >= 0);
    H5Aclose(attribute);
    return values;
  }

  /// The names of the scales attached to each dimension, "-" for a dimension without exactly one.
  std::vector<std::string> dimensions(const std::string& name) const {
    const std::string group = name.substr(0, name.rfind('/') + 1);
    const hid_t dataset = open(name);
    std::vector<std::string> result;
    const bool scale = H5DSis_scale(dataset) > 0;
    if (scale) result.push_back(name.substr(group.size()));
    for (unsigned i = 0; !scale && i < sizes(name).size(); ++i) {
      std::string found = "-";
      H5DSiterate_scales(dataset, i, nullptr, note_scale, &found);
      result.push_back(H5DSget_num_scales(dataset, i) == 1 && belong_together(dataset, group + found, i) ? found : "-");
    }
    H5Dclose(dataset);
    return result;
  }

  std::vector<std::string> datasets() const {
    std::vector<std::string> names;
    H5Ovisit2(file_, H5_INDEX_CRT_ORDER, H5_ITER_INC, note_dataset, &names, H5O_INFO_BASIC);
    return names;
  }

  hid_t open(const std::string& name) const {
    const hid_t dataset = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    REQUIRE_MESSAGE(dataset >= 0, name);
    return dataset;
  }

 private:
  /// HDF5 agrees only if the dataset names the scale and the scale names the dataset.
  bool belong_together(hid_t dataset, const std::string& scale_name, unsigned dimension) const {
    const hid_t scale = open(scale_name);
    const bool attached = H5DSis_attached(dataset, scale, dimension) > 0;
    H5Dclose(scale);
    return attached;
  }
  static herr_t note_scale(hid_t, unsigned, hid_t scale, void* data) {
    char name[64] = "";
    H5DSget_scale_name(scale, name, sizeof name);
    *static_cast<std::string*>(data) = name;
    return 0;
  }
  static herr_t note_dataset(hid_t, const char* name, const H5O_info_t* info, void* data) {
    if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(data)->push_back(name);
    return 0;
  }

  hid_t file_;
};

}  // namespace sample
