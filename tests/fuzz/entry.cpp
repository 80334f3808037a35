// What libFuzzer calls, for one target.

#include "targets.hpp"

#include <cstddef>
#include <cstdint>
#include <ctime>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // libFuzzer's own limit is of the wall's clock, which runs on while a busy machine does something else. What it adds to every
  // comparison of texts takes ten times as long as the readers themselves, whose second is asked of the plain build (replay.cpp).
  constexpr std::clock_t limit = 10 * CLOCKS_PER_SEC;
  const std::clock_t begin = std::clock();
  balance::fuzz::BALANCE_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  balance::fuzz::demand(std::clock() - begin < limit, "it took more than ten seconds of the processor's time");
  return 0;
}
