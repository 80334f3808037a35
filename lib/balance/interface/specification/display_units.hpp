#pragma once
/// Units in which the answers about a spec are displayed.

#include "balance/mechanics/model/mechanism.hpp"

#include <map>
#include <string>

namespace balance::study {
struct Study;
}

namespace balance::specification {

/// Units of a spec: those that the mechanism has for messages, and the others, as SI values and names. A force has a
/// unit of its own, which need not be that of forces in the spec.
struct SpecUnits : model::DisplayUnits {
  double mass = 1;   ///< [kg]
  double time = 1;   ///< [s]
  double force = 1;  ///< [N]
  std::string mass_name = "kg", time_name = "s", force_name = "N";
};

/// Units of the spec's text, also of one that a result file holds; SI if it has none or cannot be read.
SpecUnits read_display_units(const std::string& spec_text);

/// SI unit, "kg" or "N/m", of every number that is free or that loads or tolerances name, by its key path;
/// "1" without unit. Parameters, which have no unit of their own, are missing.
using NumberUnits = std::map<std::string, std::string>;

/// Reads the study's text again.
NumberUnits list_number_units(const study::Study& study);

}  // namespace balance::specification
