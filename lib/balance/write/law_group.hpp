#pragma once
/// The law of motion of a run in its result file. Private to the writers.

#include "balance/hdf5/file.hpp"
#include "balance/result/result.hpp"

namespace balance {

/// The group `law`, if the law was searched for or limits are stated beside it.
void write_law_group(Hdf5Writer& file, Hdf5Writer::Group parent, const RunResult& result);

}  // namespace balance
