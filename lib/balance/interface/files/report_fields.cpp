#include "balance/interface/files/report_fields.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace balance::files {

std::string format_figure(double value) {
  if (std::isnan(value)) return "-";
  return value == 0 ? "0" : format_number(value);
}

Json& member_at(Json& object, std::string_view key) {
  const std::size_t slash = key.find('/');
  Json& member = object[std::string(key.substr(0, slash))];
  return slash == std::string_view::npos ? member : member_at(member, key.substr(slash + 1));
}

void write_column(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, hdf5::Hdf5Writer::Variable variable,
                  const std::vector<Json>& values, std::optional<hdf5::Hdf5Writer::Dimension>& rows,
                  const std::optional<hdf5::Hdf5Writer::Dimension>& inner) {
  if (values.empty()) throw std::invalid_argument("a table without rows has no dimension");
  if (rows) variable.dimensions.push_back(*rows);
  if (values.front().is_structured()) variable.dimensions.push_back(inner.value());
  const auto write = [&](const auto& entries) {
    if (rows)
      file.add_variable(group, variable, entries);
    else
      rows = file.add_dimension(group, variable, entries);
  };
  if (values.front().is_string()) {
    std::vector<std::string> texts;
    for (const Json& value : values) texts.push_back(value.get<std::string>());
    variable.units = "1";
    return write(texts);
  }
  std::vector<double> numbers;
  const auto add = [&](const Json& value) {
    numbers.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
  };
  for (const Json& value : values) {
    if (!value.is_structured())
      add(value);
    else
      for (const Json& entry : value) add(entry);
  }
  write(numbers);
}

std::string format_value(const Json& value, const std::string& format, const DisplayUnit& unit) {
  if (value.is_null()) return "";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_integer()) return value.dump();
  const double number = unit.convert(value.get<double>());
  return format.empty() || std::isnan(number) ? format_figure(number) : fmt::format(fmt::runtime(format), number);
}

void add_text_column(TextTable& table, const std::string& heading, Align align, std::vector<std::string> cells) {
  table.heading.push_back(heading);
  table.align.push_back(align);
  table.rows.resize(cells.size());
  for (std::size_t row = 0; row < cells.size(); ++row) table.rows[row].push_back(std::move(cells[row]));
}

}  // namespace balance::files
