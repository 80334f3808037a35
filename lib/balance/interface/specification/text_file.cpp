#include "balance/interface/specification/text_file.hpp"

#include "balance/foundation/base/file_error.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace balance::specification {
namespace {

/// One byte more than a document may have: an endless source is rejected like a file that is too large.
constexpr std::size_t max_text_bytes = DocumentLimits{}.max_bytes + 1;

constexpr int max_writer_wait = 2;  // without a writer [s]

[[noreturn]] void fail(const std::string& path, const std::string& what, const std::string& reason) {
  throw SystemError(fmt::format("{}: cannot read the {}: {}", path, what, reason));
}

[[noreturn]] void fail(const std::string& path, const std::string& what, int error) {
  throw FileError(fmt::format("{}: cannot read the {}: {}", path, what, std::strerror(error)), error);
}

std::string read_all(int descriptor, const std::string& path, const std::string& what) {
  std::string text(max_text_bytes, '\0');
  std::size_t read = 0;
  while (read < text.size()) {
    const ssize_t count = ::read(descriptor, text.data() + read, text.size() - read);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, what, errno);
    if (count == 0) break;
    read += static_cast<std::size_t>(count);
  }
  text.resize(read);
  return text;
}

/// Waits for a limited time: a pipe may never get a writer.
void wait_for_writer(int pipe, const std::string& path, const std::string& what) {
  pollfd event{pipe, POLLIN, 0};
  for (int tenth = 0; tenth < 10 * max_writer_wait; ++tenth) {
    // poll() reports nothing on a pipe that never had a writer; one whose writer is gone hangs up
    const int ready = ::poll(&event, 1, 100);
    if (ready > 0) return;
    if (ready < 0 && errno != EINTR) fail(path, what, errno);
  }
  fail(path, what, "it is a pipe without a writer");
}

struct FileDescriptor {
  explicit FileDescriptor(int descriptor) : number(descriptor) {}
  ~FileDescriptor() { ::close(number); }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int number;
};

}  // namespace

std::string describe_non_file(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status)) return "";
  return std::filesystem::is_directory(status) ? "a folder" : "a pipe or a device";
}

std::string read_text_file(const std::string& path, const std::string& what) {
  if (path == "-" || path == standard_input) return read_all(STDIN_FILENO, standard_input, what);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw FileError(fmt::format("{}: expected a {} file, found a directory", path, what), EISDIR);
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail(path, what, errno);
  const FileDescriptor file(descriptor);
  struct stat status {};
  if (::fstat(file.number, &status) == 0 && S_ISFIFO(status.st_mode)) wait_for_writer(file.number, path, what);
  ::fcntl(file.number, F_SETFL, ::fcntl(file.number, F_GETFL) & ~O_NONBLOCK);
  return read_all(file.number, path, what);
}

}  // namespace balance::specification
