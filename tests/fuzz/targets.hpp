#pragma once
/// What is fuzzed: each target takes any bytes and must come back. The same functions run under libFuzzer and, over the kept
/// files, as a plain test.

#include <string>
#include <string_view>

namespace balance::fuzz {

/// A spec; lines `#set name=value` are what `--set` says. What is read is read again with its free numbers at their bounds, and
/// written out as a balanced spec that must be readable.
void spec(std::string_view bytes);
/// A suite.
void suite(std::string_view bytes);
/// A requirement on its first line, an objective on the rest.
void requirement(std::string_view bytes);
/// A table of numbers over time, for a trajectory and for a load.
void csv(std::string_view bytes);
/// A result file, and a table in HDF5.
void hdf5(std::string_view bytes);

/// Foreign files; what is read becomes a spec, which is read unless its numbers are none that a spec can have.
void urdf(std::string_view bytes);
void mjcf(std::string_view bytes);
void mbse(std::string_view bytes);
void chrono(std::string_view bytes);
/// A file of closures for a robot of four links.
void loops(std::string_view bytes);

using Target = void (*)(std::string_view);
/// Null if there is none of that name.
Target find_target(std::string_view name);

/// Ends the process with a message: something that must hold does not.
void demand(bool holds, const std::string& what);

/// Runs `read` and demands that what it complains about comes with a place: file:line:column, or the option it was said in.
/// @return whether it did not complain
template <class Read>
bool complains_well(Read&& read);

}  // namespace balance::fuzz

#include "diagnostic_check.hpp"
