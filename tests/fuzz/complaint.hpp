#pragma once
/// Judges complaints; a part of targets.hpp.

#include "balance/base/error.hpp"

namespace balance::fuzz {

/// `s.yaml:3:14: …` or `--set l=…`.
bool names_a_place(const std::string& message);

template <class Read>
bool complains_well(Read&& read) {
  try {
    read();
    return true;
  } catch (const SpecError& error) {
    demand(names_a_place(error.what()), std::string("a complaint without a place: ") + error.what());
  }
  return false;
}

}  // namespace balance::fuzz
