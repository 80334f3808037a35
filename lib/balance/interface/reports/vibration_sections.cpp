#include "balance/interface/reports/vibration_sections.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/order_summary.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/interface/files/result_group.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace balance::reports {

using files::TextOptions;
using hdf5::Hdf5Writer;
using vibration::ForcedResponse;
using vibration::Reference;
using vibration::SpeedSweep;
using vibration::SweepPoint;
using vibration::VibrationMode;
using vibration::VibrationModes;

namespace {

constexpr double max_hidden_share =
    1e-6;  ///< of the largest number: smaller entries of a shape or amplitudes are left out
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

const Coordinate& coordinate_of(const VibrationModes& modes, const Mechanism& mechanism, std::size_t k) {
  return mechanism.coordinates[modes.motion.coordinates[k]];
}

std::vector<std::string> coordinate_names(const VibrationModes& modes, const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < modes.motion.coordinates.size(); ++k)
    names.push_back(coordinate_of(modes, mechanism, k).name);
  return names;
}

/// "F.x 1 m, F.y 0.35 m at 90 deg"
std::string shape_text(const VibrationMode& mode, const VibrationModes& modes, const Mechanism& mechanism,
                       const TextOptions& options) {
  std::string text;
  for (std::size_t k = 0; k < modes.motion.coordinates.size(); ++k) {
    const Coordinate& coordinate = coordinate_of(modes, mechanism, k);
    const auto row = static_cast<Eigen::Index>(k);
    const bool is_length = coordinate.kind == CoordinateKind::length;
    const std::complex<double> entry = mode.shape[row];
    if (std::abs(entry) <= max_hidden_share * modes.motion.unit[row]) continue;
    const files::DisplayUnit unit = files::find_display_unit(is_length ? "m" : "rad", options.units);
    const double phase = std::arg(entry) * 180 / std::numbers::pi;
    const bool is_opposite = std::abs(phase) > 180 - max_hidden_share;
    text += fmt::format("{}{} {:.4g} {}", text.empty() ? "" : ", ", coordinate.name,
                        (is_opposite ? -1 : 1) * unit.convert(std::abs(entry)), unit.name);
    if (std::abs(phase) > max_hidden_share && !is_opposite) text += fmt::format(" at {:.4g} deg", phase);
  }
  return text;
}

std::string mode_text(const VibrationMode& mode) {
  const double rate = mode.eigenvalue.real();
  if (mode.oscillates())
    return fmt::format("{:.6g} Hz, damping ratio {:.4g}", mode.frequency(),
                       std::abs(mode.damping_ratio()) <= max_hidden_share ? 0 : mode.damping_ratio());
  if (rate == 0) return "rigid motion";
  return rate < 0 ? fmt::format("decays by 1/e in {:.4g} s", -1 / rate)
                  : fmt::format("unstable: grows by e in {:.4g} s", 1 / rate);
}

/// "F.x = 0 m, F.y = 0.001 m"
std::string position_text(const VibrationModes& modes, const Mechanism& mechanism, const TextOptions& options) {
  std::string text;
  for (std::size_t k = 0; k < static_cast<std::size_t>(modes.motion.free_count); ++k) {
    const Coordinate& coordinate = coordinate_of(modes, mechanism, k);
    const double value = modes.motion.position[static_cast<Eigen::Index>(k)];
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", coordinate.name,
                        coordinate.kind == CoordinateKind::length
                            ? model::format_length(value, options.units, model::pose_round_off)
                            : model::format_angle(value, options.units, model::pose_round_off));
  }
  return text;
}

std::string join_names(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::string text;
  for (const CoordinateId coordinate : coordinates)
    text += (text.empty() ? "" : ", ") + mechanism.coordinates[coordinate].name;
  return text;
}

Json complex_json(const std::complex<double>& value) { return Json{value.real(), value.imag()}; }

}  // namespace

Json vibration_json(const VibrationModes& modes, const Mechanism& mechanism) {
  const vibration::LinearMotion& motion = modes.motion;
  Json json = {{"trajectory", modes.trajectory}, {"outcome", files::outcome_json(motion.outcome)}};
  json["reference"] = motion.reference == Reference::rest ? "rest" : "steady";
  json["equilibrium"] = Json::object();
  json["modes"] = Json::array();
  if (motion.outcome.status != MotionStatus::done) return json;
  const std::vector<std::string> names = coordinate_names(modes, mechanism);
  for (std::size_t k = 0; k < names.size(); ++k)
    json["equilibrium"][names[k]] = motion.position[static_cast<Eigen::Index>(k)];
  json["rates"] = Json::object();
  for (Eigen::Index k = 0; k < motion.free_count; ++k)
    json["rates"][names[static_cast<std::size_t>(k)]] = motion.rate[k];
  json["stability"] = name_of(modes.stability());
  json["variation"] = motion.variation;
  json["ignored"] = files::list_json(motion.ignored, [&](CoordinateId c) { return mechanism.coordinates[c].name; });
  for (const VibrationMode& mode : modes.modes) {
    Json one = {{"eigenvalue", complex_json(mode.eigenvalue)},
                {"frequency", mode.frequency()},
                {"damping_ratio", mode.damping_ratio()},
                {"shape", Json::object()}};
    for (std::size_t k = 0; k < names.size(); ++k)
      one["shape"][names[k]] = complex_json(mode.shape[static_cast<Eigen::Index>(k)]);
    json["modes"].push_back(std::move(one));
  }
  json["eigenvalues"] = files::list_json(modes.eigenvalues, complex_json);
  return json;
}

namespace {

/// Of the linear motion, without the coordinates.
std::string reference_text(const VibrationModes& modes) {
  return modes.motion.reference == Reference::rest ? "about the equilibrium" : "about the steady motion";
}

std::string format_property(const std::string& label, const std::string& value, std::size_t label_width,
                            std::size_t width) {
  const std::string begin = fmt::format("{:<{}} ", label, label_width - 1);
  std::string text;
  for (const std::string& line : files::wrap_cell(value, width > begin.size() + 20 ? width - begin.size() : 20))
    text += (text.empty() ? begin : std::string(label_width, ' ')) + line + "\n";
  return text;
}

}  // namespace

std::string vibration_text(const VibrationModes& modes, const Mechanism& mechanism, const std::string& label,
                           std::size_t label_width, const TextOptions& options) {
  const vibration::LinearMotion& motion = modes.motion;
  if (motion.outcome.status != MotionStatus::done)
    return format_property(label, fmt::format("of {}: {}", modes.trajectory, motion.outcome.reason), label_width,
                           options.width);
  std::string text = format_property(label,
                                     fmt::format("of what {} leaves free, linearised {} {}", modes.trajectory,
                                                 reference_text(modes), position_text(modes, mechanism, options)),
                                     label_width, options.width);
  for (std::size_t k = 0; k < modes.modes.size(); ++k)
    text += format_property(
        fmt::format("  {}", k + 1),
        fmt::format("{}: {}", mode_text(modes.modes[k]), shape_text(modes.modes[k], modes, mechanism, options)),
        label_width, options.width);
  return text;
}

// Modes as a table.

namespace {

struct ModeRow {
  int number;
  const VibrationMode* mode;
  std::string shape;
};

double or_unknown(bool is_known, double value) { return is_known ? value : unknown; }

ReportFields<ModeRow> mode_fields() {
  return {
      {&ModeRow::number, JsonKey{"mode"}, TextColumn{}, Hdf5Dataset{"by increasing size of the eigenvalue"},
       SiUnit{"1"}},
      {[](const ModeRow& row) { return row.mode->eigenvalue.real(); }, JsonKey{"real"},
       TextColumn{"real part", "{:.6g}"}, SiUnit{"1/s"}, Hdf5Dataset{"real part of the eigenvalue", "eigenvalue_real"}},
      {[](const ModeRow& row) { return row.mode->eigenvalue.imag(); }, JsonKey{"imaginary"}, SiUnit{"rad/s"},
       Hdf5Dataset{"imaginary part of the eigenvalue: damped angular frequency", "eigenvalue_imaginary"}},
      {[](const ModeRow& row) { return or_unknown(row.mode->oscillates(), row.mode->frequency()); },
       JsonKey{"frequency"}, TextColumn{{}, "{:.6g}"}, SiUnit{"Hz"},
       Hdf5Dataset{"damped frequency; NaN: no oscillation"}},
      {[](const ModeRow& row) { return or_unknown(std::abs(row.mode->eigenvalue) > 0, row.mode->damping_ratio()); },
       JsonKey{"damping_ratio"}, TextColumn{"damping ratio", "{:.4g}"}, SiUnit{"1"},
       Hdf5Dataset{"minus real part over size of the eigenvalue; NaN: rigid motion"}},
      {&ModeRow::shape, JsonKey{"shape_text"}, TextColumn{"shape"}}};
}

std::vector<ModeRow> list_mode_rows(const VibrationModes& modes, const Mechanism& mechanism,
                                    const TextOptions& options) {
  std::vector<ModeRow> rows;
  for (std::size_t k = 0; k < modes.modes.size(); ++k)
    rows.push_back({static_cast<int>(k + 1), &modes.modes[k],
                    (modes.modes[k].oscillates() || modes.modes[k].eigenvalue != 0.0 ? "" : "rigid motion: ") +
                        shape_text(modes.modes[k], modes, mechanism, options)});
  return rows;
}

std::string stability_text(const VibrationModes& modes) {
  switch (modes.stability()) {
    case vibration::Stability::stable: return "stable: every deviation decays";
    case vibration::Stability::marginal: return "marginal: nothing grows, but not everything decays";
    case vibration::Stability::unstable: return "unstable: a deviation grows";
  }
  return "";
}

std::string modes_section(const VibrationReportData& view, const TextOptions& options) {
  const VibrationModes& modes = view.modes;
  const vibration::LinearMotion& motion = modes.motion;
  std::string text = fmt::format("{}{}: vibration modes, linearised {} {}\n", view.mechanism.name,
                                 modes.trajectory.empty() ? "" : ", " + modes.trajectory, reference_text(modes),
                                 position_text(modes, view.mechanism, options));
  text += stability_text(modes) + "\n";
  if (!motion.ignored.empty())
    text += fmt::format("nothing depends on {}, which follow\n", join_names(view.mechanism, motion.ignored));
  if (motion.variation > 0)
    text += fmt::format(
        "note: the linearised equations change along the motion, by up to {:.2g} % of their largest coefficient; the "
        "modes are "
        "those of their averages\n",
        100 * motion.variation);
  if (!motion.note.empty()) text += "note: " + motion.note + "\n";
  files::TextTable table = rows_table(list_mode_rows(modes, view.mechanism, options), mode_fields(), options.units);
  return files::wrap_lines(text, options.width) + "\n" + files::format_table(table, options.width);
}

// The response.

struct ResponseRow {
  std::string quantity, unit;
  double order = 0, linear = 0, exact = unknown, difference = unknown;
};

std::vector<ResponseRow> list_response_rows(const ForcedResponse& response) {
  std::vector<ResponseRow> rows;
  for (std::size_t q = 0; q < response.linear.size(); ++q)
    for (std::size_t n = 0; n < response.orders.size(); ++n) {
      const auto order = static_cast<Eigen::Index>(n);
      ResponseRow row{response.linear[q].quantity, response.linear[q].unit, response.orders[n],
                      response.linear[q].peak(order)};
      if (!response.exact.empty()) {
        row.exact = response.exact[q].peak(order);
        row.difference = response.difference(static_cast<Eigen::Index>(q), order);
      }
      rows.push_back(std::move(row));
    }
  return rows;
}

ReportFields<ResponseRow> response_fields() {
  return {
      {[](const ResponseRow& row) { return fmt::format("{} order {:g}", row.quantity, row.order); },
       Hdf5Dataset{"quantity and order", "row"}},
      {&ResponseRow::quantity, JsonKey{"quantity"}, TextColumn{}, Hdf5Dataset{"quantity"}},
      {&ResponseRow::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name_or_1, Hdf5Dataset{"unit of the quantity"}},
      {&ResponseRow::order, JsonKey{"order"}, TextColumn{{}, "{:g}"}, SiUnit{"1"}, Hdf5Dataset{"periods per turn"}},
      {&ResponseRow::linear, JsonKey{"linear"}, TextColumn{{}, files::six_digits},
       Hdf5Dataset{"peak value of the linearised motion"}},
      {&ResponseRow::exact, JsonKey{"exact"}, TextColumn{{}, files::six_digits},
       Hdf5Dataset{"peak value of the periodic motion; NaN: not computed"}},
      {&ResponseRow::difference, JsonKey{"difference"}, TextColumn{{}, "{:.1e}"}, SiUnit{"1"},
       Hdf5Dataset{"difference as a part of the largest exact order of the quantity"}}};
}

struct TransmissibilityRow {
  double order, excitation, transmitted, ratio;
};

std::vector<TransmissibilityRow> list_transmissibility(const ForcedResponse& response) {
  std::vector<TransmissibilityRow> rows;
  const auto force = std::find_if(response.linear.begin(), response.linear.end(),
                                  [](const auto& one) { return one.quantity == "ground_force"; });
  for (std::size_t n = 0; n < response.orders.size() && force != response.linear.end(); ++n) {
    const auto order = static_cast<Eigen::Index>(n);
    rows.push_back(
        {response.orders[n], response.excitation.peak(order), force->peak(order), response.transmissibility(order)});
  }
  return rows;
}

ReportFields<TransmissibilityRow> transmissibility_fields() {
  using Row = TransmissibilityRow;
  return {{&Row::order, JsonKey{"order"}, TextColumn{{}, "{:g}"}, SiUnit{"1"}, Hdf5Dataset{"periods per turn"}},
          {&Row::excitation, JsonKey{"excitation"}, TextColumn{{}, files::six_digits}, SiUnit{"N"},
           Hdf5Dataset{"force on the ground with the free coordinates at rest"}},
          {&Row::transmitted, JsonKey{"transmitted"}, TextColumn{{}, files::six_digits}, SiUnit{"N"},
           Hdf5Dataset{"force on the ground, linear"}},
          {&Row::ratio, JsonKey{"transmissibility"}, TextColumn{{}, files::six_digits}, SiUnit{"1"},
           Hdf5Dataset{"transmitted over excitation; NaN: nothing excites"}}};
}

std::string exactness_text(const ForcedResponse& response) {
  if (response.exact.empty())
    return response.exact_outcome.reason.empty()
               ? "the figures are linear; the exact motion was not computed"
               : "the figures are linear; there is no exact motion to compare with: " + response.exact_outcome.reason;
  double largest = 0;
  for (const ResponseRow& row : list_response_rows(response)) largest = std::max(largest, row.difference);
  return fmt::format(
      "linear figures are those of the linearised motion, exact ones of the periodic motion, found by shooting; they "
      "differ "
      "by at most {:.2g} % of the largest order of a quantity",
      100 * largest);
}

std::string response_section(const ForcedResponse& response, const TextOptions& options) {
  const files::DisplayUnit speed = files::find_display_unit("rad/s", options.units);
  std::string text = fmt::format("response to {} at {:.6g} {}, orders of its angle, peak values\n",
                                 response.turning.coordinate, speed.convert(response.turning.speed), speed.name);
  if (response.outcome.status != MotionStatus::done)
    return files::wrap_lines(text + response.outcome.reason + "\n", options.width);
  text += exactness_text(response) + "\n";
  text = files::wrap_lines(text, options.width) + "\n";
  std::vector<ResponseRow> shown;
  std::vector<ResponseRow> rows = list_response_rows(response);
  for (const ResponseRow& row : rows) {
    double largest = 0;
    for (const ResponseRow& other : rows)
      if (other.quantity == row.quantity)
        largest = std::max({largest, other.linear, std::isnan(other.exact) ? 0 : other.exact});
    if (std::max(row.linear, std::isnan(row.exact) ? 0 : row.exact) > max_hidden_share * largest) shown.push_back(row);
  }
  if (shown.empty()) return text + "nothing moves beyond round-off\n";
  files::TextTable table = rows_table(shown, response_fields(), options.units);
  table.key_columns = 3;
  text += files::format_table(table, options.width) + "\ntransmission to the ground (linear)\n\n";
  std::vector<TransmissibilityRow> transmitted;
  for (const TransmissibilityRow& row : list_transmissibility(response))
    if (!std::isnan(row.ratio)) transmitted.push_back(row);
  if (transmitted.empty()) return text + "nothing excites\n";
  return text + files::format_table(rows_table(transmitted, transmissibility_fields(), options.units), options.width);
}

Json response_json(const ForcedResponse& response) {
  Json json = {{"coordinate", response.turning.coordinate},
               {"speed", response.turning.speed},
               {"turns", response.turning.turns},
               {"outcome", files::outcome_json(response.outcome)}};
  if (response.outcome.status != MotionStatus::done) return json;
  json["rows"] = rows_json(list_response_rows(response), response_fields());
  json["transmission"] = rows_json(list_transmissibility(response), transmissibility_fields());
  json["linear"] = files::orders_json({response.turning, response.orders, response.linear, {}})["rows"];
  json["exact_outcome"] = response.exact_outcome.reason.empty() && response.exact.empty()
                              ? Json()
                              : files::outcome_json(response.exact_outcome);
  json["exact"] = response.exact.empty()
                      ? Json()
                      : files::orders_json({response.turning, response.orders, response.exact, {}})["rows"];
  return json;
}

// The sweep.

ReportFields<vibration::StabilityChange> stability_fields() {
  using Row = vibration::StabilityChange;
  return {{&Row::value, JsonKey{"value"}, TextColumn{"at", "{:.10g}"}, Hdf5Dataset{"value at which stability changes"},
           SiUnit{"1"}},
          {[](const Row& row) { return std::abs(row.eigenvalue.imag()) > 0 ? "oscillation" : "divergence"; },
           JsonKey{"kind"}, TextColumn{"what"}, Hdf5Dataset{"what begins or ends"}},
          {[](const Row& row) { return row.is_unstable_above ? "grows above" : "decays above"; }, JsonKey{"above"},
           TextColumn{"above"}, Hdf5Dataset{"what it does at larger values"}},
          {[](const Row& row) { return row.eigenvalue.imag() / (2 * std::numbers::pi); }, JsonKey{"frequency"},
           TextColumn{{}, "{:.6g}"}, SiUnit{"Hz"}, Hdf5Dataset{"of the oscillation; 0: divergence"}}};
}

ReportFields<vibration::CriticalSpeed> critical_fields() {
  using Row = vibration::CriticalSpeed;
  return {{&Row::value, JsonKey{"value"}, TextColumn{"at", "{:.9g}"}, Hdf5Dataset{"value of the sweep"}, SiUnit{"1"}},
          {&Row::order, JsonKey{"order"}, TextColumn{{}, "{:g}"}, SiUnit{"1"},
           Hdf5Dataset{"order whose frequency is that of a mode"}},
          {&Row::frequency, JsonKey{"frequency"}, TextColumn{{}, "{:.6g}"}, SiUnit{"Hz"}, Hdf5Dataset{"of both"}},
          {&Row::damping_ratio, JsonKey{"damping_ratio"}, TextColumn{"damping ratio", "{:.4g}"}, SiUnit{"1"},
           Hdf5Dataset{"of the mode"}}};
}

/// The largest amplitude of an order within the sweep.
struct PeakRow {
  std::string quantity, unit;
  double order = 0, peak = 0, value = 0, difference = unknown;
};

std::vector<PeakRow> list_peaks(const SpeedSweep& sweep) {
  std::vector<PeakRow> rows;
  const auto first = std::find_if(sweep.points.begin(), sweep.points.end(), [](const SweepPoint& point) {
    return point.response && point.response->outcome.status == MotionStatus::done;
  });
  if (first == sweep.points.end()) return rows;
  for (std::size_t q = 0; q < first->response->linear.size(); ++q)
    for (std::size_t n = 0; n < first->response->orders.size(); ++n) {
      PeakRow row{first->response->linear[q].quantity, first->response->linear[q].unit, first->response->orders[n]};
      for (const SweepPoint& point : sweep.points) {
        if (!point.response || point.response->linear.size() <= q) continue;
        const auto order = static_cast<Eigen::Index>(n);
        const double peak = point.response->linear[q].peak(order);
        if (peak > row.peak) row.peak = peak, row.value = point.value;
        if (point.response->exact.empty()) continue;
        const double difference = point.response->difference(static_cast<Eigen::Index>(q), order);
        row.difference = std::isnan(row.difference) ? difference : std::max(row.difference, difference);
      }
      rows.push_back(std::move(row));
    }
  return rows;
}

ReportFields<PeakRow> peak_fields() {
  return {{&PeakRow::quantity, JsonKey{"quantity"}, TextColumn{}},
          {&PeakRow::unit, JsonKey{"unit"}, TextColumn{}, files::unit_name_or_1},
          {&PeakRow::order, JsonKey{"order"}, TextColumn{{}, "{:g}"}, SiUnit{"1"}},
          {&PeakRow::peak, JsonKey{"peak"}, TextColumn{"largest", files::six_digits}},
          {&PeakRow::value, JsonKey{"value"}, TextColumn{"at", "{:.6g}"}, SiUnit{"1"}},
          {&PeakRow::difference, JsonKey{"difference"}, TextColumn{"exact differs by", "{:.1e}"}, SiUnit{"1"}}};
}

std::string swept_text(const VibrationReportData& view) {
  return view.swept.name + (view.swept.unit.empty() ? "" : " [" + view.swept.unit + "]");
}

std::string sweep_section(const VibrationReportData& view, const TextOptions& options) {
  const SpeedSweep& sweep = *view.sweep;
  std::string text = fmt::format("sweep of {} from {:.6g} to {:.6g}, {} values\n", swept_text(view),
                                 sweep.points.front().value, sweep.points.back().value, sweep.points.size());
  const auto failures = std::count_if(sweep.points.begin(), sweep.points.end(), [](const SweepPoint& point) {
    return point.modes.motion.outcome.status != MotionStatus::done;
  });
  if (failures > 0)
    text += fmt::format("{} of them have no modes: {}\n", failures,
                        std::find_if(sweep.points.begin(), sweep.points.end(), [](const SweepPoint& point) {
                          return point.modes.motion.outcome.status != MotionStatus::done;
                        })->modes.motion.outcome.reason);
  text += sweep.stability_changes.empty()
              ? fmt::format("stability does not change: {}\n", name_of(sweep.points.front().modes.stability()))
              : "stability changes\n";
  text = files::wrap_lines(text, options.width);
  if (!sweep.stability_changes.empty())
    text += "\n" +
            files::format_table(rows_table(sweep.stability_changes, stability_fields(), options.units), options.width);
  if (!sweep.critical_speeds.empty())
    text += "\norders in resonance with modes (linear)\n\n" +
            files::format_table(rows_table(sweep.critical_speeds, critical_fields(), options.units), options.width);
  std::vector<PeakRow> peaks;
  const std::vector<PeakRow> all = list_peaks(sweep);
  for (const PeakRow& row : all) {
    double largest = 0;
    for (const PeakRow& other : all)
      if (other.quantity == row.quantity) largest = std::max(largest, other.peak);
    if (row.peak > max_hidden_share * largest) peaks.push_back(row);
  }
  if (peaks.empty()) return text;
  const auto exact = std::count_if(sweep.points.begin(), sweep.points.end(), [](const SweepPoint& point) {
    return point.response && !point.response->exact.empty();
  });
  text += "\n" +
          files::wrap_lines(
              fmt::format("largest response of every order (linear; the exact periodic motion was found at {} of the "
                          "values and differs there by at most the stated part of the quantity's largest order)\n\n",
                          exact),
              options.width);
  files::TextTable table = rows_table(peaks, peak_fields(), options.units);
  table.key_columns = 3;
  return text + files::format_table(table, options.width);
}

Json sweep_json(const VibrationReportData& view) {
  const SpeedSweep& sweep = *view.sweep;
  Json json = {{"name", view.swept.name}, {"unit", files::text_or_null(view.swept.unit)}};
  json["stability_changes"] = rows_json(sweep.stability_changes, stability_fields());
  json["critical_speeds"] = rows_json(sweep.critical_speeds, critical_fields());
  json["points"] = files::list_json(sweep.points, [&](const SweepPoint& point) {
    Json one = {{"value", point.value}, {"modes", vibration_json(point.modes, view.mechanism)}};
    one["response"] = point.response ? response_json(*point.response) : Json();
    return one;
  });
  return json;
}

}  // namespace

Json vibration_report_json(const VibrationReportData& view) {
  Json json = {{"mechanism", view.mechanism.name}};
  json.update(vibration_json(view.modes, view.mechanism));
  json["response"] = view.response ? response_json(*view.response) : Json();
  json["sweep"] = view.sweep ? sweep_json(view) : Json();
  json["warnings"] = view.warnings;
  return json;
}

std::string vibration_report_text(const VibrationReportData& view, const TextOptions& options) {
  std::string text = modes_section(view, options);
  if (view.response) text += "\n" + response_section(*view.response, options);
  if (view.sweep) text += "\n" + sweep_section(view, options);
  return text;
}

// The page.

std::string mode_title(const VibrationModes& modes, std::size_t k) {
  return fmt::format("mode {}: {}", k + 1, mode_text(modes.modes[k]));
}

namespace {

Json page_sweep_json(const VibrationReportData& view) {
  Json json = {{"label", swept_text(view)}};
  for (const char* key : {"values", "frequencies", "speeds", "transmissibility", "orders", "amplitudes"})
    json[key] = Json::array();
  const ForcedResponse* first = nullptr;
  for (const SweepPoint& point : view.sweep->points) {
    if (!point.response || point.response->linear.empty()) continue;
    const ForcedResponse& response = *point.response;
    if (first == nullptr) first = &response;
    json["values"].push_back(point.value);
    json["speeds"].push_back(response.turning.speed);
    Json frequencies = Json::array(), ratios = Json::array();
    for (const VibrationMode& mode : point.modes.modes)
      if (mode.oscillates()) frequencies.push_back(mode.frequency());
    for (std::size_t n = 0; n < response.orders.size(); ++n)
      ratios.push_back(response.transmissibility(static_cast<Eigen::Index>(n)));
    json["frequencies"].push_back(std::move(frequencies));
    json["transmissibility"].push_back(std::move(ratios));
  }
  if (first == nullptr) return {};
  json["orders"] = first->orders;
  for (std::size_t q = 0; q < first->linear.size(); ++q) {
    if (!first->linear[q].quantity.starts_with("joint_position")) continue;
    Json one = {{"quantity", first->linear[q].quantity}, {"unit", first->linear[q].unit}};
    one["linear"] = one["exact"] = Json::array();
    for (const SweepPoint& point : view.sweep->points) {
      if (!point.response || point.response->linear.empty()) continue;
      const auto peaks = [&](const std::vector<results::QuantityOrders>& list) {
        Json numbers = Json::array();
        for (Eigen::Index n = 0; n < static_cast<Eigen::Index>(first->orders.size()); ++n)
          numbers.push_back(list[q].peak(n));
        return numbers;
      };
      one["linear"].push_back(peaks(point.response->linear));
      one["exact"].push_back(point.response->exact.size() > q ? peaks(point.response->exact) : Json());
    }
    json["amplitudes"].push_back(std::move(one));
  }
  return json;
}

}  // namespace

Json vibration_page_json(const VibrationReportData& view) {
  Json json = vibration_json(view.modes, view.mechanism);
  for (std::size_t k = 0; k < view.modes.modes.size(); ++k)
    json["modes"][k]["text"] = shape_text(view.modes.modes[k], view.modes, view.mechanism, {});
  json["response"] = view.response ? response_json(*view.response) : Json();
  json["sweep"] = view.sweep ? page_sweep_json(view) : Json();
  return json;
}

// HDF5.

namespace {

using Dimension = Hdf5Writer::Dimension;

void write_modes(Hdf5Writer& file, const VibrationReportData& view) {
  const VibrationModes& modes = view.modes;
  const Hdf5Writer::Group group = file.add_group("modes");
  file.set_attribute(group, "reference", modes.motion.reference == Reference::rest ? "rest" : "steady");
  file.set_attribute(group, "stability", name_of(modes.stability()));
  const std::vector<std::string> names = coordinate_names(modes, view.mechanism);
  if (modes.modes.empty()) return;
  const Dimension mode = write_rows(file, group, list_mode_rows(modes, view.mechanism, {}), mode_fields());
  const Dimension coordinate = file.add_dimension(group, {"coordinate", "of the shapes", "1", {}, {}}, names);
  file.add_variable(group, {"position", "of the coordinates at the reference", "mixed", {coordinate}, {}},
                    hdf5::entries_of(modes.motion.position));
  Samples real(static_cast<Eigen::Index>(modes.modes.size()), static_cast<Eigen::Index>(names.size())),
      imaginary = real;
  for (std::size_t k = 0; k < modes.modes.size(); ++k) {
    real.row(static_cast<Eigen::Index>(k)) = modes.modes[k].shape.real().transpose();
    imaginary.row(static_cast<Eigen::Index>(k)) = modes.modes[k].shape.imag().transpose();
  }
  file.add_variable(group, {"shape_real", "real part of the shapes", "mixed", {mode, coordinate}, {}},
                    hdf5::entries_of(real));
  file.add_variable(group, {"shape_imaginary", "imaginary part of the shapes", "mixed", {mode, coordinate}, {}},
                    hdf5::entries_of(imaginary));
}

void write_response(Hdf5Writer& file, const ForcedResponse& response) {
  if (response.outcome.status != MotionStatus::done) return;
  const Hdf5Writer::Group group = file.add_group("response");
  file.set_attribute(group, "coordinate", response.turning.coordinate);
  file.set_attribute(group, "speed", fmt::format("{} rad/s", response.turning.speed));
  write_rows(file, group, list_response_rows(response), response_fields());
  write_rows(file, file.add_group(group, "transmission"), list_transmissibility(response), transmissibility_fields());
}

/// Amplitudes along a sweep; NaN where there is none.
class SweepAmplitudes {
 public:
  SweepAmplitudes(const SpeedSweep& sweep, std::size_t quantities, std::size_t orders)
      : sweep_(sweep), quantities_(quantities), orders_(orders) {}

  /// @param list of quantities of a response
  Samples list(std::vector<results::QuantityOrders> ForcedResponse::*list) const {
    Samples rows = empty(quantities_ * orders_);
    for (std::size_t p = 0; p < sweep_.points.size(); ++p) {
      const auto& response = sweep_.points[p].response;
      if (!response || ((*response).*list).size() != quantities_) continue;
      for (std::size_t q = 0; q < quantities_; ++q)
        for (std::size_t n = 0; n < orders_; ++n)
          rows(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(q * orders_ + n)) =
              ((*response).*list)[q].peak(static_cast<Eigen::Index>(n));
    }
    return rows;
  }

  Samples list_transmissibility() const {
    Samples rows = empty(orders_);
    for (std::size_t p = 0; p < sweep_.points.size(); ++p)
      if (const auto& response = sweep_.points[p].response; response && !response->linear.empty())
        for (std::size_t n = 0; n < orders_; ++n)
          rows(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(n)) =
              response->transmissibility(static_cast<Eigen::Index>(n));
    return rows;
  }

 private:
  Samples empty(std::size_t columns) const {
    return Samples::Constant(static_cast<Eigen::Index>(sweep_.points.size()), static_cast<Eigen::Index>(columns),
                             unknown);
  }

  const SpeedSweep& sweep_;
  std::size_t quantities_, orders_;
};

void write_sweep(Hdf5Writer& file, const VibrationReportData& view) {
  const SpeedSweep& sweep = *view.sweep;
  const Hdf5Writer::Group group = file.add_group("sweep");
  file.set_attribute(group, "name", view.swept.name);
  if (!view.swept.unit.empty()) file.set_attribute(group, "unit", view.swept.unit);
  VectorX values(static_cast<Eigen::Index>(sweep.points.size())), speeds = VectorX::Constant(values.size(), unknown);
  std::size_t count = 0;
  const ForcedResponse* first = nullptr;
  for (std::size_t p = 0; p < sweep.points.size(); ++p) {
    const SweepPoint& point = sweep.points[p];
    values[static_cast<Eigen::Index>(p)] = point.value;
    count = std::max(count, point.modes.eigenvalues.size());
    if (!point.response) continue;
    speeds[static_cast<Eigen::Index>(p)] = point.response->turning.speed;
    if (first == nullptr && !point.response->linear.empty()) first = &*point.response;
  }
  const Dimension value = file.add_dimension(group, {"value", "of what is swept, in the spec's units", "mixed", {}, {}},
                                             hdf5::entries_of(values));
  if (count > 0) {
    std::vector<std::string> numbers;
    for (std::size_t k = 0; k < count; ++k) numbers.push_back(std::to_string(k + 1));
    const Dimension eigenvalue =
        file.add_dimension(group, {"eigenvalue", "by decreasing real part", "1", {}, {}}, numbers);
    Samples real = Samples::Constant(values.size(), static_cast<Eigen::Index>(count), unknown), imaginary = real;
    for (std::size_t p = 0; p < sweep.points.size(); ++p)
      for (std::size_t k = 0; k < sweep.points[p].modes.eigenvalues.size(); ++k) {
        real(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(k)) = sweep.points[p].modes.eigenvalues[k].real();
        imaginary(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(k)) =
            sweep.points[p].modes.eigenvalues[k].imag();
      }
    file.add_variable(group, {"eigenvalue_real", "real part", "1/s", {value, eigenvalue}, {}}, hdf5::entries_of(real));
    file.add_variable(group, {"eigenvalue_imaginary", "imaginary part", "rad/s", {value, eigenvalue}, {}},
                      hdf5::entries_of(imaginary));
  }
  if (!sweep.stability_changes.empty())
    write_rows(file, file.add_group(group, "stability_changes"), sweep.stability_changes, stability_fields());
  if (!sweep.critical_speeds.empty())
    write_rows(file, file.add_group(group, "critical_speeds"), sweep.critical_speeds, critical_fields());
  if (first == nullptr) return;
  std::vector<std::string> quantities;
  for (const results::QuantityOrders& one : first->linear) quantities.push_back(one.quantity);
  file.add_variable(group, {"speed", "of the joint that turns", "rad/s", {value}, {}}, hdf5::entries_of(speeds));
  const Dimension quantity = file.add_dimension(group, {"quantity", "of the response", "1", {}, {}}, quantities),
                  order = file.add_dimension(group, {"order", "periods per turn", "1", {}, {}}, first->orders);
  const SweepAmplitudes amplitudes(sweep, quantities.size(), first->orders.size());
  file.add_variable(group,
                    {"linear", "peak values of the linearised motion, SI", "mixed", {value, quantity, order}, {}},
                    hdf5::entries_of(amplitudes.list(&ForcedResponse::linear)));
  file.add_variable(
      group,
      {"exact", "peak values of the periodic motion, SI; NaN: not computed", "mixed", {value, quantity, order}, {}},
      hdf5::entries_of(amplitudes.list(&ForcedResponse::exact)));
  file.add_variable(group,
                    {"transmissibility", "of the ground force, linear; NaN: nothing excites", "1", {value, order}, {}},
                    hdf5::entries_of(amplitudes.list_transmissibility()));
}

}  // namespace

void write_vibration_report(const std::string& path, const VibrationReportData& view,
                            const files::Provenance& description, const files::WriteOptions& options) {
  files::write_hdf5_file(path, description, options, [&](Hdf5Writer& file) {
    file.set_attribute(hdf5::root_group, "trajectory", description.trajectory);
    write_modes(file, view);
    if (view.response) write_response(file, *view.response);
    if (view.sweep) write_sweep(file, view);
  });
}

}  // namespace balance::reports
