#include "balance/interface/files/record_reader.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/result_file.hpp"

#include <algorithm>
#include <vector>

namespace balance::files {

namespace {

/// The positions, efforts and forces on the frame of a run.
MeasurementRecord read_run_record(const std::string& path, const Mechanism& mechanism,
                                  const specification::SpecUnits& units, const specification::RecordOptions& options) {
  using Kind = MeasuredSignal::Kind;
  const StoredRun run = read_motion_file(path);
  const RunResult& result = run.result;
  if (!options.columns.empty()) throw SystemError(path + ": is a result of balance: --columns is for CSV files");
  MeasurementRecord record{
      .source = escape_for_terminal(path), .time = {}, .signals = {}, .values = {}, .payloads = {}, .notes = {}};
  std::vector<VectorX> columns;
  const auto add = [&](MeasuredSignal signal, const VectorX& values) {
    record.signals.push_back(signal);
    columns.push_back(values);
  };
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
    const auto match =
        std::find(result.coordinate_names.begin(), result.coordinate_names.end(), mechanism.coordinates[c].name);
    if (match != result.coordinate_names.end())
      add({Kind::position, static_cast<int>(c)}, result.joint_position.col(match - result.coordinate_names.begin()));
  }
  for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
    const std::string& name = mechanism.coordinates[static_cast<std::size_t>(mechanism.actuators[a])].name;
    const auto match = std::find(result.actuator_names.begin(), result.actuator_names.end(), name);
    if (match != result.actuator_names.end())
      add({Kind::effort, static_cast<int>(a)}, result.torque.col(match - result.actuator_names.begin()));
  }
  if (columns.empty()) throw SystemError(path + ": is a run of another mechanism: it has none of its coordinates");
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < result.time.size(); ++k) {
    const bool is_row = !options.rows || (k + 1 >= options.rows->first && k + 1 <= options.rows->second);
    const bool is_time = !options.time || (result.time[k] >= options.time->first * units.time &&
                                           result.time[k] <= options.time->second * units.time);
    if (is_row && is_time && (rows.empty() || result.time[k] > result.time[rows.back()])) rows.push_back(k);
  }
  if (rows.size() < 2) throw SystemError(path + ": expected rows of numbers, found none");
  record.time.resize(static_cast<Eigen::Index>(rows.size()));
  record.values.resize(record.time.size(), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index k = 0; k < record.time.size(); ++k) {
    record.time[k] = result.time[rows[static_cast<std::size_t>(k)]];
    for (std::size_t c = 0; c < columns.size(); ++c)
      record.values(k, static_cast<Eigen::Index>(c)) = columns[c][rows[static_cast<std::size_t>(k)]];
  }
  return record;
}

}  // namespace

MeasurementRecord read_record_file(const std::string& path, const Mechanism& mechanism,
                                   const specification::SpecUnits& units, const specification::RecordOptions& options) {
  if (names_result_file(path)) return read_run_record(path, mechanism, units, options);
  return specification::read_measurement_csv(path, mechanism, units, options);
}

}  // namespace balance::files
