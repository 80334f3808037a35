#include "balance/model/spec_units.hpp"

#include <cmath>
#include <cstdio>

namespace balance {

namespace {

std::string in_unit(double value, double unit, double round_off) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::abs(value) <= round_off ? 0 : value / unit);
  return text;
}

}  // namespace

std::string length_text(double value, const SpecUnits& units, double round_off) {
  return in_unit(value, units.length, round_off) + " " + units.length_name;
}

std::string angle_text(double value, const SpecUnits& units, double round_off) {
  return in_unit(value, units.angle, round_off) + " " + units.angle_name;
}

std::string place_text(const double* place, int count, const SpecUnits& units, double round_off) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i == 0 ? "(" : ", ") + in_unit(place[i], units.length, round_off);
  return text + ") " + units.length_name;
}

}  // namespace balance
