// What libFuzzer calls, for one target.

#include "targets.hpp"

#include <cstddef>
#include <cstdint>
#include <ctime>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // libFuzzer's own limit is of the wall's clock, which runs on while a busy machine does something else.
  const std::clock_t begin = std::clock();
  balance::fuzz::BALANCE_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  balance::fuzz::demand(std::clock() - begin < CLOCKS_PER_SEC, "it took more than a second of the processor's time");
  return 0;
}
