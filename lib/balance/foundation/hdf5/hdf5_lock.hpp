#pragma once
/// Serialises access to HDF5.

#include <mutex>
#include <new>

namespace balance::hdf5 {

/// HDF5 as distributions build it keeps unprotected process-wide state, so that only one thread may be inside it. A
/// thread that calls it must hold this lock, and may take it again. The lock is global because the library's state is.
class Hdf5Lock {
 public:
  Hdf5Lock() : lock_(mutex()) {}

  /// For a child process right after a fork by a thread that held the lock: releases it there. The copied mutex records
  /// an owner that does not exist in the child, so a new one takes its place.
  static void reset_after_fork() { ::new (static_cast<void*>(&mutex())) std::recursive_mutex; }

 private:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex global_mutex;
    return global_mutex;
  }
  std::unique_lock<std::recursive_mutex> lock_;
};

}  // namespace balance::hdf5
