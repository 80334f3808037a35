#include "balance/interface/specification/spec_units.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

namespace balance::specification {

namespace {

struct NamedUnit {
  const char* name;
  double value;
};

/// Reads the name of a unit and sets its SI value and its name.
void read_unit(const SpecCursor& at, const std::string& what, std::span<const NamedUnit> units, double& value,
               std::string& name) {
  std::vector<std::string> names;
  for (const NamedUnit& one : units) names.emplace_back(one.name);
  const NamedUnit& unit = units[at.read_choice("a unit of " + what, names)];
  value = unit.value, name = unit.name;
}

constexpr NamedUnit length_units[]{{"m", 1},     {"dm", 0.1}, {"cm", 0.01},   {"mm", 1e-3},
                                   {"um", 1e-6}, {"km", 1e3}, {"in", 0.0254}, {"ft", 0.3048}};
constexpr NamedUnit mass_units[]{{"kg", 1},
                                 {"g", 1e-3},
                                 {"mg", 1e-6},
                                 {"t", 1e3},
                                 {"lb", 0.45359237},
                                 {"oz", 0.028349523125},
                                 {"slug", 14.593902937206364}};
constexpr NamedUnit time_units[]{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}};
constexpr NamedUnit angle_units[]{
    {"rad", 1}, {"mrad", 1e-3}, {"deg", std::numbers::pi / 180}, {"turn", 2 * std::numbers::pi}};
constexpr NamedUnit pound_force{"lbf", 4.4482216152605};
constexpr NamedUnit force_units[]{{"N", 1}, {"mN", 1e-3}, {"kN", 1e3}, {"kgf", 9.80665}, pound_force};

/// Inches and feet go with pounds: the forces of such a spec are displayed in lbf unless it names another unit.
bool is_imperial(const std::string& length) { return length == "in" || length == "ft"; }

/// Units that a spec does not choose but that numbers are printed in.
struct DerivedUnit : NamedUnit {
  Dimension dimension;
};
constexpr Dimension newton = dimension::mass * dimension::acceleration;
constexpr Dimension joule = newton * dimension::length;
constexpr DerivedUnit derived_units[]{{{"J", 1}, joule},
                                      {{"kJ", 1e3}, joule},
                                      {{"W", 1}, joule / dimension::time},
                                      {{"kW", 1e3}, joule / dimension::time},
                                      {{"Hz", 1}, dimension::dimensionless / dimension::time},
                                      {{"1", 1}, dimension::dimensionless},
                                      {{"%", 0.01}, dimension::dimensionless},
                                      {{"rpm", 2 * std::numbers::pi / 60}, dimension::angle / dimension::time}};

std::vector<DerivedUnit> list_units() {
  std::vector<DerivedUnit> units(std::begin(derived_units), std::end(derived_units));
  const std::pair<std::span<const NamedUnit>, Dimension> base_units[]{{length_units, dimension::length},
                                                                      {mass_units, dimension::mass},
                                                                      {time_units, dimension::time},
                                                                      {angle_units, dimension::angle},
                                                                      {force_units, newton}};
  for (const auto& [named_units, dimension] : base_units)
    for (const NamedUnit& unit : named_units) units.push_back({unit, dimension});
  return units;
}

/// Calls `fail` with an ErrorMessage for a text that is not a product of units; it does not return.
template <class Fail>
UnitProduct parse_unit_product(const std::string& text, const ErrorMessage& not_a_unit, const Fail& fail) {
  const std::vector<DerivedUnit> units = list_units();
  UnitProduct product;
  bool divides = false, is_empty = true;
  std::size_t i = 0;
  while (i < text.size()) {
    if (text[i] == ' ' || text[i] == '*') {
      ++i;
    } else if (text[i] == '/') {
      if (is_empty) fail(not_a_unit);
      divides = true, is_empty = true;
      ++i;
    } else {
      const std::size_t end = std::min(text.find_first_of(" */", i), text.size());
      const std::string factor = text.substr(i, end - i);
      const std::size_t power_mark = std::min(factor.find('^'), factor.size());
      const std::string name = factor.substr(0, power_mark);
      const auto unit =
          std::find_if(units.begin(), units.end(), [&](const DerivedUnit& one) { return name == one.name; });
      if (unit == units.end()) {
        std::vector<std::string> names;
        for (const DerivedUnit& one : units) names.emplace_back(one.name);
        fail({.expected = not_a_unit.expected,
              .found = quote_for_message(name),
              .hint = format_nearest_name(name, names)});
      }
      int power = 1;
      if (power_mark < factor.size()) {
        const char* const last = factor.data() + factor.size();
        const auto [rest, error] = std::from_chars(factor.data() + power_mark + 1, last, power);
        if (error != std::errc() || rest != last || std::abs(power) > 9)
          fail({.expected = "a power such as ^2", .found = quote_for_message(factor)});
      }
      if (divides) power = -power;
      product.value *= elementary::pow(unit->value, power);
      for (int k = 0; k < std::abs(power); ++k)
        product.dimension = power > 0 ? product.dimension * unit->dimension : product.dimension / unit->dimension;
      is_empty = false;
      i = end;
    }
  }
  if (is_empty) fail(not_a_unit);
  return product;
}

}  // namespace

UnitProduct read_unit_product(const SpecCursor& cursor) {
  const std::string expectation = "a unit such as m/s, N mm, deg/s^2 or %";
  const std::string& text = cursor.read_word(expectation);
  return parse_unit_product(text, {.expected = expectation, .found = quote_for_message(text)},
                            [&](const ErrorMessage& message) { cursor.fail(message); });
}

std::optional<UnitProduct> parse_unit_product(const std::string& text) {
  struct NotAUnit {};
  try {
    return parse_unit_product(text, {}, [](const ErrorMessage&) { throw NotAUnit(); });
  } catch (const NotAUnit&) {
    return std::nullopt;
  }
}

Dimension dimension_of_unit(const std::string& unit) {
  using namespace dimension;
  const std::pair<const char*, Dimension> unit_dimensions[] = {
      {"N", force}, {"N m", moment}, {"J", moment},       {"W", moment / time}, {"m", length},
      {"kg", mass}, {"s", time},     {"kg m^2", inertia}, {"rad", angle}};
  const std::size_t slash = unit.find('/');
  for (const auto& [name, dimension] : unit_dimensions)
    if (unit.substr(0, slash) == name) {
      if (slash == std::string::npos) return dimension;
      return unit.ends_with("^2") ? dimension / (time * time) : dimension / time;
    }
  return dimensionless;
}

std::string unit_of_dimension(Dimension dimension) {
  std::string above, below;
  for (const auto& [name, exponent] :
       {std::pair("N", dimension.force), std::pair("kg", dimension.mass), std::pair("m", dimension.length),
        std::pair("s", dimension.time), std::pair("rad", dimension.angle)}) {
    if (exponent == 0) continue;
    std::string& side = exponent > 0 ? above : below;
    side += (side.empty() ? "" : " ") + std::string(name);
    if (std::abs(exponent) > 1) side += "^" + std::to_string(std::abs(exponent));
  }
  return (above.empty() ? "1" : above) + (below.empty() ? "" : "/" + below);
}

double Units::factor(Dimension d) const {
  const double newton = stated_force.value_or(mass * length / (time * time));
  return elementary::pow(length, d.length) * elementary::pow(mass, d.mass) * elementary::pow(time, d.time) *
         elementary::pow(angle, d.angle) * elementary::pow(newton, d.force);
}

Units read_units(const SpecCursor& section) {
  Units units;
  const auto read_force = [&units](const SpecCursor& c) {
    read_unit(c, "force", force_units, units.force, units.force_name);
    units.stated_force = units.force;
  };
  const auto reader = [](const char* what, std::span<const NamedUnit> named_units, double& value, std::string& name) {
    return [what, named_units, &value, &name](const SpecCursor& c) { read_unit(c, what, named_units, value, name); };
  };
  read_fields(section, "a mapping of units",
              {{"length", Presence::optional, reader("length", length_units, units.length, units.length_name)},
               {"mass", Presence::optional, reader("mass", mass_units, units.mass, units.mass_name)},
               {"time", Presence::optional, reader("time", time_units, units.time, units.time_name)},
               {"angle", Presence::optional, reader("angle", angle_units, units.angle, units.angle_name)},
               {"force", Presence::optional, read_force}});
  if (!units.stated_force && is_imperial(units.length_name)) {
    units.force = pound_force.value, units.force_name = pound_force.name;
  }
  return units;
}

}  // namespace balance::specification
