#pragma once
/// Judges complaints; a part of targets.hpp.

#include "balance/foundation/base/error.hpp"

namespace balance::fuzz {

/// `s.yaml:3:14` or `--set l`.
bool names_a_place(const SourceLocation& place);

template <class Read>
bool complains_well(Read&& read) {
  try {
    read();
    return true;
  } catch (const SpecError& error) {
    for (const Diagnostic& mistake : error.diagnostics()) {
      demand(names_a_place(mistake.place), "a complaint without a place: " + mistake.text());
      demand(!mistake.message.empty(), "a complaint that says nothing: " + mistake.text());
    }
  }
  return false;
}

}  // namespace balance::fuzz
