#include "balance/motion/simulation/prediction.hpp"

#include "balance/mechanics/results/metrics.hpp"
#include "balance/motion/simulation/signal_processing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace balance::simulation {

namespace {

/// Fewer rows than this have no spline and no figures.
constexpr Eigen::Index min_rows = 4;
/// Above this part of the sampling rate a run's samples cannot be low-passed.
constexpr double max_cutoff_fraction = 0.49;

std::string format_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string name_of_coordinate(const Mechanism& mechanism, CoordinateId coordinate) {
  return mechanism.coordinates[static_cast<std::size_t>(coordinate)].name;
}

/// @returns the columns of the efforts in the order of the actuators; empty if none was measured
std::vector<int> find_effort_columns(const MeasurementRecord& record, const Mechanism& mechanism) {
  std::vector<int> columns;
  std::vector<std::string> missing;
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    const int column = find_signal(record, {MeasuredSignal::Kind::effort, static_cast<int>(a)});
    if (column >= 0)
      columns.push_back(column);
    else
      missing.push_back(name_of_coordinate(mechanism, mechanism.actuators[a]));
  }
  if (!columns.empty() && !missing.empty())
    throw std::invalid_argument("expected the efforts of all actuators, or currents and their gains, or of none; '" +
                                missing.front() + ".effort' is missing");
  return columns;
}

MatrixX columns_of(const MatrixX& values, const std::vector<int>& columns) {
  MatrixX chosen(values.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) chosen.col(static_cast<Eigen::Index>(c)) = values.col(columns[c]);
  return chosen;
}

}  // namespace

void convert_currents(MeasurementRecord& record, const Mechanism& mechanism,
                      const std::vector<std::pair<CoordinateId, double>>& gains) {
  for (std::size_t s = 0; s < record.signals.size(); ++s) {
    MeasuredSignal& signal = record.signals[s];
    if (signal.kind != MeasuredSignal::Kind::current) continue;
    const MeasuredSignal effort{MeasuredSignal::Kind::effort, signal.index};
    const CoordinateId coordinate = mechanism.actuators[static_cast<std::size_t>(signal.index)];
    const auto gain =
        std::find_if(gains.begin(), gains.end(), [&](const auto& one) { return one.first == coordinate; });
    if (gain == gains.end() || find_signal(record, effort) >= 0) continue;
    record.values.col(static_cast<Eigen::Index>(s)) *= gain->second;
    signal = effort;
  }
}

MeasuredMotion smooth_record(const MeasurementRecord& record, const Mechanism& mechanism,
                             const std::vector<CoordinateId>& coordinates, double cutoff) {
  std::vector<int> position_columns;
  for (const CoordinateId coordinate : coordinates) {
    position_columns.push_back(find_signal(record, {MeasuredSignal::Kind::position, coordinate}));
    if (position_columns.back() < 0)
      throw std::invalid_argument("expected a column '" + name_of_coordinate(mechanism, coordinate) +
                                  "', which the motion follows");
  }
  const std::vector<int> effort_columns = find_effort_columns(record, mechanism);
  std::vector<std::string> cuts;
  const std::vector<UniformPiece> pieces = resample(record, cuts);
  if (pieces.empty()) throw std::invalid_argument("too few rows to differentiate");
  if (!cuts.empty())
    throw std::invalid_argument("expected a record without gaps, but it is " +
                                cuts.front().substr(record.source.size() + 2) + "; 'time' or 'rows' chooses a part");
  const UniformPiece& piece = pieces.front();
  MatrixX position = columns_of(piece.values, position_columns), effort = columns_of(piece.values, effort_columns);
  MeasuredMotion motion;
  motion.measured.notes = record.notes;
  motion.measured.step = piece.step;
  motion.measured.cutoff = cutoff > 0 ? cutoff : find_cutoff({position}, {piece.step}, motion.measured.notes);
  if (!(motion.measured.cutoff > 0)) throw std::invalid_argument("no joint moves in this record");
  if (!(motion.measured.cutoff * piece.step < max_cutoff_fraction))
    throw std::invalid_argument("expected a cut-off below half of the " + format_number(1 / piece.step) +
                                " rows a second, found " + format_number(motion.measured.cutoff) + " Hz");
  const Eigen::Index edge = count_edge_samples(motion.measured.cutoff, piece.step), rows = position.rows() - 2 * edge;
  if (rows < min_rows)
    throw std::invalid_argument(
        "the record of " + format_number(piece.step * static_cast<double>(position.rows() - 1)) +
        " s is shorter than its filter at " + format_number(motion.measured.cutoff) + " Hz needs");
  ZeroPhaseFilter(position_cutoff_ratio * motion.measured.cutoff, piece.step).apply(position);
  ZeroPhaseFilter(motion.measured.cutoff, piece.step).apply(effort);
  for (Eigen::Index k = edge; k < edge + rows; ++k) motion.time.push_back(piece.time(k));
  motion.position = position.middleRows(edge, rows);
  if (!effort_columns.empty()) motion.measured.effort = effort.middleRows(edge, rows);
  motion.measured.notes.push_back("follows " + record.source + " from " + format_number(motion.time.front()) + " to " +
                                  format_number(motion.time.back()) + " s, low-passed at " +
                                  format_number(motion.measured.cutoff) + " Hz; " + std::to_string(edge) +
                                  " rows at each end are left out");
  return motion;
}

namespace {

/// Rows between those of the record, linearly.
Samples interpolate(const Samples& rows, double step, const VectorX& times, double start) {
  Samples values(times.size(), rows.cols());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    const double place = std::clamp((times[k] - start) / step, 0.0, static_cast<double>(rows.rows() - 1));
    const auto before = std::min(static_cast<Eigen::Index>(place), rows.rows() - 2);
    const double weight = place - static_cast<double>(before);
    values.row(k) = (1 - weight) * rows.row(before) + weight * rows.row(before + 1);
  }
  return values;
}

}  // namespace

void add_measured_efforts(const Study& study, const Trajectory& trajectory, RunResult& result) {
  const auto match = std::find_if(study.measured.begin(), study.measured.end(),
                                  [&](const study::MeasuredEfforts& one) { return one.trajectory == trajectory.name; });
  if (match == study.measured.end() || result.outcome.status != MotionStatus::done || result.time.size() < 2) return;
  result.outcome.notes.insert(result.outcome.notes.begin(), match->notes.begin(), match->notes.end());
  if (match->effort.size() == 0) return;
  const double start = result.time[0],
               step = (result.time[result.time.size() - 1] - start) / static_cast<double>(result.time.size() - 1);
  if (!(match->cutoff * step < max_cutoff_fraction)) {
    result.outcome.notes.push_back("no measured torques: samples every " + format_number(step) +
                                   " s are too few for torques low-passed at " + format_number(match->cutoff) + " Hz");
    return;
  }
  MatrixX computed = result.torque;
  ZeroPhaseFilter(match->cutoff, step).apply(computed);
  const Samples low_passed = computed;
  const auto add = [&](RunResult& rows, const VectorX& times) {
    rows.torque_measured = interpolate(match->effort, match->step, times, start);
    rows.torque_residual = rows.torque_measured - interpolate(low_passed, step, times, start);
  };
  add(result, result.time);
  results::IntermediateSamples between;
  if (result.intermediate) between = *result.intermediate;
  if (const auto rows = static_cast<Eigen::Index>(between.next_sample.size()); rows > 0)
    add(between.rows, between.rows.time.head(rows));
  add_metrics(result, between);
  result.intermediate = std::make_shared<const results::IntermediateSamples>(std::move(between));
}

RunResult simulate(const Study& study, const Trajectory& trajectory, const Progress& progress) {
  RunResult result = simulate(study.mechanism, trajectory, progress);
  add_measured_efforts(study, trajectory, result);
  return result;
}

}  // namespace balance::simulation
