#pragma once
/// Which of the processor's instruction sets the lanes are computed with. Every set gives the same bits.

#include <vector>

namespace balance {

enum class InstructionSet {
  baseline,  ///< what every machine of the architecture has; on x86-64 SSE2, two lanes
  avx2,      ///< four lanes
  avx512,    ///< AVX-512 F, DQ, VL: eight lanes
};

const char* instruction_set_name(InstructionSet set);

/// Those that the library was compiled for and this machine has, the widest last; never empty.
std::vector<InstructionSet> list_instruction_sets();

}  // namespace balance
