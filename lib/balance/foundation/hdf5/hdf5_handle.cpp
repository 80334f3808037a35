#include "balance/foundation/hdf5/hdf5_handle.hpp"

#include "balance/foundation/base/error.hpp"

#include <algorithm>
#include <array>

namespace balance::hdf5 {
namespace {

/// For walking the stack upwards: the first entry is the innermost.
herr_t record_reason(unsigned, const H5E_error2_t* entry, void* data) {
  std::string& reason = *static_cast<std::string*>(data);
  if (reason.empty() && entry->desc != nullptr) reason = entry->desc;
  return 0;
}

}  // namespace

std::string pop_error_message() {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, record_reason, &reason);
  H5Eclear2(H5E_DEFAULT);
  return reason.empty() ? "HDF5 failed without giving a reason" : reason;
}

hid_t check_id(hid_t id) {
  if (id < 0) throw SystemError(pop_error_message());
  return id;
}

void check_status(herr_t status) { check_id(status); }

Hdf5Handle make_dataspace(const std::vector<hsize_t>& sizes) {
  if (sizes.empty()) return Hdf5Handle(H5Screate(H5S_SCALAR), H5Sclose);
  return Hdf5Handle(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
}

Hdf5Handle make_utf8_type() {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  check_status(H5Tset_size(type.get(), H5T_VARIABLE));
  check_status(H5Tset_cset(type.get(), H5T_CSET_UTF8));
  return type;
}

void write_attribute(hid_t owner, const char* name, hid_t type, hid_t space, const void* data) {
  Hdf5Handle attribute(H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check_status(H5Awrite(attribute.get(), type, data));
  attribute.close();
}

void write_text(hid_t owner, const char* name, const std::string& text) {
  const char* pointer = text.c_str();
  write_attribute(owner, name, make_utf8_type().get(), make_dataspace({}).get(), &pointer);
}

void make_dimension_scale(hid_t dataset, const std::string& dimension_name) {
  const auto write_fixed = [&](const char* name, const std::string& text) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    check_status(H5Tset_size(type.get(), text.size() + 1));  // null-terminated
    write_attribute(dataset, name, type.get(), make_dataspace({}).get(), text.c_str());
  };
  write_fixed("CLASS", "DIMENSION_SCALE");
  write_fixed("NAME", dimension_name);
}

void write_dimension_list(hid_t dataset, const std::vector<hobj_ref_t>& scales) {
  std::vector<hobj_ref_t> references = scales;
  std::vector<hvl_t> lists;
  for (hobj_ref_t& reference : references) lists.push_back({1, &reference});
  const Hdf5Handle type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose);
  write_attribute(dataset, "DIMENSION_LIST", type.get(), make_dataspace({lists.size()}).get(), lists.data());
}

void write_reference_list(hid_t scale, const std::vector<ScaleReference>& uses) {
  if (uses.empty()) return;
  const Hdf5Handle type(H5Tcreate(H5T_COMPOUND, sizeof(ScaleReference)), H5Tclose);
  check_status(H5Tinsert(type.get(), "dataset", HOFFSET(ScaleReference, dataset), H5T_STD_REF_OBJ));
  check_status(H5Tinsert(type.get(), "dimension", HOFFSET(ScaleReference, dimension), H5T_NATIVE_INT));
  // Copied into zeroed memory so that the padding between the members is the same in every run.
  std::vector<std::array<unsigned char, sizeof(ScaleReference)>> bytes(uses.size());
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const auto* dataset = reinterpret_cast<const unsigned char*>(&uses[i].dataset);
    const auto* dimension = reinterpret_cast<const unsigned char*>(&uses[i].dimension);
    std::copy_n(dataset, sizeof(hobj_ref_t), bytes[i].data() + HOFFSET(ScaleReference, dataset));
    std::copy_n(dimension, sizeof(int), bytes[i].data() + HOFFSET(ScaleReference, dimension));
  }
  write_attribute(scale, "REFERENCE_LIST", type.get(), make_dataspace({uses.size()}).get(), bytes.data());
}

}  // namespace balance::hdf5
