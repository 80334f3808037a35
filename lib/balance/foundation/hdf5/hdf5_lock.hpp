#pragma once
/// Taking turns with HDF5.

#include <mutex>
#include <new>

namespace balance {

/// HDF5 as distributions build it keeps unprotected state for the whole process, so that only one thread may be inside it. Whoever
/// calls it holds a turn meanwhile; a thread that has one may take another. The lock is global because the library's state is.
class Hdf5Lock {
 public:
  Hdf5Lock() : lock_(mutex()) {}

  /// For a child process right after a fork by a thread that had the turn: it is free there. The copied lock knows its owner by a
  /// number that is nobody's in the child, so a new one takes its place.
  static void reset_after_fork() { ::new (static_cast<void*>(&mutex())) std::recursive_mutex; }

 private:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex one;
    return one;
  }
  std::unique_lock<std::recursive_mutex> lock_;
};

}  // namespace balance
