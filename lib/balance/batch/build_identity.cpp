#include "balance/batch/build_identity.hpp"

#include "balance/base/error.hpp"
#include "balance/write/sha256.hpp"

#include <link.h>

#include <cstdint>

namespace balance {
namespace {

struct LoadedObjectSearch {
  std::uintptr_t address;
  std::string file;
};

/// Told of every loaded object in turn; the program itself has no name.
int take_if_it_holds(dl_phdr_info* object, std::size_t /*size*/, void* data) {
  auto& search = *static_cast<LoadedObjectSearch*>(data);
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& segment = object->dlpi_phdr[i];
    const std::uintptr_t begin = object->dlpi_addr + segment.p_vaddr;
    if (segment.p_type != PT_LOAD || search.address < begin || search.address >= begin + segment.p_memsz) continue;
    const std::string name = object->dlpi_name;
    search.file = name.empty() ? "/proc/self/exe" : name;
    return 1;
  }
  return 0;
}

}  // namespace

std::string hash_build() {
  LoadedObjectSearch search{reinterpret_cast<std::uintptr_t>(&hash_build), ""};
  dl_iterate_phdr(take_if_it_holds, &search);
  std::string digits = sha256_of_file(search.file);
  if (digits.empty()) throw SystemError("cannot read the program itself, to tell which build it is: " + search.file);
  return digits;
}

}  // namespace balance
