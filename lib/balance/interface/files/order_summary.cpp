#include "balance/interface/files/order_summary.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/report_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace balance::files {

namespace {

using results::OrderAnalysis;
using results::QuantityOrders;

constexpr double shown_part = 1e-6;     ///< of a quantity's largest order, in text
constexpr double phase_epsilon = 1e-9;  ///< [rad]
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// One order of a scalar, of a component, or of a vector as a whole.
struct OrderRow {
  std::string quantity, component, unit;
  double order = 0;
  double mean = unknown, cosine = unknown, sine = unknown;  ///< unknown of a vector as a whole
  double amplitude = 0;
  double phase = unknown;                        ///< amplitude · cos(nθ − phase) [rad]
  double forward = unknown, backward = unknown;  ///< of a vector in the plane
  double share = 0;
  double round_off = 0, largest = 0;  ///< of the quantity: what is round-off, and the largest of all orders

  std::string name() const { return component.empty() ? quantity : quantity + "[" + component + "]"; }
};

/// In (−π, π]; round-off does not turn π into −π.
double find_phase(const OrderRow& row) {
  if (!(row.amplitude > row.round_off)) return 0;
  const double phase = elementary::atan2(row.sine, row.cosine);
  if (std::abs(phase) < phase_epsilon) return 0;
  return std::numbers::pi + phase < phase_epsilon ? std::numbers::pi : phase;
}

std::vector<OrderRow> list_order_rows(const OrderAnalysis& analysis) {
  std::vector<OrderRow> rows;
  for (const QuantityOrders& quantity : analysis.quantities) {
    const auto components = static_cast<Eigen::Index>(quantity.components.size());
    double largest = 0;
    for (Eigen::Index n = 0; n < quantity.cosine.rows(); ++n) largest = std::max(largest, quantity.peak(n));
    for (Eigen::Index n = 0; n < quantity.cosine.rows(); ++n) {
      OrderRow row{.quantity = quantity.quantity, .component = "", .unit = quantity.unit};
      row.order = analysis.orders[static_cast<std::size_t>(n)];
      row.share = quantity.share(n), row.round_off = quantity.round_off, row.largest = largest;
      if (components > 0) {
        row.amplitude = quantity.peak(n);
        if (components == 2) {
          const results::RotatingParts parts = split_rotation(quantity, n);
          row.forward = parts.forward, row.backward = parts.backward;
        }
        rows.push_back(row);
        row.forward = row.backward = unknown;
      }
      for (Eigen::Index c = 0; c < std::max<Eigen::Index>(1, components); ++c) {
        if (components > 0) row.component = quantity.components[static_cast<std::size_t>(c)];
        row.mean = quantity.mean[c], row.cosine = quantity.cosine(n, c), row.sine = quantity.sine(n, c);
        row.amplitude = quantity.amplitude(n, c);
        row.phase = find_phase(row);
        row.share = quantity.variance > 0 ? row.amplitude * row.amplitude / 2 / quantity.variance : 0;
        rows.push_back(row);
      }
    }
  }
  return rows;
}

ReportFields<OrderRow> order_fields() {
  return {
      {[](const OrderRow& row) { return fmt::format("{} order {:g}", row.name(), row.order); },
       Hdf5Dataset{"quantity and order", "row"}},
      {&OrderRow::quantity, JsonKey{"quantity"}, Hdf5Dataset{"quantity"}},
      {&OrderRow::component, JsonKey{"component"}, Hdf5Dataset{"component of a vector; empty: a scalar, or the whole"}},
      {&OrderRow::name, TextColumn{"quantity"}},
      {&OrderRow::unit, JsonKey{"unit"}, TextColumn{}, unit_name_or_1, Hdf5Dataset{"unit of the quantity"}},
      {&OrderRow::order, JsonKey{"order"}, TextColumn{{}, "{:g}"}, SiUnit{"1"}, Hdf5Dataset{"periods per turn"}},
      {&OrderRow::mean, JsonKey{"mean"}, Hdf5Dataset{"mean over all turns"}},
      {&OrderRow::cosine, JsonKey{"cosine"}, Hdf5Dataset{"coefficient of the cosine of order times angle"}},
      {&OrderRow::sine, JsonKey{"sine"}, Hdf5Dataset{"coefficient of the sine of order times angle"}},
      {&OrderRow::amplitude, JsonKey{"amplitude"}, TextColumn{{}, six_digits},
       Hdf5Dataset{"peak value: amplitude, or major semi-axis of a vector's ellipse"}},
      {&OrderRow::phase, JsonKey{"phase"}, TextColumn{{}, "{:.4f}"}, SiUnit{"rad"},
       Hdf5Dataset{"angle at which a cosine of this order and phase has its peak, times the order"}},
      {&OrderRow::forward, JsonKey{"forward"}, TextColumn{{}, six_digits},
       Hdf5Dataset{"part of a plane vector that turns with the angle"}},
      {&OrderRow::backward, JsonKey{"backward"}, TextColumn{{}, six_digits},
       Hdf5Dataset{"part of a plane vector that turns against the angle"}},
      {&OrderRow::share, JsonKey{"share"}, TextColumn{{}, "{:.4f}"}, SiUnit{"1"},
       Hdf5Dataset{"part of the mean square of what varies"}}};
}

ReportFields<results::SpeedFluctuation> fluctuation_fields() {
  using results::SpeedFluctuation;
  return {{&SpeedFluctuation::mean_torque, JsonKey{"mean_torque"}, SiUnit{"N m"},
           Hdf5Dataset{"mean torque of the actuator"}},
          {&SpeedFluctuation::energy_range, JsonKey{"energy_range"}, SiUnit{"J"},
           Hdf5Dataset{"largest minus smallest kinetic energy if the actuator exerts its mean torque"}},
          {&SpeedFluctuation::coefficient, JsonKey{"coefficient"}, SiUnit{"1"},
           Hdf5Dataset{"coefficient of fluctuation of the speed, without a flywheel"}},
          {&SpeedFluctuation::largest, JsonKey{"largest"}, SiUnit{"rad/s"},
           Hdf5Dataset{"largest speed, without a flywheel"}},
          {&SpeedFluctuation::smallest, JsonKey{"smallest"}, SiUnit{"rad/s"},
           Hdf5Dataset{"smallest speed, without a flywheel"}}};
}

std::string format_fluctuation(const OrderAnalysis& analysis, const specification::SpecUnits& units) {
  const results::SpeedFluctuation& fluctuation = *analysis.fluctuation;
  const DisplayUnit torque = find_display_unit("N m", units), energy = find_display_unit("J", units),
                    inertia = find_display_unit("kg m^2", units);
  const std::string speed =
      std::isfinite(fluctuation.coefficient)
          ? fmt::format("the speed fluctuates by {:.4g} % of its mean", 100 * fluctuation.coefficient)
          : "the machine comes to rest without a flywheel";
  std::string text = fmt::format("if the actuator exerts its mean torque, {} {}, {}; the energy fluctuates by {} {}\n",
                                 format_number(torque.convert(fluctuation.mean_torque)), torque.name, speed,
                                 format_number(energy.convert(fluctuation.energy_range)), energy.name);
  if (fluctuation.flywheel)
    text += fmt::format("flywheel on {} for the stated fluctuation: {} {}\n", analysis.turning.coordinate,
                        format_number(inertia.convert(*fluctuation.flywheel)), inertia.name);
  return text;
}

bool is_main(const OrderRow& row) {
  return row.quantity.starts_with("torque[") || row.quantity.starts_with("force[") || row.quantity == "shaking_force" ||
         row.quantity == "shaking_moment";
}

}  // namespace

std::string format_orders(const OrderAnalysis& analysis, const TextOptions& options) {
  const DisplayUnit speed = find_display_unit("rad/s", options.units);
  const results::UniformTurning& turning = analysis.turning;
  std::string text = fmt::format(
      "orders of the angle of {}, which makes {} at {:.6g} {}; amplitudes are peak values\n\n", turning.coordinate,
      count_noun(turning.turns, "turn", "turns"), speed.convert(turning.speed), speed.name);
  if (analysis.fluctuation) text += format_fluctuation(analysis, options.units) + "\n";
  text = wrap_lines(text, options.width);
  std::vector<OrderRow> shown;
  for (const OrderRow& row : list_order_rows(analysis)) {
    if ((options.verbose || is_main(row)) && row.amplitude > row.round_off && row.amplitude > shown_part * row.largest)
      shown.push_back(row);
  }
  if (shown.empty()) return text + "nothing varies beyond round-off\n";
  TextTable table = rows_table(shown, order_fields(), options.units);
  table.key_columns = 3;
  return text + format_table(table, options.width);
}

Json orders_json(const OrderAnalysis& analysis) {
  Json json = {{"coordinate", analysis.turning.coordinate},
               {"speed", analysis.turning.speed},
               {"turns", analysis.turning.turns},
               {"rows", rows_json(list_order_rows(analysis), order_fields())}};
  if (!analysis.fluctuation) return json;
  json["fluctuation"] = fields_json(*analysis.fluctuation, fluctuation_fields());
  if (analysis.fluctuation->flywheel) json["fluctuation"]["flywheel"] = *analysis.fluctuation->flywheel;
  return json;
}

void write_orders(hdf5::Hdf5Writer& file, hdf5::Hdf5Writer::Group parent, const OrderAnalysis& analysis) {
  const hdf5::Hdf5Writer::Group group = file.add_group(parent, "orders");
  file.set_attribute(group, "coordinate", analysis.turning.coordinate);
  file.set_attribute(group, "speed", fmt::format("{} rad/s", analysis.turning.speed));
  file.set_attribute(group, "turns", fmt::format("{}", analysis.turning.turns));
  write_rows(file, group, list_order_rows(analysis), order_fields(), "mixed", std::nullopt);
  if (!analysis.fluctuation) return;
  write_fields(file, group, *analysis.fluctuation, fluctuation_fields());
  if (analysis.fluctuation->flywheel)
    file.add_variable(group, {"flywheel", "inertia of a flywheel for the stated coefficient", "kg m^2", {}, {}},
                      {&*analysis.fluctuation->flywheel, 1});
}

}  // namespace balance::files
