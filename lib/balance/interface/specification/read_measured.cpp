#include "balance/interface/specification/read_measured.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/measurement_csv.hpp"
#include "balance/interface/specification/spec_table.hpp"
#include "balance/motion/simulation/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace balance::specification {

namespace {

constexpr double max_cutoff = 1e6;  ///< [Hz]
constexpr long max_rows = 1'000'000'000;

std::vector<std::pair<std::string, std::string>> read_columns(const SpecCursor& at) {
  std::vector<std::pair<std::string, std::string>> columns;
  for (const Member& member : list_members(at, "a mapping of names to columns of the file"))
    columns.emplace_back(member.name, member.value.read_word("a column's name or number"));
  return columns;
}

std::pair<long, long> read_rows(const SpecCursor& at, StudyBuilder& draft) {
  const auto ends = at.items("[first row, last row]", 2);
  const std::pair rows{read_integer(ends[0], draft, 1, max_rows), read_integer(ends[1], draft, 1, max_rows)};
  if (!(rows.first < rows.second))
    at.fail({.expected = "a first row before the last", .found = fmt::format("{} and {}", rows.first, rows.second)});
  return rows;
}

/// In the spec's unit.
std::pair<double, double> read_times(const SpecCursor& at, StudyBuilder& draft) {
  const auto ends = at.items("[first time, last time]", 2);
  const std::pair times{read_number(ends[0], draft, dimension::dimensionless).value(),
                        read_number(ends[1], draft, dimension::dimensionless).value()};
  if (!(times.first < times.second))
    at.fail({.expected = "a first time before the last", .found = fmt::format("{} and {}", times.first, times.second)});
  return times;
}

double read_cutoff(const SpecCursor& at, StudyBuilder& draft) {
  const double cutoff = read_number(at, draft, dimension::dimensionless, SignConstraint::positive).value();
  if (!(cutoff <= max_cutoff))
    at.fail({.expected = fmt::format("a frequency in Hz of at most {:g}", max_cutoff),
             .found = fmt::format("{:g}", cutoff)});
  return cutoff;
}

/// Those of the actuators, unless others are named.
std::vector<CoordinateId> choose_coordinates(const std::optional<SpecCursor>& names, const SpecCursor& at,
                                             const StudyBuilder& draft) {
  std::vector<CoordinateId> coordinates;
  if (names) {
    read_each(names->items("a list of joint coordinates"), [&](const SpecCursor& item) {
      const CoordinateId coordinate = read_coordinate(item, draft);
      if (std::find(coordinates.begin(), coordinates.end(), coordinate) != coordinates.end())
        item.fail({.expected = "each coordinate only once", .found = item.describe_found() + " again"});
      coordinates.push_back(coordinate);
    });
  } else {
    coordinates.assign(draft.mechanism().actuators.begin(), draft.mechanism().actuators.end());
  }
  if (coordinates.empty()) at.fail_missing({"coordinates"});
  std::sort(coordinates.begin(), coordinates.end());
  return coordinates;
}

void assign(simulation::MeasuredMotion motion, const std::vector<CoordinateId>& coordinates, StudyBuilder& draft,
            TrajectoryOf<Expression>& trajectory) {
  trajectory::TablePathOf<Expression> table;
  const auto pose_at = [&](Eigen::Index row) {
    trajectory::PoseTargetOf<Expression> pose;
    for (std::size_t c = 0; c < coordinates.size(); ++c)
      pose.joints.push_back({coordinates[c], motion.position(row, static_cast<Eigen::Index>(c))});
    return pose;
  };
  for (Eigen::Index row = 0; row < motion.position.rows(); ++row) {
    table.time.emplace_back(motion.time[static_cast<std::size_t>(row)]);
    table.values.emplace_back(motion.position.row(row).begin(), motion.position.row(row).end());
  }
  trajectory.from = pose_at(0);
  trajectory.to = pose_at(motion.position.rows() - 1);
  trajectory.duration = motion.time.back() - motion.time.front();
  trajectory.samples = static_cast<long>(motion.position.rows());
  trajectory.path = std::move(table);
  motion.measured.trajectory = trajectory.name;
  draft.study.measured.push_back(std::move(motion.measured));
}

}  // namespace

void read_measured(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  std::optional<SpecCursor> file, names;
  RecordOptions options{.prefix = ""};
  double cutoff = 0;
  trajectory.drive = DriveKind::joints;
  const bool is_read =
      read_fields(at, "a record {file: log.csv}",
                  {{"file", Presence::required, [&](const SpecCursor& c) { file = c; }},
                   {"columns", Presence::optional, [&](const SpecCursor& c) { options.columns = read_columns(c); }},
                   {"rows", Presence::optional, [&](const SpecCursor& c) { options.rows = read_rows(c, draft); }},
                   {"time", Presence::optional, [&](const SpecCursor& c) { options.time = read_times(c, draft); }},
                   {"cutoff", Presence::optional, [&](const SpecCursor& c) { cutoff = read_cutoff(c, draft); }},
                   {"coordinates", Presence::optional, [&](const SpecCursor& c) { names = c; }}});
  if (!is_read || !draft.is_mechanism_valid) throw CascadingError();
  const std::vector<CoordinateId> coordinates = choose_coordinates(names, at, draft);
  const std::string path = find_table_file(*file, draft);
  const auto fail = [&](const std::string& reason) {
    file->fail({.message = reason,
                .expected = "a record of this mechanism's motion",
                .found = quote_for_message(path),
                .hint = reason});
  };
  try {
    MeasurementRecord record = read_measurement_csv(path, draft.study.mechanism, draft.units, options);
    simulation::convert_currents(record, draft.study.mechanism, draft.study.current_gains);
    record.source = escape_for_terminal(std::filesystem::path(path).filename().string());  // wherever it is stored
    assign(simulation::smooth_record(record, draft.study.mechanism, coordinates, cutoff), coordinates, draft,
           trajectory);
  } catch (const SystemError& error) {
    fail(error.what());
  } catch (const std::invalid_argument& error) {
    fail(escape_for_terminal(path) + ": " + error.what());
  }
}

}  // namespace balance::specification
