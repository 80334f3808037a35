#include "balance/interface/files/text_options.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/motion/study/study.hpp"

#include <algorithm>
#include <cstdlib>

namespace balance::files {
namespace {

bool has_newtons(const specification::SpecUnits& units) { return units.force_name.ends_with('N'); }

/// A factor of a unit without its power.
DisplayUnit replace_word(const std::string& word, const specification::SpecUnits& units) {
  if (word == "m") return {units.length_name, units.length};
  if (word == "kg") return {units.mass_name, units.mass};
  if (word == "s") return {units.time_name, units.time};
  if (word == "rad") return {units.angle_name, units.angle};
  if (word == "N") return {units.force_name, units.force};
  if (has_newtons(units)) return {word, 1};
  const DisplayUnit energy{units.force_name + " " + units.length_name, units.force * units.length};
  if (word == "J") return energy;
  if (word == "W") return {energy.name + "/" + units.time_name, energy.factor / units.time};
  return {word, 1};
}

}  // namespace

TextOptions make_text_options(const std::string& spec_text) {
  TextOptions text;
  text.units = specification::read_display_units(spec_text);
  return text;
}

TextOptions make_design_text_options(const Study& study) {
  TextOptions text = make_text_options(study.spec_text);
  text.number_units = specification::list_number_units(study);
  return text;
}

DisplayUnit find_display_unit(const std::string& si_unit, const specification::SpecUnits& units) {
  DisplayUnit unit{"", 1};
  if (si_unit == "1") return unit;
  bool is_divisor = false;
  for (std::size_t at = 0; at < si_unit.size();) {
    const std::size_t end = std::min(si_unit.find_first_of(" /", at), si_unit.size());
    const std::string word = si_unit.substr(at, end - at);
    const std::size_t power = std::min(word.find('^'), word.size());
    const int exponent = power < word.size() ? std::atoi(word.c_str() + power + 1) : 1;
    const DisplayUnit replaced = replace_word(word.substr(0, power), units);
    unit.name += replaced.name + word.substr(power);
    unit.factor *= elementary::pow(replaced.factor, is_divisor ? -exponent : exponent);
    if (end < si_unit.size()) unit.name += si_unit[end];
    if (end < si_unit.size() && si_unit[end] == '/') is_divisor = true;
    at = end + 1;
  }
  return unit;
}

DisplayUnit find_number_unit(const std::string& path, const TextOptions& options) {
  if (!options.number_units) return {};
  const auto found = options.number_units->find(path);
  return found == options.number_units->end() ? DisplayUnit{} : find_display_unit(found->second, options.units);
}

bool has_other_units(const specification::SpecUnits& units) {
  for (const double factor : {units.length, units.angle, units.mass, units.time, units.force})
    if (factor != 1) return true;
  return false;
}

std::string bracket_unit(const DisplayUnit& unit) { return unit.name.empty() ? "" : " [" + unit.name + "]"; }

std::string unit_cell(const DisplayUnit& unit) { return unit.name.empty() ? "1" : unit.name; }

std::string append_unit(const DisplayUnit& unit) { return unit.name.empty() ? "" : " " + unit.name; }

}  // namespace balance::files
