#pragma once
/// Fields of an answer, each declared once, and the writers of such fields as JSON, HDF5 and text.
///
/// A list of fields describes the rows of a table, or an object of single figures. A field is in the formats that it
/// names.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/files/text_table.hpp"

#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::files {

struct JsonKey {
  std::string name;  ///< "peak/value": member of an object
};
struct TextColumn {
  std::optional<std::string> heading = {};  ///< default: the key
  std::string format = {};                  ///< of numbers; empty: as format_figure
};
struct Hdf5Dataset {
  std::string long_name, name = {};  ///< default: the key
};
/// SI unit of all numbers of a field. Without it they are in the unit of their row.
struct SiUnit {
  std::string name;
};

template <class Row>
struct ReportField {
  std::function<Json(const Row&)> value;  ///< NaN or null: unknown
  std::string key = {}, unit = {};
  std::optional<TextColumn> column = {};
  std::function<std::string(const Row&, const DisplayUnit&)> cell = {};  ///< of the column, instead of the value
  std::optional<Hdf5Dataset> dataset = {};

  /// @param forms JsonKey first, then TextColumn, Hdf5Dataset, SiUnit and a function as `cell`, in any order
  template <class... Forms>
  ReportField(std::function<Json(const Row&)> value_of_row, Forms... forms) : value(std::move(value_of_row)) {
    (set(std::move(forms)), ...);
  }

 private:
  void set(JsonKey form) { key = std::move(form.name); }
  void set(SiUnit form) { unit = std::move(form.name); }
  void set(std::function<std::string(const Row&, const DisplayUnit&)> form) { cell = std::move(form); }
  void set(TextColumn form) {
    column = std::move(form);
    if (!column->heading) column->heading = key;
  }
  void set(Hdf5Dataset form) {
    dataset = std::move(form);
    if (dataset->name.empty()) dataset->name = key;
  }
};

template <class Row>
using ReportFields = std::vector<ReportField<Row>>;

/// 0, 1, … count − 1: rows that have no type of their own.
template <class Index>
std::vector<Index> list_indices(Index count) {
  std::vector<Index> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), Index{0});
  return indices;
}

/// Cells with the unit of the row; the second ones with "1" where there is none.
inline constexpr auto unit_name = [](const auto&, const DisplayUnit& unit) { return unit.name; };
inline constexpr auto unit_name_or_1 = [](const auto&, const DisplayUnit& unit) { return unit_cell(unit); };

/// The format of numbers of which zero has six digits, too.
inline constexpr const char* six_digits = "{:#.6g}";

/// "0" for an exact zero, "-" for NaN, otherwise six significant digits, trailing zeros kept.
std::string format_figure(double value);

// Pieces of the writers below that do not depend on the type of a row.

/// The member of an object, or of objects in it, added if it is not there.
Json& member_at(Json& object, std::string_view key);

/// Adds the first variable of a table as dimension, others along it; rows of lists also along the inner dimension.
/// Texts have the unit "1".
void write_column(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, hdf5::Hdf5Writer::Variable variable,
                  const std::vector<Json>& values, std::optional<hdf5::Hdf5Writer::Dimension>& rows,
                  const std::optional<hdf5::Hdf5Writer::Dimension>& inner);

/// Texts are as they are, null is empty.
std::string format_value(const Json& value, const std::string& format, const DisplayUnit& unit);

/// Adds a column, numbers aligned right.
void add_text_column(TextTable& table, const std::string& heading, Align align, std::vector<std::string> cells);

// The writers.

/// Adds the fields as members of the object.
template <class Row>
void add_fields(Json& object, const Row& row, const ReportFields<Row>& fields) {
  for (const ReportField<Row>& field : fields)
    if (!field.key.empty()) member_at(object, field.key) = field.value(row);
}

template <class Row>
Json fields_json(const Row& row, const ReportFields<Row>& fields) {
  Json object = Json::object();
  add_fields(object, row, fields);
  return object;
}

/// An array of objects.
template <class Row, class Rows>
Json rows_json(const Rows& rows, const ReportFields<Row>& fields) {
  return list_json(rows, [&](const Row& row) { return fields_json(row, fields); });
}

/// Writes a dataset of one number per field.
template <class Row>
void write_fields(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const Row& row,
                  const ReportFields<Row>& fields) {
  for (const ReportField<Row>& field : fields) {
    if (!field.dataset) continue;
    const auto number = field.value(row).template get<double>();
    file.add_variable(group, {field.dataset->name, field.dataset->long_name, field.unit, {}, {}}, {&number, 1});
  }
}

/// Writes a dataset per field, the first one as dimension of the others.
/// @param rows at least one, because netCDF has no empty dimensions
/// @param row_unit of numbers in their row's unit
/// @param inner dimension of fields that are lists
template <class Row, class Rows>
hdf5::Hdf5Writer::Dimension write_rows(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group group, const Rows& rows,
                                       const ReportFields<Row>& fields, const std::string& row_unit = "mixed",
                                       const std::optional<hdf5::Hdf5Writer::Dimension>& inner = {}) {
  std::optional<hdf5::Hdf5Writer::Dimension> dimension;
  for (const ReportField<Row>& field : fields) {
    if (!field.dataset) continue;
    std::vector<Json> values;
    for (const Row& row : rows) values.push_back(field.value(row));
    const std::string& unit = field.unit.empty() ? row_unit : field.unit;
    write_column(file, group, {field.dataset->name, field.dataset->long_name, unit, {}, {}}, values, dimension, inner);
  }
  return dimension.value();
}

/// The columns of a table. Numbers are converted to the unit of their field, which the heading then names, or of their
/// row: `row.unit` if there is no other.
template <class Row, class Rows>
TextTable rows_table(const Rows& rows, const ReportFields<Row>& fields, const specification::SpecUnits& units = {},
                     const std::function<DisplayUnit(const Row&)>& unit_of_row = {}) {
  const auto find_row_unit = [&](const Row& row) {
    if (unit_of_row) return unit_of_row(row);
    if constexpr (requires { find_display_unit(row.unit, units); })
      return find_display_unit(row.unit, units);
    else
      return DisplayUnit{};
  };
  TextTable table;
  for (const ReportField<Row>& field : fields) {
    if (!field.column) continue;
    const DisplayUnit unit = find_display_unit(field.unit, units);
    bool has_numbers = false;
    std::vector<std::string> cells;
    for (const Row& row : rows) {
      const DisplayUnit cell_unit = field.unit.empty() ? find_row_unit(row) : unit;
      const Json value = field.value ? field.value(row) : Json();
      has_numbers = has_numbers || value.is_number();
      cells.push_back(field.cell ? field.cell(row, cell_unit) : format_value(value, field.column->format, cell_unit));
    }
    add_text_column(table, *field.column->heading + bracket_unit(unit), has_numbers ? Align::right : Align::left,
                    std::move(cells));
  }
  return table;
}

}  // namespace balance::files

namespace balance {

using files::Hdf5Dataset;
using files::JsonKey;
using files::ReportField;
using files::ReportFields;
using files::SiUnit;
using files::TextColumn;

}  // namespace balance
