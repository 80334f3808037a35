// The only source that uses zlib.

#include "balance/foundation/hdf5/file_checksum.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <optional>
#include <vector>

namespace balance::hdf5 {

namespace {

constexpr std::size_t checksum_length = 16;

std::string checksum_text(unsigned long checksum) {
  char text[checksum_length + 1];
  std::snprintf(text, sizeof text, "balance:%08lx", checksum);
  return text;
}

/// Reads [offset, offset + size), or less at the end of the file. @return number of bytes read; std::nullopt if the
/// system fails
std::optional<std::size_t> read_at(int descriptor, char* buffer, std::size_t size, off_t offset) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t count = ::pread(descriptor, buffer + done, size - done, offset + static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::nullopt;
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

/// Of the first `size` bytes; std::nullopt if they cannot be read.
std::optional<unsigned long> crc_of(int descriptor, off_t size) {
  std::vector<char> block(std::size_t{1} << 20);
  unsigned long sum = crc32(0, nullptr, 0);
  for (off_t offset = 0; offset < size;) {
    const auto requested = static_cast<std::size_t>(std::min<off_t>(size - offset, static_cast<off_t>(block.size())));
    const auto read_count = read_at(descriptor, block.data(), requested, offset);
    if (!read_count || *read_count != requested) return std::nullopt;
    sum = crc32(sum, reinterpret_cast<const Bytef*>(block.data()), static_cast<uInt>(requested));
    offset += static_cast<off_t>(requested);
  }
  return sum;
}

off_t size_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? status.st_size : -1;
}

ChecksumStatus checksum_of(int descriptor) {
  const off_t size = size_of(descriptor) - static_cast<off_t>(checksum_length);
  char trailer[checksum_length];
  if (size < 0 || read_at(descriptor, trailer, checksum_length, size) != checksum_length) return ChecksumStatus::none;
  const std::string text(trailer, checksum_length);
  if (!text.starts_with("balance:")) return ChecksumStatus::none;
  const auto sum = crc_of(descriptor, size);
  return sum && checksum_text(*sum) == text ? ChecksumStatus::intact : ChecksumStatus::mismatch;
}

}  // namespace

int append_checksum(int descriptor) {
  const off_t size = size_of(descriptor);
  if (size < 0) return errno;
  errno = 0;
  const auto sum = crc_of(descriptor, size);
  if (!sum) return errno != 0 ? errno : EIO;  // the file has become shorter
  const std::string text = checksum_text(*sum);
  for (std::size_t done = 0; done < checksum_length;) {
    const ssize_t written =
        ::pwrite(descriptor, text.data() + done, checksum_length - done, size + static_cast<off_t>(done));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    done += static_cast<std::size_t>(written);
  }
  return 0;
}

ChecksumStatus verify_checksum(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return ChecksumStatus::none;
  const ChecksumStatus status = checksum_of(descriptor);
  ::close(descriptor);
  return status;
}

}  // namespace balance::hdf5
