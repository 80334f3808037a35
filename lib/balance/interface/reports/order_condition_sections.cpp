#include "balance/interface/reports/order_condition_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/motion/simulation/end_configurations.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::reports {

namespace {

/// One row with its place among the printed conditions; −1: it vanishes whatever the masses.
struct OrderLine {
  const conditions::OrderRow* row = nullptr;
  const study::OrderReference* order = nullptr;
  double amplitude = 0;
  std::string unit;
  int condition = -1;
};

std::vector<OrderLine> list_lines(const ConditionsReportData& view) {
  const std::vector<conditions::OrderRow>& rows = view.conditions.orders.rows;
  std::vector<OrderLine> lines;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto& listed = view.order_conditions.rows;
    const auto place = std::find(listed.begin(), listed.end(), r);
    lines.push_back({&rows[r], &view.conditions.goals[rows[r].goal].order,
                     view.order_amplitudes[static_cast<Eigen::Index>(r)], rows[r].unit,
                     place == listed.end() ? -1 : static_cast<int>(place - listed.begin())});
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const OrderLine& a, const OrderLine& b) { return a.row->goal < b.row->goal; });
  return lines;
}

const char* harmonic_name(const OrderLine& line) { return line.row->is_sine ? "sin" : "cos"; }

/// "order 2 of shaking_force[x]"
std::string describe_line(const OrderLine& line) {
  return fmt::format("{} {} of {}", results::name_of(line.order->part), results::format_order(line.order->number),
                     line.row->quantity);
}

/// The rows as a report of their own, for the text of single conditions.
ConditionsReportData make_row_view(const ConditionsReportData& view) {
  ConditionsReportData rows;
  rows.conditions = view.order_conditions.conditions;
  rows.names = view.order_names;
  return rows;
}

std::string motion_text(const conditions::OrderMotion& motion, const specification::SpecUnits& units) {
  const files::DisplayUnit speed = files::find_display_unit("rad/s", units);
  return fmt::format("orders along {}: {} makes {} at {:.6g} {}; {} moments, change by the last doubling {:.1g}\n",
                     motion.trajectory, motion.turning.coordinate, count_noun(motion.turning.turns, "turn", "turns"),
                     speed.convert(motion.turning.speed), speed.name, motion.samples, motion.spectral_error);
}

std::string amplitude_text(const OrderLine& line, const specification::SpecUnits& units) {
  const files::DisplayUnit unit = files::find_display_unit(line.unit, units);
  return line.amplitude == 0 ? "0" : fmt::format("{:.6g} {}", unit.convert(line.amplitude), unit.name);
}

/// "always 0: order 3 of shaking_force[x]; order 1 of shaking_force[y] (sin)"
std::string format_vanishing(const std::vector<OrderLine>& lines) {
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].condition >= 0) continue;
    const bool is_pair =
        i + 1 < lines.size() && !lines[i].row->is_sine && lines[i + 1].row->is_sine && lines[i + 1].condition < 0;
    text += (text.empty() ? "" : "; ") + describe_line(lines[i]);
    if (!is_pair) text += fmt::format(" ({})", harmonic_name(lines[i]));
    if (is_pair) ++i;
  }
  return text.empty() ? "" : "always 0: " + text + "\n";
}

Json terms_json(const Conditions& conditions, int row, const conditions::ConditionNames& names) {
  Json terms = Json::array();
  for (Eigen::Index p = 0; p < conditions.matrix.cols(); ++p) {
    if (conditions.matrix(row, p) == 0) continue;
    Json term = {{"parameter", conditions.parameters[static_cast<std::size_t>(p)].name},
                 {"coefficient", conditions.matrix(row, p)}};
    if (const conditions::CoefficientFormula* formula = names.find(row, static_cast<int>(p)))
      term["name"] = formula_text(*formula, names.symbols);
    terms.push_back(std::move(term));
  }
  return terms;
}

files::ReportFields<OrderLine> line_fields(const ConditionsReportData& view) {
  const Conditions& rows = view.order_conditions.conditions;
  return {{[](const OrderLine& line) { return fmt::format("{} {}", describe_line(line), harmonic_name(line)); },
           Hdf5Dataset{"part of an order", "order_row"}},
          {[](const OrderLine& line) { return line.order->trajectory; }, JsonKey{"trajectory"}, Hdf5Dataset{"motion"}},
          {[](const OrderLine& line) { return line.order->number; }, JsonKey{"order"}, SiUnit{"1"},
           Hdf5Dataset{"periods per turn"}},
          {[](const OrderLine& line) -> Json {
             return line.order->part == results::OrderPart::whole     ? Json(nullptr)
                    : line.order->part == results::OrderPart::forward ? Json("forward")
                                                                      : Json("backward");
           },
           JsonKey{"direction"}},
          {[](const OrderLine& line) { return line.row->quantity; }, JsonKey{"quantity"}, Hdf5Dataset{"quantity"}},
          {[](const OrderLine& line) { return harmonic_name(line); }, JsonKey{"harmonic"}, Hdf5Dataset{"cos or sin"}},
          {[](const OrderLine& line) { return line.amplitude; }, JsonKey{"amplitude"},
           Hdf5Dataset{"amplitude for the numbers of the mechanism"}},
          {[](const OrderLine& line) { return line.unit; }, JsonKey{"unit"}, Hdf5Dataset{"unit of the amplitude"}},
          {[](const OrderLine& line) { return line.condition < 0; }, JsonKey{"always_zero"}},
          {[&](const OrderLine& line) -> Json {
             return line.condition < 0 ? Json(nullptr) : Json(view.order_conditions.factors[line.condition]);
           },
           JsonKey{"factor"}},
          {[&](const OrderLine& line) -> Json {
             return line.condition < 0 ? Json(nullptr) : Json(condition_text(rows, line.condition, view.order_names));
           },
           JsonKey{"text"}},
          {[&](const OrderLine& line) {
             return line.condition < 0 ? Json::array() : terms_json(rows, line.condition, view.order_names);
           },
           JsonKey{"terms"}}};
}

Json motion_json(const conditions::OrderMotion& motion) {
  return {{"trajectory", motion.trajectory},
          {"coordinate", motion.turning.coordinate},
          {"speed", motion.turning.speed},
          {"turns", motion.turning.turns},
          {"samples", motion.samples},
          {"spectral_error", motion.spectral_error},
          {"known_term_error", motion.known_term_error}};
}

}  // namespace

void evaluate_orders(ConditionsReportData& view, const Mechanism& mechanism, const ConditionOptions& options) {
  const std::vector<conditions::OrderRow>& rows = view.conditions.orders.rows;
  view.order_amplitudes.resize(static_cast<Eigen::Index>(rows.size()));
  if (rows.empty()) return;
  view.order_conditions = list_order_conditions(mechanism, view.conditions, options);
  view.order_amplitudes = evaluate_order_rows(mechanism, view.conditions, options);
}

void name_orders(ConditionsReportData& view, const Mechanism& mechanism,
                 const std::vector<conditions::GeometricSymbol>& symbols, const ConditionOptions& options,
                 const std::vector<CoordinateValue>& start) {
  if (view.order_conditions.rows.empty()) return;
  view.order_names =
      name_coefficients(mechanism, view.order_conditions.conditions, symbols, [&](const Mechanism& changed) {
        return rederive_order_conditions(simulation::assembled_at(changed, start), view.order_conditions, options);
      });
}

std::string orders_text(const ConditionsReportData& view, const files::TextOptions& options) {
  if (view.conditions.orders.rows.empty()) return "";
  std::string text = "\n";
  for (const conditions::OrderMotion& motion : view.conditions.orders.motions)
    text += motion_text(motion, options.units);
  const std::vector<OrderLine> lines = list_lines(view);
  const ConditionsReportData rows = convert_coefficients(make_row_view(view), options.units);
  constexpr std::size_t indentation = 4, min_width = 30;
  const std::size_t width = std::max(min_width, options.width - std::min(options.width, indentation));
  for (const OrderLine& line : lines) {
    if (line.condition < 0) continue;
    text += fmt::format("{}, {}: now {}, vanishes if\n", describe_line(line), harmonic_name(line),
                        amplitude_text(line, options.units));
    for (const std::string& part : wrap_condition(rows, line.condition, width))
      text += fmt::format("{:{}}{}\n", "", indentation, part);
  }
  if (const std::string symbols = symbols_text(rows, options.units); !symbols.empty())
    text += "where " + symbols + "\n";
  return text + format_vanishing(lines) + "\n";
}

void add_orders(Json& json, const ConditionsReportData& view) {
  if (view.conditions.orders.rows.empty()) return;
  json["orders"] = {{"motions", files::list_json(view.conditions.orders.motions, motion_json)},
                    {"rows", rows_json(list_lines(view), line_fields(view))}};
}

void write_order_rows(hdf5::Hdf5Writer& file, const ConditionsReportData& view) {
  if (view.conditions.orders.rows.empty()) return;
  const hdf5::Hdf5Writer::Group group = file.add_group("orders");
  write_rows(file, group, list_lines(view), line_fields(view));
}

}  // namespace balance::reports
