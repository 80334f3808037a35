#pragma once
/// HDF5 identifiers that close themselves, and HDF5's error stack as an exception. For the sources of this room only.

#include <hdf5.h>

#include <string>
#include <utility>
#include <vector>

namespace balance::hdf5 {

/// Suppresses HDF5's error output while it exists, then restores the previous setting.
class ErrorSilencer {
 public:
  ErrorSilencer() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~ErrorSilencer() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  ErrorSilencer(const ErrorSilencer&) = delete;
  ErrorSilencer& operator=(const ErrorSilencer&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Returns the innermost reason on HDF5's error stack and clears the stack.
std::string pop_error_message();

/// Returns its argument. @throws SystemError with HDF5's reason if it is negative
hid_t check_id(hid_t id);
void check_status(herr_t status);

/// Owns one identifier.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Handle() = default;
  /// @throws SystemError if `id` reports a failed creation
  Hdf5Handle(hid_t id, Close closer) : id_(check_id(id)), close_(closer) {}
  ~Hdf5Handle() { release(); }
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }

  /// For creations that may fail without an exception. @return invalid if `id` reports a failed creation
  static Hdf5Handle from_unchecked(hid_t id, Close closer) {
    Hdf5Handle handle;
    handle.id_ = id;
    handle.close_ = closer;
    return handle;
  }

  hid_t get() const { return id_; }
  bool is_valid() const { return id_ >= 0; }

  /// Closes now. @throws SystemError if that fails
  void close() {
    if (release() < 0) check_status(-1);
  }

 private:
  herr_t release() { return id_ < 0 ? 0 : close_(std::exchange(id_, H5I_INVALID_HID)); }

  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// A dataspace; scalar if `sizes` is empty.
Hdf5Handle make_dataspace(const std::vector<hsize_t>& sizes);

/// Type of UTF-8 text of variable length.
Hdf5Handle make_utf8_type();

/// Creates an attribute and writes it.
void write_attribute(hid_t owner, const char* name, hid_t type, hid_t space, const void* data);

/// Writes variable-length text, which h5py returns as str; it returns fixed-length text as bytes.
void write_text(hid_t owner, const char* name, const std::string& text);

/// Writes the attributes that make a dataset a dimension scale, as defined by the HDF5 Dimension Scale Specification
/// 1.0. HDF5's own H5DS functions are not used because they write uninitialised bytes to the file: the padding in
/// REFERENCE_LIST.
void make_dimension_scale(hid_t dataset, const std::string& dimension_name);

/// DIMENSION_LIST: the scale of each dimension of a dataset.
void write_dimension_list(hid_t dataset, const std::vector<hobj_ref_t>& scales);

/// One use of a scale: the dataset and which of its dimensions.
struct ScaleReference {
  hobj_ref_t dataset = 0;
  int dimension = 0;
};

/// REFERENCE_LIST: the uses of a scale.
void write_reference_list(hid_t scale, const std::vector<ScaleReference>& uses);

}  // namespace balance::hdf5
