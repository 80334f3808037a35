#pragma once
/// Taking turns with HDF5.

#include <mutex>

namespace balance {

/// HDF5 as distributions build it keeps unprotected state for the whole process, so that only one thread may be inside it. Whoever
/// calls it holds a turn meanwhile; a thread that has one may take another. The lock is global because the library's state is.
class Hdf5Turn {
 public:
  Hdf5Turn() : lock_(mutex()) {}

 private:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex one;
    return one;
  }
  std::unique_lock<std::recursive_mutex> lock_;
};

}  // namespace balance
