#include "balance/interface/reports/excited_spec.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_edit.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::reports {

using identification::Excitation;
using specification::format_yaml_number;

namespace {

/// Rows of the table per period of the highest harmonic. The second derivative of a cubic spline with the step h misses
/// that of a sine by (ω h)²/12 of its amplitude, here 9e-4; its value by 5/384 (ω h)⁴, 2e-6.
constexpr int table_density = 60;
constexpr const char* line_start = "\n      ";

double unit_of(const Study& study, const specification::SpecUnits& units, CoordinateId coordinate) {
  return is_length_coordinate(study.mechanism, coordinate) ? units.length : units.angle;
}

std::string format_table(const Study& study, const Excitation& excitation) {
  const specification::SpecUnits units = specification::read_display_units(study.spec_text);
  const long rows = static_cast<long>(table_density) * excitation.motion.harmonics() * excitation.periods;
  std::string text, columns;
  for (long k = 0; k <= rows; ++k) {
    const double time = excitation.duration() * static_cast<double>(k) / static_cast<double>(rows);
    const VectorX q = excitation.evaluate(time, 0);
    text += (k == 0 ? "" : ",") + std::string(line_start) + "[" + format_yaml_number(time / units.time);
    for (std::size_t i = 0; i < excitation.coordinates.size(); ++i)
      text +=
          ", " + format_yaml_number(q[static_cast<Eigen::Index>(i)] / unit_of(study, units, excitation.coordinates[i]));
    text += "]";
  }
  for (const CoordinateId c : excitation.coordinates)
    columns += (columns.empty() ? "" : ", ") + specification::quote_yaml(study.mechanism.coordinates[c].name);
  return fmt::format("{{drive: joints, path: {{columns: [{}], table: [{}]}}}}", columns, text);
}

/// Compares what simulate() makes of the text with the series.
void compare(const Study& study, const Excitation& excitation, const std::string& name, ExcitedSpec& spec) {
  const auto fail = [&](const std::string& reason) {
    throw SpecError(
        {.place = {.file = study.spec_file}, .message = "the trajectory cannot be written into this spec: " + reason});
  };
  Study read;
  try {
    read = specification::read_spec(spec.text, study.spec_file);
  } catch (const SpecError& error) {
    fail(error.summary());
  }
  const RunResult run = simulate(read.mechanism, choose_trajectory(read, name));
  if (run.outcome.status != MotionStatus::done) fail(run.outcome.reason);
  const Eigen::Index rows = run.time.size();
  for (std::size_t i = 0; i < excitation.coordinates.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(excitation.coordinates[i]);
    VectorX errors[2], sizes[2];
    for (int k = 0; k < 2; ++k) errors[k].resize(rows), sizes[k].resize(rows);
    for (Eigen::Index s = 0; s < rows; ++s)
      for (int k = 0; k < 2; ++k) {
        const double value = excitation.evaluate(run.time[s], 2 * k)[static_cast<Eigen::Index>(i)];
        errors[k][s] = (k == 0 ? run.joint_position : run.joint_acceleration)(s, column) - value;
        sizes[k][s] = value - (k == 0 ? excitation.coefficients(static_cast<Eigen::Index>(i), 0) : 0);
      }
    const auto relative = [&](int k) { return numerics::max_abs(errors[k]) / numerics::max_abs(sizes[k]); };
    spec.position_error = std::max(spec.position_error, relative(0));
    spec.acceleration_error = std::max(spec.acceleration_error, relative(1));
  }
  spec.effort_error = std::numeric_limits<double>::quiet_NaN();
  if (run.torque.cols() != static_cast<Eigen::Index>(excitation.coordinates.size())) return;
  spec.effort_error = 0;
  double largest = 0;
  for (const identification::ExcitedChannel& channel : excitation.channels) largest = std::max(largest, channel.peak);
  for (Eigen::Index a = 0; a < run.torque.cols(); ++a)
    for (const identification::ExcitedChannel& channel : excitation.channels)
      if (channel.name == run.actuator_names[static_cast<std::size_t>(a)] && channel.peak > 1e-9 * largest)
        spec.effort_error = std::max(
            spec.effort_error, std::abs(numerics::max_abs(VectorX(run.torque.col(a))) - channel.peak) / channel.peak);
}

}  // namespace

ExcitedSpec format_excited_spec(const Study& study, const Excitation& excitation, const std::string& name) {
  ExcitedSpec spec;
  try {
    spec.text = specification::edit_spec(study.spec_text, {{{"trajectories", name}, format_table(study, excitation)}});
  } catch (const specification::SpecEditError& error) {
    throw SpecError({.place = {.file = study.spec_file},
                     .message = std::string("the trajectory cannot be written into this spec: ") + error.what()});
  }
  compare(study, excitation, name, spec);
  return spec;
}

std::string format_excitation_csv(const Study& study, const Excitation& excitation, double step) {
  const specification::SpecUnits units = specification::read_display_units(study.spec_text);
  std::string text = "time", rates;
  for (const CoordinateId c : excitation.coordinates) {
    text += "," + study.mechanism.coordinates[c].name;
    rates += "," + study.mechanism.coordinates[c].name + ".rate";
  }
  text += rates + "\n";
  const long rows = std::lround(excitation.duration() / step);
  for (long k = 0; k <= rows; ++k) {
    const double time = excitation.duration() * static_cast<double>(k) / static_cast<double>(rows);
    text += fmt::format("{:.9g}", time / units.time);
    for (int order = 0; order < 2; ++order) {
      const VectorX values = excitation.evaluate(time, order);
      for (std::size_t i = 0; i < excitation.coordinates.size(); ++i) {
        const double unit = unit_of(study, units, excitation.coordinates[i]) / (order == 0 ? 1 : units.time);
        text += fmt::format(",{:.12g}", values[static_cast<Eigen::Index>(i)] / unit);
      }
    }
    text += "\n";
  }
  return text;
}

}  // namespace balance::reports
