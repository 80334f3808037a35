#include "balance/interface/reports/catalogue_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/files/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace balance::reports {

namespace {

using study::CatalogueChoice;

constexpr double not_stated = std::numeric_limits<double>::quiet_NaN();

double entry(const std::vector<double>& values, int row) {
  return values.empty() ? not_stated : values[static_cast<std::size_t>(row)];
}

int count_of(const CatalogueChoice& choice) { return choice.counts[static_cast<std::size_t>(choice.row)]; }
const std::string& part_of(const CatalogueChoice& choice) { return choice.parts[static_cast<std::size_t>(choice.row)]; }

/// The common currency; empty if there are several, or none.
std::string currency_of(const std::vector<CatalogueChoice>& choices) {
  std::string currency;
  for (const CatalogueChoice& choice : choices) {
    if (choice.prices.empty()) continue;
    if (!currency.empty() && choice.currency != currency) return "";
    currency = choice.currency;
  }
  return currency;
}

/// NaN if some parts have no mass or price in their catalogues.
double sum_of(const std::vector<CatalogueChoice>& choices, std::vector<double> CatalogueChoice::*values) {
  double sum = 0;
  for (const CatalogueChoice& choice : choices) sum += count_of(choice) * entry(choice.*values, choice.row);
  return sum;
}

const files::ReportFields<CatalogueChoice>& part_fields() {
  using Row = CatalogueChoice;
  using files::Hdf5Dataset;
  using files::JsonKey;
  using files::SiUnit;
  static const files::ReportFields<Row> fields{
      {&Row::path, JsonKey{"element"}, Hdf5Dataset{"element of the spec", "element"}},
      {[](const Row& row) { return row.file->name; }, JsonKey{"catalogue"},
       Hdf5Dataset{"catalogue, a file beside the spec", "catalogue"}},
      {[](const Row& row) { return files::sha256(row.file->text); }, JsonKey{"sha256"},
       Hdf5Dataset{"SHA-256 of the catalogue", "sha256"}},
      {[](const Row& row) { return part_of(row); }, JsonKey{"part"}, Hdf5Dataset{"name of the part", "part"}},
      {[](const Row& row) { return count_of(row); }, JsonKey{"count"}, SiUnit{"1"},
       Hdf5Dataset{"number of parts side by side", "count"}},
      {[](const Row& row) { return entry(row.masses, row.row); }, JsonKey{"mass"}, SiUnit{"kg"},
       Hdf5Dataset{"mass of one part", "part_mass"}},
      {[](const Row& row) { return entry(row.prices, row.row); }, JsonKey{"price"}, SiUnit{"1"},
       Hdf5Dataset{"price of one part", "price"}},
      {&Row::currency, JsonKey{"currency"}, Hdf5Dataset{"currency of the price", "currency"}}};
  return fields;
}

std::string number_or_dash(double value) { return std::isnan(value) ? "-" : fmt::format("{:.6g}", value); }

}  // namespace

std::string parts_text(const std::optional<design::CatalogueReport>& report, const std::string& objective_unit,
                       const files::TextOptions& options) {
  if (!report) return "";
  const std::vector<CatalogueChoice>& choices = report->choices;
  const files::DisplayUnit mass = files::find_display_unit("kg", options.units);
  const std::string currency = currency_of(choices);
  const auto any = [&](std::vector<double> CatalogueChoice::*values) {
    return std::any_of(choices.begin(), choices.end(), [&](const auto& choice) { return !(choice.*values).empty(); });
  };
  const bool has_mass = any(&CatalogueChoice::masses), has_price = any(&CatalogueChoice::prices);
  using files::Align;
  files::TextTable table{
      {"element", "catalogue", "part", "number"}, {Align::left, Align::left, Align::left, Align::right}, {}};
  if (has_mass) table.heading.push_back("mass of one [" + mass.name + "]"), table.align.push_back(Align::right);
  if (has_price)
    table.heading.push_back(currency.empty() ? "price of one" : "price of one [" + escape_for_terminal(currency) + "]"),
        table.align.push_back(Align::right);
  for (const CatalogueChoice& choice : choices) {
    std::vector<std::string> row{choice.path, escape_for_terminal(choice.file->name),
                                 escape_for_terminal(part_of(choice)), std::to_string(count_of(choice))};
    if (has_mass) row.push_back(number_or_dash(mass.convert(entry(choice.masses, choice.row))));
    if (has_price) row.push_back(number_or_dash(entry(choice.prices, choice.row)));
    table.rows.push_back(std::move(row));
  }
  std::string text = format_table(table, options.width);
  const double total_mass = sum_of(choices, &CatalogueChoice::masses),
               total_price = sum_of(choices, &CatalogueChoice::prices);
  std::string sums;
  if (!std::isnan(total_mass)) sums += fmt::format("{:.6g} {}", mass.convert(total_mass), mass.name);
  if (!std::isnan(total_price))
    sums += fmt::format("{}{:.6g}{}", sums.empty() ? "" : ", ", total_price,
                        currency.empty() ? "" : " " + escape_for_terminal(currency));
  if (!sums.empty()) text += "all parts: " + sums + "\n";
  if (!report->is_searched) return text + "\n";
  text += fmt::format("rows: {:.6g} combination{}", report->combinations, report->combinations == 1 ? "" : "s");
  if (report->is_proved && std::isfinite(report->lower_bound)) {
    const files::DisplayUnit unit = files::find_display_unit(objective_unit, options.units);
    text +=
        fmt::format("; proved: no other rows and free numbers are below {}{}",
                    files::format_figure(unit.convert(report->lower_bound)), unit.name.empty() ? "" : " " + unit.name);
  } else if (report->is_proved) {
    text += "; all were tried";
  } else if (!report->no_bound_reason.empty()) {
    text += fmt::format("; tried one by one without a proof, because {}", report->no_bound_reason);
  }
  return text + "\n\n";
}

Json parts_json(const std::optional<design::CatalogueReport>& report) {
  if (!report) return nullptr;
  const double bound = report->lower_bound;
  return {{"list", rows_json(report->choices, part_fields())},
          {"mass", sum_of(report->choices, &CatalogueChoice::masses)},
          {"price", sum_of(report->choices, &CatalogueChoice::prices)},
          {"currency", currency_of(report->choices)},
          {"searched", report->is_searched},
          {"combinations", report->combinations},
          {"solved", report->solved},
          {"bounded", report->branches},
          {"lower_bound", std::isfinite(bound) ? Json(bound) : Json(nullptr)},
          {"proved", report->is_proved},
          {"no_bound", report->no_bound_reason}};
}

void add_parts(hdf5::Hdf5Writer& file, const design::CatalogueReport& report) {
  const hdf5::Hdf5Writer::Group group = file.add_group("parts");
  file.set_attribute(group, "proved", report.is_proved ? "yes" : "no");
  write_rows(file, group, report.choices, part_fields());
}

}  // namespace balance::reports
