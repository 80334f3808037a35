#include "balance/base/nearest.hpp"
#include "balance/hdf5/source.hpp"
#include "balance/spec/table.hpp"

#include <fmt/format.h>

namespace balance::specification {

namespace {

constexpr std::size_t max_table_rows = 1'000'000;

std::vector<double> read_column(const Hdf5Reader& file, const std::string& name) {
  auto found = file.numbers(name, 1, max_table_rows);
  if (found.sizes.empty())
    throw TableError(fmt::format("{}: expected one dimension, found 0", quote_for_message(name)));
  return std::move(found.values);
}

RawTable read_columns(const Hdf5Reader& file, const std::vector<std::string>& names) {
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
    return read_columns(Hdf5Reader(path), names);
  } catch (const Hdf5Error& error) {
    throw TableError(error.what());
  }
}

}  // namespace balance::specification
