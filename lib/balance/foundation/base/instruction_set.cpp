#include "balance/foundation/base/instruction_set.hpp"

namespace balance {

const char* instruction_set_name(InstructionSet set) {
  switch (set) {
    case InstructionSet::baseline: return "baseline";
    case InstructionSet::avx2: return "avx2";
    case InstructionSet::avx512: return "avx512";
  }
  return "";
}

std::vector<InstructionSet> list_instruction_sets() {
  std::vector<InstructionSet> sets = {InstructionSet::baseline};
#ifdef BALANCE_LANES_avx2
  if (__builtin_cpu_supports("avx2")) sets.push_back(InstructionSet::avx2);
#endif
#ifdef BALANCE_LANES_avx512
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    sets.push_back(InstructionSet::avx512);
#endif
  return sets;
}

}  // namespace balance
