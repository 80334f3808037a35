#pragma once
/// How text for people is written: units, width, detail.

#include "balance/interface/files/text_table.hpp"
#include "balance/interface/specification/display_units.hpp"

#include <cstddef>
#include <optional>
#include <string>

namespace balance::files {

/// Text and tables of one spec. Files for programs (JSON, HDF5, CSV) are always SI.
struct TextOptions {
  specification::SpecUnits units;          ///< SI unless those of the spec are wanted
  std::size_t width = default_text_width;  ///< columns that no line exceeds, unless a word is longer
  std::optional<specification::NumberUnits> number_units = {};  ///< of the spec's numbers; none: tables of these are SI
  bool verbose = false;                                         ///< also lines that say that there is nothing
};

/// In the units of the spec.
TextOptions make_text_options(const std::string& spec_text);

/// In the units of the spec, numbers in tables, too. Reads the study's text again.
TextOptions make_design_text_options(const study::Study& study);

/// The unit in which a quantity is displayed.
struct DisplayUnit {
  std::string name;   ///< "N mm"; "" without a unit
  double factor = 1;  ///< SI value of the number one in this unit

  /// @param value [SI]
  double convert(double value) const { return value / factor; }
};

/// The unit that takes the place of an SI unit: each factor of "N m", "rad/s", "kg m^2" or "N m s/rad" is replaced by
/// the preferred unit of its dimension: "lbf in", "deg/s", "g mm^2". J and W remain where forces are in newtons (N, mN,
/// kN) and become force · length, per time, elsewhere. Other words remain.
/// @param si_unit of a quantity, as in results; "1" and "" are the same
DisplayUnit find_display_unit(const std::string& si_unit, const specification::SpecUnits& units);

/// The unit in which a number of the spec is displayed; none for parameters, which are as written.
/// @param path of the number in the spec
DisplayUnit find_number_unit(const std::string& path, const TextOptions& options);

/// Whether a unit differs from SI.
bool has_other_units(const specification::SpecUnits& units);

/// " [mm]" for a heading or a label; "" for a number without unit.
std::string bracket_unit(const DisplayUnit& unit);

/// "mm" in a table whose rows have a unit each; "1" for a number without unit.
std::string unit_cell(const DisplayUnit& unit);

/// " mm" after a number; "" for a number without unit.
std::string append_unit(const DisplayUnit& unit);

}  // namespace balance::files
