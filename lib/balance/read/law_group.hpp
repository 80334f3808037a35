#pragma once
/// The law of motion of a run from its result file. Private to read.

#include "balance/hdf5/source.hpp"
#include "balance/result/result.hpp"

#include <string>

namespace balance {

/// Fills the found law and the phase plane, as far as the file has them.
/// @param prefix of the run in the file: "" or "after/cycloid/"
/// @throws Hdf5Error if sizes or numbers are not those of a law
void read_law_group(const Hdf5Reader& file, const std::string& prefix, RunResult& result);

}  // namespace balance
