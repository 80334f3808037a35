#pragma once
/// Processor instruction sets for computing in lanes. Every set gives the same bits.

#include <vector>

namespace balance {

enum class InstructionSet {
  baseline,  ///< available on every machine of the architecture; SSE2 on x86-64: two lanes
  avx2,      ///< four lanes
  avx512,    ///< AVX-512 F, DQ, VL: eight lanes
};

const char* instruction_set_name(InstructionSet set);

/// The instruction sets that the library was compiled for and this machine supports, the widest last; never empty.
std::vector<InstructionSet> list_instruction_sets();

}  // namespace balance
