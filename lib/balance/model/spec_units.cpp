#include "balance/model/spec_units.hpp"

#include <cmath>
#include <cstdio>

namespace balance {

namespace {

std::string format_in_unit(double value, double unit, double round_off) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", std::abs(value) <= round_off ? 0 : value / unit);
  return text;
}

}  // namespace

std::string format_length(double value, const DisplayUnits& units, double round_off) {
  return format_in_unit(value, units.length, round_off) + " " + units.length_name;
}

std::string format_angle(double value, const DisplayUnits& units, double round_off) {
  return format_in_unit(value, units.angle, round_off) + " " + units.angle_name;
}

std::string format_position(const double* place, int count, const DisplayUnits& units, double round_off) {
  std::string text;
  for (int i = 0; i < count; ++i) text += (i == 0 ? "(" : ", ") + format_in_unit(place[i], units.length, round_off);
  return text + ") " + units.length_name;
}

}  // namespace balance
