#include "balance/base/rotation.hpp"
#include "balance/motion/leg.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace balance {
namespace {

/// Two waypoints nearer in time than this part of the duration are a mistake.
constexpr double min_fraction_gap = 1e-9;

std::string format_decimal(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text + "0" : text;
}

std::string name_waypoint(std::size_t point, std::size_t points) {
  if (point == 0) return "the start";
  if (point + 1 == points) return "the end";
  return "waypoint " + std::to_string(point);
}

std::vector<double> complete_fractions(const std::vector<double>& fractions, std::size_t waypoints) {
  if (fractions.size() != waypoints) {
    throw std::invalid_argument("there must be one fraction per waypoint: " + std::to_string(waypoints) +
                                " waypoints, " + std::to_string(fractions.size()) + " fractions");
  }
  std::vector<double> all{0};
  all.insert(all.end(), fractions.begin(), fractions.end());
  all.push_back(1);
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i] - all[i - 1] > min_fraction_gap) continue;
    const std::string found = i + 1 == all.size() ? format_decimal(all[i - 1]) + " is the last"
                                                  : format_decimal(all[i]) + " follows " + format_decimal(all[i - 1]);
    throw std::invalid_argument("the fractions of waypoints must increase and lie between 0 and 1; " + found);
  }
  return all;
}

/// Chord lengths by the first measure that sees any motion: position, all scalars, rotation.
std::vector<double> compute_chord_lengths(const std::vector<DriveValue>& points, int position_components, bool turns) {
  const auto measured = [&](auto distance) {
    std::vector<double> lengths;
    for (std::size_t i = 1; i < points.size(); ++i) lengths.push_back(distance(points[i - 1], points[i]));
    return lengths;
  };
  const auto moves = [](const std::vector<double>& lengths) {
    return std::any_of(lengths.begin(), lengths.end(), [](double length) { return length > 0; });
  };
  std::vector<double> lengths = measured([&](const DriveValue& a, const DriveValue& b) {
    return (b.value.head(position_components) - a.value.head(position_components)).norm();
  });
  if (moves(lengths)) return lengths;
  lengths = measured([](const DriveValue& a, const DriveValue& b) { return (b.value - a.value).norm(); });
  if (moves(lengths) || !turns) return lengths;
  return measured([](const DriveValue& a, const DriveValue& b) {
    return rotation_vector_of(b.rotation * a.rotation.transpose()).norm();
  });
}

}  // namespace

std::vector<double> compute_waypoint_fractions(const std::vector<DriveValue>& points,
                                               const std::vector<double>& fractions, int position_components,
                                               bool turns) {
  if (!fractions.empty()) return complete_fractions(fractions, points.size() - 2);
  const std::vector<double> lengths = compute_chord_lengths(points, position_components, turns);
  double total = 0;
  for (const double length : lengths) total += length;
  std::vector<double> all{0};
  double travelled = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (!(lengths[i] > min_fraction_gap * total)) {
      throw std::invalid_argument(name_waypoint(i, points.size()) + " and " + name_waypoint(i + 1, points.size()) +
                                  " are at the same place, so the lengths between the points do not say when they are "
                                  "passed: state the waypoints' fractions of the duration");
    }
    travelled += lengths[i];
    all.push_back(travelled / total);
  }
  all.back() = 1;
  return all;
}

}  // namespace balance
