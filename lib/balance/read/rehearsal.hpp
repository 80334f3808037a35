#pragma once
/// Doing something dangerous in a copy of this process first.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace balance::read {

enum class Rehearsed {
  well,
  complained,  ///< it threw a std::runtime_error
  died,        ///< it crashed, took too long or too much memory
};

struct Rehearsal {
  Rehearsed end = Rehearsed::well;
  std::string message;  ///< of the std::runtime_error
};

/// Runs `work` in a child process that prints nothing and may use a second and 512 MiB, and more for every byte. Where the
/// system has no process left, nothing is rehearsed and all is well.
/// @param work must need no lock that another thread may hold
/// @param bytes size of what `work` reads
Rehearsal rehearse(const std::function<void()>& work, std::uintmax_t bytes);

}  // namespace balance::read
