#include "balance/interface/specification/spec_table.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/foundation/hdf5/hdf5_reader.hpp"
#include "balance/interface/specification/text_file.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>

namespace balance::specification {

namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t start = 0;;) {
    const auto comma = line.find(',', start);
    fields.push_back(trim(line.substr(start, comma - start)));
    if (comma == std::string_view::npos) return fields;
    start = comma + 1;
  }
}

double parse_number(std::string_view text, long line) {
  std::string_view digits = text;
  if (digits.size() > 1 && digits[0] == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
    throw TableError(fmt::format("line {}: expected a finite number, found {}", line, quote_for_message(text)));
  return value;
}

void read_line(std::string_view line, long number_of_line, RawTable& table) {
  const auto fields = split(line);
  if (table.columns.empty()) {
    table.columns.assign(fields.begin(), fields.end());
    return;
  }
  if (fields.size() != table.columns.size())
    throw TableError(fmt::format("line {}: expected {} numbers as in the header line, found {}", number_of_line,
                                 table.columns.size(), fields.size()));
  std::vector<double> row;
  row.reserve(fields.size());
  for (const std::string_view field : fields) row.push_back(parse_number(field, number_of_line));
  table.rows.push_back(std::move(row));
}

}  // namespace

RawTable parse_csv(const std::string& text) {
  RawTable table;
  std::string_view remaining_text = text;
  if (remaining_text.substr(0, 3) == "\xEF\xBB\xBF") remaining_text.remove_prefix(3);
  for (long line = 1; !remaining_text.empty(); ++line) {
    const auto end = remaining_text.find('\n');
    const std::string_view content = trim(remaining_text.substr(0, std::min(end, remaining_text.find('#'))));
    if (!content.empty()) read_line(content, line, table);
    remaining_text.remove_prefix(end == std::string_view::npos ? remaining_text.size() : end + 1);
  }
  if (table.columns.empty()) throw TableError("expected a header line of column names, found an empty file");
  return table;
}

namespace {

constexpr std::size_t max_table_rows = 1'000'000;

std::vector<double> read_column(const hdf5::Hdf5Reader& file, const std::string& name) {
  auto dataset = file.numbers(name, 1, max_table_rows);
  if (dataset.sizes.empty())
    throw TableError(fmt::format("{}: expected one dimension, found 0", quote_for_message(name)));
  return std::move(dataset.values);
}

RawTable read_columns(const hdf5::Hdf5Reader& file, const std::vector<std::string>& names) {
  RawTable table;
  for (const std::string& name : names) {
    if (!file.has(name)) continue;
    const auto values = read_column(file, name);
    if (table.columns.empty()) table.rows.resize(values.size());
    if (values.size() != table.rows.size())
      throw TableError(fmt::format("{}: expected {} values as in {}, found {}", quote_for_message(name),
                                   table.rows.size(), quote_for_message(table.columns[0]), values.size()));
    table.columns.push_back(name);
    for (std::size_t i = 0; i < values.size(); ++i) table.rows[i].push_back(values[i]);
  }
  return table;
}

}  // namespace

RawTable read_hdf5_table(const std::string& path, const std::vector<std::string>& names) {
  try {
    return read_columns(hdf5::Hdf5Reader(path), names);
  } catch (const hdf5::Hdf5Error& error) {
    throw TableError(error.what());
  }
}

namespace {

constexpr std::uintmax_t max_table_bytes = std::uintmax_t{256} << 20;
constexpr const char* hdf5_signature = "\x89HDF\r\n\x1a\n";

std::vector<std::string> names_of(const std::vector<TableColumn>& columns, const TableColumn& argument) {
  std::vector<std::string> names{argument.name};
  for (const TableColumn& column : columns) names.push_back(column.name);
  return names;
}

}  // namespace

std::string find_table_file(const SpecCursor& at, const StudyBuilder& draft) {
  const std::filesystem::path path =
      std::filesystem::path(draft.study.spec_file).parent_path() / at.read_word("a file's name");
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    at.fail(
        {.expected = "a file next to the spec", .found = fmt::format("none at {}", quote_for_message(path.string()))});
  if (const std::string kind = describe_non_file(path.string()); !kind.empty())
    at.fail({.expected = "a file", .found = fmt::format("{} at {}", kind, quote_for_message(path.string()))});
  if (std::filesystem::file_size(path, error) > max_table_bytes)
    at.fail({.expected = fmt::format("a table of at most {} MiB", max_table_bytes >> 20),
             .found = fmt::format("more at {}", quote_for_message(path.string()))});
  return path.string();
}

namespace {

/// @throws TableError
std::string load_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw TableError("the file cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad() || text.fail()) throw TableError("the file is empty or cannot be read");
  return text.str();
}

RawTable load_table(const std::filesystem::path& path, const std::vector<std::string>& names) {
  const std::string text = load_text(path);
  if (text.starts_with(hdf5_signature)) return read_hdf5_table(path.string(), names);
  return parse_csv(text);
}

/// Index of every column among the possible ones; −1 for the argument, the first of the names. @throws TableError
std::vector<int> find_column_indices(const RawTable& raw, const std::vector<std::string>& names) {
  std::vector<int> indices;
  for (const std::string& column : raw.columns) {
    const auto match = std::find(names.begin(), names.end(), column);
    if (match == names.end())
      throw TableError(
          fmt::format("expected the columns {}, found {}{}", join_alternatives(names), quote_for_message(column),
                      column.find(';') != std::string::npos ? "; use commas between columns and points before decimals"
                                                            : append_nearest_name(column, names)));
    const int index = static_cast<int>(match - names.begin()) - 1;
    if (std::find(indices.begin(), indices.end(), index) != indices.end())
      throw TableError(fmt::format("expected each column only once, found {} again", quote_for_message(column)));
    indices.push_back(index);
  }
  if (std::find(indices.begin(), indices.end(), -1) == indices.end())
    throw TableError(fmt::format("expected a column {}, found none", quote_for_message(names[0])));
  if (indices.size() < 2)
    throw TableError(fmt::format("expected columns besides {} ({}), found none", quote_for_message(names[0]),
                                 join_alternatives(names)));
  return indices;
}

TimeTable to_si_table(const RawTable& raw, const StudyBuilder& draft, const std::vector<TableColumn>& possible,
                      const TableColumn& argument) {
  const std::vector<int> indices = find_column_indices(raw, names_of(possible, argument));
  TimeTable table;
  std::vector<double> units;
  for (const int index : indices) {
    units.push_back(
        draft.units.factor(index < 0 ? argument.dimension : possible[static_cast<std::size_t>(index)].dimension));
    if (index >= 0) table.columns.push_back(index);
  }
  for (const std::vector<double>& numbers : raw.rows) {
    std::vector<Expression> row;
    row.reserve(table.columns.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double value = numbers[i] * units[i];
      if (!std::isfinite(value))
        throw TableError(fmt::format("row {}: expected finite numbers, found {}", table.time.size() + 1, value));
      if (indices[i] < 0)
        table.time.push_back(value);
      else
        row.push_back(value);
    }
    table.values.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::string read_file_beside_spec(const SpecCursor& at, const StudyBuilder& draft) {
  const std::filesystem::path path = find_table_file(at, draft);
  try {
    return load_text(path);
  } catch (const TableError& error) {
    at.fail({.message = escape_for_terminal(path.string()) + ": " + error.what(),
             .expected = "a file that can be read",
             .found = quote_for_message(path.string())});
  }
}

void check_increasing(const SpecCursor& at, const std::vector<Expression>& values, const TableColumn& argument) {
  const std::string unit = unit_of_dimension(argument.dimension);
  for (std::size_t i = 1; i < values.size(); ++i)
    if (!(values[i].value() > values[i - 1].value()))
      at.fail({.expected =
                   argument.dimension == dimension::time ? "increasing times" : "increasing values of " + argument.name,
               .found = fmt::format("{:.9g} {} after {:.9g} {} in row {}", values[i].value(), unit,
                                    values[i - 1].value(), unit, i + 1)});
}

TimeTable read_inline_table(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& columns,
                            const TableColumn& argument) {
  TimeTable table;
  std::string what = "a row [" + argument.name;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    what += ", " + columns[i].name;
    table.columns.push_back(static_cast<int>(i));
  }
  read_each(at.items("a list of rows"), [&](const SpecCursor& row) {
    std::vector<Expression> numbers;
    read_each(row.items(what + "]", columns.size() + 1), [&](const SpecCursor& item) {
      const std::size_t i = numbers.size();
      numbers.push_back(read_number(item, draft, i == 0 ? argument.dimension : columns[i - 1].dimension));
    });
    table.time.push_back(numbers[0]);
    table.values.emplace_back(numbers.begin() + 1, numbers.end());
  });
  if (table.time.empty()) at.fail_expected("at least one row");
  check_increasing(at, table.time, argument);
  return table;
}

TimeTable read_table_file(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& possible,
                          const TableColumn& argument) {
  const std::filesystem::path path = find_table_file(at, draft);
  try {
    TimeTable table = to_si_table(load_table(path, names_of(possible, argument)), draft, possible, argument);
    if (table.time.empty()) throw TableError("expected at least one row of numbers, found none");
    check_increasing(at, table.time, argument);
    return table;
  } catch (const TableError& error) {
    at.fail({.message = escape_for_terminal(path.string()) + ": " + error.what(),
             .expected = fmt::format("a table with {} and some of {}", quote_for_message(argument.name),
                                     join_with_conjunction(names_of(possible, argument), "and")),
             .found = quote_for_message(path.string()),
             .hint = error.what()});
  }
}

}  // namespace balance::specification
