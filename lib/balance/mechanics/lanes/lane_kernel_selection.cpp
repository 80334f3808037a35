#include "balance/mechanics/lanes/lane_kernels.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace balance::lanes {

extern "C" {
extern const LaneKernels balance_lanes_baseline;
#ifdef BALANCE_LANES_avx2
extern const LaneKernels balance_lanes_avx2;
#endif
#ifdef BALANCE_LANES_avx512
extern const LaneKernels balance_lanes_avx512;
#endif
}

const LaneKernels& lane_kernels(InstructionSet set) {
  const std::vector<InstructionSet> sets = list_instruction_sets();
  if (std::find(sets.begin(), sets.end(), set) == sets.end())
    throw std::invalid_argument(std::string("this machine does not support the instruction set ") +
                                instruction_set_name(set));
#ifdef BALANCE_LANES_avx2
  if (set == InstructionSet::avx2) return balance_lanes_avx2;
#endif
#ifdef BALANCE_LANES_avx512
  if (set == InstructionSet::avx512) return balance_lanes_avx512;
#endif
  return balance_lanes_baseline;
}

}  // namespace balance::lanes
