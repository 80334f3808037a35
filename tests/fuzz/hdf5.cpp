#include "memory_file.hpp"
#include "targets.hpp"

#include "balance/interface/files/result_file.hpp"

namespace balance::fuzz {

void hdf5(std::string_view bytes) {
  // What does not begin as HDF5 is a table of text.
  if (!bytes.starts_with("\x89HDF")) return;
  const MemoryFile file(bytes);
  try {
    read_result_file(file.path());
  } catch (const SystemError& error) {
    demand(std::string(error.what()).starts_with(file.path()),
           std::string("a complaint without a file: ") + error.what());
  }
  csv(bytes);
}

}  // namespace balance::fuzz
