#pragma once
/// What a case of a batch may use of the machine.

#include <cstdint>
#include <optional>
#include <string>

namespace balance {

struct CaseLimits {
  double wall_seconds = 3600;  ///< by the clock on the wall; 0: no limit
  std::optional<std::uintmax_t>
      memory_bytes;  ///< of memory; nothing: an equal share of the machine's for every job; 0: no limit
};

/// Bytes of memory that this process and its children may have: the machine's, or what its control groups allow; 0 if unknown.
std::uintmax_t available_memory();

/// Bytes that a case may have. @param jobs cases at once, at least one
std::uintmax_t memory_per_case(const CaseLimits& limits, unsigned jobs);

/// "10 s", "512 MiB": as the command line takes them.
std::string format_seconds(double seconds);
std::string format_bytes(std::uintmax_t bytes);

}  // namespace balance
