#include "balance/spec/table.hpp"

#include "balance/base/nearest.hpp"
#include "balance/base/plain_text.hpp"
#include "balance/spec/limits.hpp"
#include "balance/spec/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace balance::specification {

namespace {

constexpr std::uintmax_t max_table_bytes = std::uintmax_t{256} << 20;
constexpr const char* hdf5_signature = "\x89HDF\r\n\x1a\n";

std::vector<std::string> names_of(const std::vector<TableColumn>& columns) {
  std::vector<std::string> names{"time"};
  for (const TableColumn& column : columns) names.push_back(column.name);
  return names;
}

/// The file's path, seen from the spec's folder.
std::filesystem::path find_file(const SpecCursor& at, const StudyBuilder& draft) {
  const std::filesystem::path path =
      std::filesystem::path(draft.study.spec_file).parent_path() / at.read_word("a file's name");
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    at.fail(
        {.expected = "a file beside the spec", .found = fmt::format("none at {}", quote_for_message(path.string()))});
  if (const std::string kind = describe_non_file(path.string()); !kind.empty())
    at.fail({.expected = "a file", .found = fmt::format("{} at {}", kind, quote_for_message(path.string()))});
  if (std::filesystem::file_size(path, error) > max_table_bytes)
    at.fail({.expected = fmt::format("a table of at most {} MiB", max_table_bytes >> 20),
             .found = fmt::format("more at {}", quote_for_message(path.string()))});
  return path;
}

RawTable load(const std::filesystem::path& path, const std::vector<std::string>& names) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw TableError("the file cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad() || text.fail()) throw TableError("the file is empty or cannot be read");
  if (text.view().substr(0, 8) == hdf5_signature) return read_hdf5_table(path.string(), names);
  return parse_csv(text.str());
}

/// Index of every column among the possible ones; −1 for the time. @throws TableError
std::vector<int> place_columns(const RawTable& raw, const std::vector<std::string>& names) {
  std::vector<int> places;
  for (const std::string& column : raw.columns) {
    const auto at = std::find(names.begin(), names.end(), column);
    if (at == names.end())
      throw TableError(
          fmt::format("expected the columns {}, found {}{}", join_alternatives(names), quote_for_message(column),
                      column.find(';') != std::string::npos ? "; commas stand between columns, points before decimals"
                                                            : append_nearest_name(column, names)));
    const int place = static_cast<int>(at - names.begin()) - 1;
    if (std::find(places.begin(), places.end(), place) != places.end())
      throw TableError(fmt::format("expected every column once, found {} again", quote_for_message(column)));
    places.push_back(place);
  }
  if (std::find(places.begin(), places.end(), -1) == places.end())
    throw TableError("expected a column 'time', found none");
  if (places.size() < 2)
    throw TableError(fmt::format("expected columns beside 'time' ({}), found none", join_alternatives(names)));
  return places;
}

TimeTable to_si_table(const RawTable& raw, const StudyBuilder& draft, const std::vector<TableColumn>& possible) {
  const std::vector<int> places = place_columns(raw, names_of(possible));
  TimeTable table;
  std::vector<double> units;
  for (const int place : places) {
    units.push_back(
        draft.units.factor(place < 0 ? dimension::time : possible[static_cast<std::size_t>(place)].dimension));
    if (place >= 0) table.columns.push_back(place);
  }
  for (const std::vector<double>& numbers : raw.rows) {
    std::vector<Expression> row;
    row.reserve(table.columns.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double value = numbers[i] * units[i];
      if (!std::isfinite(value))
        throw TableError(fmt::format("row {}: expected finite numbers, found {}", table.time.size() + 1, value));
      if (places[i] < 0)
        table.time.push_back(value);
      else
        row.push_back(value);
    }
    table.values.push_back(std::move(row));
  }
  return table;
}

}  // namespace

void check_times(const SpecCursor& at, const std::vector<Expression>& time) {
  for (std::size_t i = 1; i < time.size(); ++i)
    if (!(time[i].value() > time[i - 1].value()))
      at.fail({.expected = "increasing times",
               .found = fmt::format("{:.9g} s after {:.9g} s in row {}", time[i].value(), time[i - 1].value(), i + 1)});
}

TimeTable read_inline_table(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& columns) {
  TimeTable table;
  std::string what = "a row [time";
  for (std::size_t i = 0; i < columns.size(); ++i) {
    what += ", " + columns[i].name;
    table.columns.push_back(static_cast<int>(i));
  }
  read_each(at.items("a list of rows"), [&](const SpecCursor& row) {
    std::vector<Expression> numbers;
    read_each(row.items(what + "]", columns.size() + 1), [&](const SpecCursor& item) {
      const std::size_t i = numbers.size();
      numbers.push_back(read_number(item, draft, i == 0 ? dimension::time : columns[i - 1].dimension));
    });
    table.time.push_back(numbers[0]);
    table.values.emplace_back(numbers.begin() + 1, numbers.end());
  });
  if (table.time.empty()) at.fail_expected("at least one row");
  check_times(at, table.time);
  return table;
}

TimeTable read_table_file(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& possible) {
  const std::filesystem::path path = find_file(at, draft);
  try {
    TimeTable table = to_si_table(load(path, names_of(possible)), draft, possible);
    if (table.time.empty()) throw TableError("expected at least one row of numbers, found none");
    check_times(at, table.time);
    return table;
  } catch (const TableError& wrong) {
    at.fail({.message = escape_for_terminal(path.string()) + ": " + wrong.what(),
             .expected =
                 fmt::format("a table with 'time' and some of {}", join_with_conjunction(names_of(possible), "and")),
             .found = quote_for_message(path.string()),
             .hint = wrong.what()});
  }
}

}  // namespace balance::specification
