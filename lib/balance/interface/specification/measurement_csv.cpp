#include "balance/interface/specification/measurement_csv.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/file_error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <string_view>

namespace balance::specification {

namespace {

constexpr std::size_t max_record_bytes = std::size_t{1} << 30;
constexpr std::size_t max_listed_faults = 5;
/// Larger magnitudes are no measurement, in SI; nor are those beyond this multiple of the column's 99th percentile.
constexpr double max_plausible_value = 1e9, max_percentile_ratio = 1e6;
/// Times may count from 1970, in seconds.
constexpr double max_time = 1e11;
/// Between two rows an angle jumps by a full turn if it changes by more than this part of one.
constexpr double turn_fraction = 0.75;

/// A column that a record may have.
struct ColumnMeaning {
  MeasuredSignal signal;
  bool is_time = false;
  std::string si_unit;
  double spec_unit = 1;  ///< SI value of the spec's unit
};

class ColumnNames {
 public:
  ColumnNames(const Mechanism& mechanism, const SpecUnits& units) {
    using Kind = MeasuredSignal::Kind;
    add("time", {{}, true, "s", units.time});
    for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
      const int index = static_cast<int>(c);
      const std::string& name = mechanism.coordinates[c].name;
      const bool is_length = is_length_coordinate(mechanism, index);
      const double unit = is_length ? units.length : units.angle;
      add(name, {{Kind::position, index}, false, is_length ? "m" : "rad", unit});
      add(name + ".position", {{Kind::position, index}, false, is_length ? "m" : "rad", unit}, true);
      add(name + ".rate", {{Kind::rate, index}, false, is_length ? "m/s" : "rad/s", unit / units.time});
      add(name + ".velocity", {{Kind::rate, index}, false, is_length ? "m/s" : "rad/s", unit / units.time}, true);
    }
    for (std::size_t a = 0; a < mechanism.actuators.size(); ++a) {
      const int index = static_cast<int>(a);
      const CoordinateId c = mechanism.actuators[a];
      const std::string& name = mechanism.coordinates[static_cast<std::size_t>(c)].name;
      const bool is_length = is_length_coordinate(mechanism, c);
      const ColumnMeaning effort{
          {Kind::effort, index}, false, is_length ? "N" : "N m", is_length ? units.force : units.force * units.length};
      add(name + ".effort", effort);
      for (const std::string& other : {name + ".torque", name + ".force", "tau_" + name, "torque[" + name + "]"})
        add(other, effort, true);
      add(name + ".current", {{Kind::current, index}, false, "A", 1});
    }
    const bool is_planar = mechanism.space == SpaceKind::planar;
    const std::vector<std::string> frame = is_planar ? std::vector<std::string>{"fx", "fy", "m"}
                                                     : std::vector<std::string>{"fx", "fy", "fz", "mx", "my", "mz"};
    for (std::size_t k = 0; k < frame.size(); ++k) {
      const bool is_force = k < (is_planar ? 2U : 3U);
      add(frame[k], {{Kind::frame, static_cast<int>(k)},
                     false,
                     is_force ? "N" : "N m",
                     is_force ? units.force : units.force * units.length});
    }
  }

  const ColumnMeaning* find(const std::string& name) const {
    const auto match = meanings_.find(name);
    return match == meanings_.end() ? nullptr : &match->second;
  }
  const std::vector<std::string>& names() const { return names_; }

 private:
  /// Coordinates that are named like components of the frame's force keep their name.
  void add(const std::string& name, const ColumnMeaning& meaning, bool is_synonym = false) {
    if (meanings_.emplace(name, meaning).second && !is_synonym) names_.push_back(name);
  }

  std::map<std::string, ColumnMeaning> meanings_;
  std::vector<std::string> names_;
};

/// A column of the file that is read.
struct ChosenColumn {
  std::size_t field = 0;
  std::string name;  ///< as in the file
  ColumnMeaning meaning;
  double unit = 1;  ///< SI value of the number one
};

std::vector<std::string_view> split_fields(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  for (std::size_t start = 0;;) {
    const std::size_t end = line.find(separator, start);
    std::string_view field = trim(line.substr(start, end == std::string_view::npos ? end : end - start));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (end == std::string_view::npos) return fields;
    start = end + 1;
  }
}

std::optional<double> parse_value(std::string_view text) {
  if (text.size() > 1 && text[0] == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || (error != std::errc{} && error != std::errc::result_out_of_range)) return {};
  return error == std::errc{} ? value : INFINITY;
}

/// A line of the file that is neither empty nor a comment.
struct SourceLine {
  long number = 0;
  std::string_view text;
  bool is_terminated = true;  ///< by a line break
};

std::vector<SourceLine> list_lines(std::string_view text) {
  std::vector<SourceLine> lines;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
  for (long number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view content = trim(text.substr(0, std::min(end, text.find('#'))));
    if (!content.empty()) lines.push_back({number, content, end != std::string_view::npos});
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

/// Mistakes of a file, the first of which are listed.
class Faults {
 public:
  explicit Faults(std::string file) : file_(std::move(file)) {}
  void add(const std::string& text) {
    if (count_++ < max_listed_faults) text_ += fmt::format("{}{}: {}", text_.empty() ? "" : "\n", file_, text);
  }
  void throw_if_any() const {
    if (count_ == 0) return;
    throw SystemError(text_ + (count_ > max_listed_faults
                                   ? fmt::format("\n{}: and {} more", file_, count_ - max_listed_faults)
                                   : ""));
  }

 private:
  std::string file_, text_;
  std::size_t count_ = 0;
};

class CsvRecord {
 public:
  CsvRecord(const std::string& path, const std::string& text, const Mechanism& mechanism, const SpecUnits& units,
            const RecordOptions& options)
      : file_(escape_for_terminal(path)),
        lines_(list_lines(text)),
        mechanism_(mechanism),
        units_(units),
        options_(options),
        names_(mechanism, units) {
    record_.source = file_;
  }

  MeasurementRecord read() {
    if (lines_.empty()) fail("expected a line of column names and rows of numbers, found an empty file");
    const std::string_view first = lines_.front().text;
    separator_ = first.find('\t') != std::string_view::npos  ? '\t'
                 : first.find(';') != std::string_view::npos ? ';'
                                                             : ',';
    choose_columns();
    read_rows();
    drop_time_column();
    continue_angles();
    return std::move(record_);
  }

 private:
  [[noreturn]] void fail(const std::string& message) const { throw SystemError(file_ + ": " + message); }
  std::string option(const char* name) const { return options_.prefix + name; }
  /// "time=NAME" for an option, "{time: NAME}" in a spec.
  std::string assign(const char* name, const char* value) const {
    return options_.prefix.empty() ? fmt::format("{{{}: {}}}", name, value) : fmt::format("{}={}", name, value);
  }

  /// "A1 [deg]" as name and unit.
  static std::pair<std::string, std::string> split_unit(std::string_view heading) {
    const std::size_t open = heading.rfind('[');
    // "torque[A1]" is a name
    if (open == std::string_view::npos || open == 0 || heading.back() != ']' || heading[open - 1] != ' ')
      return {std::string(heading), ""};
    return {std::string(trim(heading.substr(0, open))),
            std::string(heading.substr(open + 1, heading.size() - open - 2))};
  }

  double find_unit(const ColumnMeaning& meaning, const std::string& unit, const std::string& column) const {
    if (unit.empty()) return meaning.spec_unit;
    if (meaning.si_unit == "A") {
      if (unit == "A") return 1;
      if (unit == "mA") return 1e-3;
      fail(fmt::format("column {}: expected A or mA, found {}", quote_for_message(column), quote_for_message(unit)));
    }
    const auto found = parse_unit_product(unit), expected = parse_unit_product(meaning.si_unit);
    if (!found || !expected || !(found->dimension == expected->dimension))
      fail(fmt::format("column {}: expected a unit like {}, found {}", quote_for_message(column), meaning.si_unit,
                       quote_for_message(unit)));
    return found->value;
  }

  void choose_columns() {
    std::vector<std::string_view> header = split_fields(lines_.front().text, separator_);
    const bool has_header = std::none_of(header.begin(), header.end(),
                                         [](std::string_view field) { return parse_value(field).has_value(); });
    if (has_header) lines_.erase(lines_.begin());
    field_count_ = header.size();
    std::vector<bool> is_used(header.size(), false);
    for (const auto& [name, source] : options_.columns) {
      const ColumnMeaning* meaning = names_.find(name);
      if (meaning == nullptr)
        fail(fmt::format("{}: no column is called {}; expected {}{}", option("columns"), quote_for_message(name),
                         join_alternatives(names_.names()), append_nearest_name(name, names_.names())));
      add(*meaning, find_field(source, has_header ? header : std::vector<std::string_view>()), header, has_header,
          is_used);
    }
    if (!has_header && options_.columns.empty())
      fail(fmt::format("expected a line of column names first, found numbers; {} {} says what a column is",
                       option("columns"), assign("time", "1")));
    std::vector<std::string> ignored;
    for (std::size_t field = 0; has_header && field < header.size(); ++field) {
      if (is_used[field]) continue;
      const ColumnMeaning* meaning = names_.find(split_unit(header[field]).first);
      if (meaning == nullptr || is_chosen(*meaning))
        ignored.push_back(std::string(header[field]));
      else
        add(*meaning, field, header, has_header, is_used);
    }
    if (std::none_of(columns_.begin(), columns_.end(),
                     [](const ChosenColumn& column) { return column.meaning.is_time; }))
      fail(fmt::format("expected a column 'time', found {}; {} {} says which it is", describe(header),
                       option("columns"), assign("time", "NAME")));
    if (columns_.size() < 2)
      fail(fmt::format("expected columns {}, found {}; {} {} says what one is", join_alternatives(names_.names()),
                       describe(header), option("columns"), assign("A1", "NAME")));
    if (!ignored.empty())
      record_.notes.push_back("columns that are not read: " + join_with_conjunction(ignored, "and"));
  }

  static std::string describe(const std::vector<std::string_view>& header) {
    std::vector<std::string> names;
    for (const std::string_view name : header) names.push_back(quote_for_message(name));
    return join_with_conjunction(names, "and");
  }

  bool is_chosen(const ColumnMeaning& meaning) const {
    return std::any_of(columns_.begin(), columns_.end(), [&](const ChosenColumn& column) {
      return column.meaning.is_time == meaning.is_time && (meaning.is_time || column.meaning.signal == meaning.signal);
    });
  }

  std::size_t find_field(const std::string& source, const std::vector<std::string_view>& header) const {
    std::vector<std::string> names;
    for (std::size_t field = 0; field < header.size(); ++field) {
      if (header[field] == source || split_unit(header[field]).first == source) return field;
      names.push_back(split_unit(header[field]).first);
    }
    long number = 0;
    const auto [end, error] = std::from_chars(source.data(), source.data() + source.size(), number);
    if (error == std::errc{} && end == source.data() + source.size() && number >= 1 &&
        number <= static_cast<long>(field_count_))
      return static_cast<std::size_t>(number - 1);
    fail(fmt::format("{}: the file has no column {}{}{}", option("columns"), quote_for_message(source),
                     names.empty() ? fmt::format("; its columns are 1 to {}", field_count_)
                                   : "; it has " + join_with_conjunction(names, "and"),
                     append_nearest_name(source, names)));
  }

  void add(const ColumnMeaning& meaning, std::size_t field, const std::vector<std::string_view>& header,
           bool has_header, std::vector<bool>& is_used) {
    if (is_chosen(meaning)) fail(fmt::format("column {} is given twice", quote_for_message(header[field])));
    is_used[field] = true;
    const std::string name = has_header ? std::string(header[field]) : fmt::format("{}", field + 1);
    const std::string unit = has_header ? split_unit(header[field]).second : "";
    columns_.push_back({field, name, meaning, find_unit(meaning, unit, name)});
  }

  void read_rows() {
    Faults faults(file_);
    std::vector<double> values;
    long row = 0, count = 0;
    const std::size_t time_column =
        static_cast<std::size_t>(std::find_if(columns_.begin(), columns_.end(),
                                              [](const ChosenColumn& column) { return column.meaning.is_time; }) -
                                 columns_.begin());
    for (std::size_t k = 0; k < lines_.size(); ++k) {
      const SourceLine& line = lines_[k];
      ++row;
      if (options_.rows && (row < options_.rows->first || row > options_.rows->second)) continue;
      const std::vector<std::string_view> fields = split_fields(line.text, separator_);
      const bool is_last = k + 1 == lines_.size();
      if (fields.size() != field_count_) {
        if (is_last && fields.size() < field_count_) {
          record_.notes.push_back(fmt::format("the last row, in line {}, was cut off and is dropped", line.number));
          continue;
        }
        faults.add(fmt::format("line {}: expected {} numbers as in the first line, found {}", line.number, field_count_,
                               fields.size()));
        continue;
      }
      if (is_last && !line.is_terminated && !parse_value(fields.back())) {
        record_.notes.push_back(fmt::format("the last row, in line {}, was cut off and is dropped", line.number));
        continue;
      }
      bool is_outside = false;
      const std::size_t begin = values.size();
      for (const ChosenColumn& column : columns_) {
        const std::string_view field = fields[column.field];
        const std::optional<double> value = parse_value(field);
        if (!value)
          faults.add(fmt::format("row {} (line {}), column {}: expected a number, found {}{}", row, line.number,
                                 quote_for_message(column.name), quote_for_message(field),
                                 format_decimal_point_hint(field)));
        else if (!(std::abs(*value * column.unit) <= (column.meaning.is_time ? max_time : max_plausible_value)))
          faults.add(
              fmt::format("row {} (line {}), column {}: expected a measured number, found {}; {} leaves rows out", row,
                          line.number, quote_for_message(column.name), field, option("rows")));
        values.push_back(value.value_or(0) * column.unit);
      }
      const double time = values[begin + time_column];
      if (options_.time)
        is_outside = time < options_.time->first * units_.time || time > options_.time->second * units_.time;
      if (is_outside) {
        values.resize(begin);
        continue;
      }
      rows_.push_back(row);
      line_numbers_.push_back(line.number);
      if (count > 0) {
        const double before = values[begin - columns_.size() + time_column];
        if (!(time > before))
          faults.add(
              fmt::format("row {} (line {}): the time {} after {:.9g} s: expected increasing times, found {:.9g} s",
                          row, line.number, time == before ? "stands still" : "runs back", before, time));
      }
      ++count;
    }
    faults.throw_if_any();
    if (count < 2) fail(fmt::format("expected rows of numbers, found {}", count_noun(count, "row", "rows")));
    values_ = Eigen::Map<const Samples>(values.data(), count, static_cast<Eigen::Index>(columns_.size()));
    check_outliers();
  }

  /// A value a million times larger than nearly all others of its column is a fault of the log.
  void check_outliers() const {
    Faults faults(file_);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].meaning.is_time) continue;
      const auto column = static_cast<Eigen::Index>(c);
      std::vector<double> sorted;
      for (Eigen::Index k = 0; k < values_.rows(); ++k) sorted.push_back(std::abs(values_(k, column)));
      const auto percentile =
          sorted.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(sorted.size() - 1));
      std::nth_element(sorted.begin(), percentile, sorted.end());
      const double limit = max_percentile_ratio * *percentile;
      if (!(limit > 0)) continue;
      for (Eigen::Index k = 0; k < values_.rows(); ++k)
        if (std::abs(values_(k, column)) > limit)
          faults.add(
              fmt::format("row {} (line {}), column {}: expected a measured number, found {:.6g}, {:.1e} times as "
                          "large as nearly all others; "
                          "{} leaves rows out",
                          rows_[static_cast<std::size_t>(k)], line_numbers_[static_cast<std::size_t>(k)],
                          quote_for_message(columns_[c].name), values_(k, column) / columns_[c].unit,
                          std::abs(values_(k, column)) / *percentile, option("rows")));
    }
    faults.throw_if_any();
  }

  void drop_time_column() {
    record_.values.resize(values_.rows(), static_cast<Eigen::Index>(columns_.size()) - 1);
    Eigen::Index next = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].meaning.is_time) {
        record_.time = values_.col(static_cast<Eigen::Index>(c));
        continue;
      }
      record_.signals.push_back(columns_[c].meaning.signal);
      record_.values.col(next++) = values_.col(static_cast<Eigen::Index>(c));
    }
  }

  void continue_angles() {
    for (std::size_t s = 0; s < record_.signals.size(); ++s) {
      const MeasuredSignal& signal = record_.signals[s];
      if (signal.kind != MeasuredSignal::Kind::position || is_length_coordinate(mechanism_, signal.index)) continue;
      constexpr double turn = 2 * std::numbers::pi;
      auto column = record_.values.col(static_cast<Eigen::Index>(s));
      double shift = 0;
      long jumps = 0;
      for (Eigen::Index k = 1; k < column.size(); ++k) {
        const double change = column[k] + shift - column[k - 1];
        if (std::abs(change) > turn_fraction * turn && std::abs(change) < 2 * turn) {
          shift -= turn * std::round(change / turn);
          ++jumps;
        }
        column[k] += shift;
      }
      if (jumps > 0)
        record_.notes.push_back(fmt::format("{} jumps by a full turn {} and is continued",
                                            mechanism_.coordinates[static_cast<std::size_t>(signal.index)].name,
                                            count_noun(jumps, "time", "times")));
    }
  }

  std::string file_;
  std::vector<SourceLine> lines_;
  const Mechanism& mechanism_;
  const SpecUnits& units_;
  const RecordOptions& options_;
  ColumnNames names_;
  char separator_ = ',';
  std::size_t field_count_ = 0;
  std::vector<ChosenColumn> columns_;
  std::vector<long> rows_, line_numbers_;
  MatrixX values_;
  MeasurementRecord record_;
};

std::string read_bytes(const std::string& path) {
  if (const std::string kind = describe_non_file(path); !kind.empty())
    throw SystemError(path + ": is " + kind + ", not a file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError(path + ": cannot be read", errno);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (file.bad()) throw SystemError(path + ": cannot be read");
  if (text.size() > max_record_bytes)
    throw SystemError(fmt::format("{}: expected at most {} MiB", path, max_record_bytes >> 20));
  if (text.starts_with("\x89HDF"))
    throw SystemError(path + ": is an HDF5 file; expected a CSV file, such as 'balance simulate --csv' writes");
  return text;
}

}  // namespace

MeasurementRecord read_measurement_csv(const std::string& path, const Mechanism& mechanism, const SpecUnits& units,
                                       const RecordOptions& options) {
  return CsvRecord(path, read_bytes(path), mechanism, units, options).read();
}

}  // namespace balance::specification
