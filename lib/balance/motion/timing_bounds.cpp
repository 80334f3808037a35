#include "balance/motion/timing_bounds.hpp"

#include <cstdio>
#include <stdexcept>

namespace balance {

std::string format_duration_range() {
  char text[64];
  std::snprintf(text, sizeof text, "a duration from %g s to %g s", min_duration, max_duration);
  return text;
}

namespace {

void check_duration(double duration) {
  if (is_valid_duration(duration)) return;
  char found[40];
  std::snprintf(found, sizeof found, ", found %.6g s", duration);
  throw std::invalid_argument("expected " + format_duration_range() + found);
}

void check_samples(long samples) {
  if (is_valid_sample_count(samples)) return;
  throw std::invalid_argument("expected from " + std::to_string(min_samples) + " to " + std::to_string(max_samples) +
                              " samples, found " + std::to_string(samples));
}

}  // namespace

void check_timing(const Trajectory& trajectory) {
  check_samples(trajectory.samples);
  check_duration(trajectory.duration);
}

void change_duration(Trajectory& trajectory, double duration) {
  check_duration(duration);
  if (trajectory.law.kind == MotionLawKind::time_optimal)
    throw std::invalid_argument("does not go with '" + trajectory.name + "', whose law finds it");
  if (std::holds_alternative<TablePath>(trajectory.path) && !is_mechanism_dependent(trajectory.law.kind))
    throw std::invalid_argument("does not go with '" + trajectory.name + "': its table has its own times");
  trajectory.duration = duration;
}

void change_samples(Trajectory& trajectory, long samples) {
  check_samples(samples);
  trajectory.samples = samples;
}

}  // namespace balance
