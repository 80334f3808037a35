#pragma once
/// Bytes as a file that needs no disk.

#include <string>
#include <string_view>

namespace balance::fuzz {

class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  /// Where this process finds it.
  std::string path() const;

 private:
  int descriptor_;
};

}  // namespace balance::fuzz
