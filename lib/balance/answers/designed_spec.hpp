#pragma once
/// The spec of a designed mechanism as it is written.

#include "balance/analysis/design_study.hpp"

#include <string>

namespace balance {

/// balanced_spec with the laws of adapted numbers, and without the elements that the design leaves out; they stay, with masses of zero,
/// where something else in the spec names them.
std::string designed_spec(const DesignSpace& space, const DesignReport& report);

}  // namespace balance
