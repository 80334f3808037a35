#include "balance/hdf5/driver.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

namespace balance::hdf5 {
namespace {

struct DriverSettings {
  int descriptor = -1;
  int* error = nullptr;
};

/// HDF5 sees the first member and fills it; the rest is ours.
struct DriverFile {
  H5FD_t base{};
  DriverSettings settings;
  haddr_t end_of_allocation = 0;
  haddr_t end_of_file = 0;

  bool failed() const { return *settings.error != 0; }
};

DriverFile& file_of(H5FD_t* base) { return *reinterpret_cast<DriverFile*>(base); }
const DriverFile& file_of(const H5FD_t* base) { return *reinterpret_cast<const DriverFile*>(base); }

/// HDF5 opens twice, first to see whether the file is open already; an empty file needs no truncation.
H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const void* settings = H5Pget_driver_info(access);
  if (settings == nullptr) return nullptr;
  DriverFile* file = new DriverFile;
  file->settings = *static_cast<const DriverSettings*>(settings);
  return &file->base;
}

herr_t close_file(H5FD_t* base) {
  delete &file_of(base);
  return 0;
}

/// What HDF5's own POSIX driver can do too.
herr_t query(const H5FD_t*, unsigned long* flags) {
  if (flags != nullptr) {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
  }
  return 0;
}

haddr_t get_end_of_allocation(const H5FD_t* base, H5FD_mem_t) { return file_of(base).end_of_allocation; }

herr_t set_end_of_allocation(H5FD_t* base, H5FD_mem_t, haddr_t address) {
  file_of(base).end_of_allocation = address;
  return 0;
}

haddr_t get_end_of_file(const H5FD_t* base, H5FD_mem_t) { return file_of(base).end_of_file; }

/// What was never written reads as zero, as behind the end of a file.
herr_t read_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* data) {
  DriverFile& file = file_of(base);
  auto* at = static_cast<char*>(data);
  while (size > 0 && !file.failed()) {
    const ssize_t done = ::pread(file.settings.descriptor, at, size, static_cast<off_t>(address));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) *file.settings.error = errno;
    if (done <= 0) break;
    at += done;
    address += static_cast<haddr_t>(done);
    size -= static_cast<std::size_t>(done);
  }
  std::memset(at, 0, size);
  return 0;
}

herr_t write_bytes(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* data) {
  DriverFile& file = file_of(base);
  const auto* at = static_cast<const char*>(data);
  file.end_of_file = std::max(file.end_of_file, address + size);
  while (size > 0 && !file.failed()) {
    const ssize_t done = ::pwrite(file.settings.descriptor, at, size, static_cast<off_t>(address));
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) {
      *file.settings.error = errno;
      break;
    }
    at += done;
    address += static_cast<haddr_t>(done);
    size -= static_cast<std::size_t>(done);
  }
  return 0;
}

/// The file ends where HDF5's last allocation ends.
herr_t truncate_file(H5FD_t* base, hid_t, hbool_t) {
  DriverFile& file = file_of(base);
  if (file.end_of_file != file.end_of_allocation && !file.failed() &&
      ::ftruncate(file.settings.descriptor, static_cast<off_t>(file.end_of_allocation)) != 0) {
    *file.settings.error = errno;
  }
  file.end_of_file = file.end_of_allocation;
  return 0;
}

H5FD_class_t make_class() {
  H5FD_class_t driver{};
  driver.name = "balance";
  driver.maxaddr = static_cast<haddr_t>(std::numeric_limits<off_t>::max());
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(DriverSettings);
  driver.open = open_file;
  driver.close = close_file;
  driver.query = query;
  driver.get_eoa = get_end_of_allocation;
  driver.set_eoa = set_end_of_allocation;
  driver.get_eof = get_end_of_file;
  driver.read = read_bytes;
  driver.write = write_bytes;
  driver.truncate = truncate_file;
  const H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(map), std::end(map), std::begin(driver.fl_map));
  return driver;
}

}  // namespace

Hdf5Handle register_file_driver() {
  const H5FD_class_t driver_class = make_class();
  return Hdf5Handle(H5FDregister(&driver_class), H5FDunregister);
}

Hdf5Handle make_file_access_list(const Hdf5Handle& driver, int descriptor, int& error) {
  const DriverSettings settings{descriptor, &error};
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  check_status(H5Pset_driver(access.get(), driver.get(), &settings));
  return access;
}

}  // namespace balance::hdf5
