#include "balance/interface/reports/load_case_sections.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/interface/files/report_fields.hpp"
#include "balance/synthesis/design/case_objective.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace balance::reports {

using design::AdaptiveLaw;
using files::DisplayUnit;
using files::TextOptions;
using study::LoadCases;

namespace {

std::vector<std::string> load_names(const LoadCases& loads) {
  std::vector<std::string> names;
  for (const study::LoadParameter& number : loads.numbers) names.push_back(number.name);
  return names;
}

VectorX nominal_loads(const LoadCases& loads) {
  VectorX values(static_cast<Eigen::Index>(loads.numbers.size()));
  for (std::size_t k = 0; k < loads.numbers.size(); ++k)
    values[static_cast<Eigen::Index>(k)] = loads.numbers[k].nominal;
  return values;
}

Json loads_json(const LoadCases& cases, const VectorX& values) {
  return files::named_numbers_json(load_names(cases), values);
}

Json static_efforts_json(const design::LoadCaseReport& load_case, const Mechanism& mechanism) {
  Json json = Json::object();
  for (const int actuator : mechanism.actuators) {
    double max_effort = 0;
    for (const conditions::PeakEffort& effort : load_case.static_efforts)
      if (effort.actuator == actuator) max_effort = effort.magnitude;
    json[mechanism.coordinates[static_cast<std::size_t>(actuator)].name] = max_effort;
  }
  return json;
}

Json load_case_run_json(const design::LoadCaseRun& run) {
  return {{"trajectory", run.trajectory},
          {"outcome", files::outcome_json(run.outcome)},
          {"metrics", files::metrics_json(run.metrics)}};
}

Json case_json(const design::LoadCaseReport& load_case, const DesignReport& report) {
  Json json = {{"loads", loads_json(report.study_after.design.cases, load_case.loads)},
               {"largest_residual", load_case.residual},
               {"met", load_case.residual <= design::condition_tolerance},
               {"at_rest", static_efforts_json(load_case, report.study_after.mechanism)}};
  json["free_numbers"] = Json::object();
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i)
    json["free_numbers"][report.free_numbers[i].key_path] = load_case.x[static_cast<Eigen::Index>(i)];
  json["trajectories"] = files::list_json(load_case.runs, load_case_run_json);
  return json;
}

Json cases_json(const std::vector<design::LoadCaseReport>& cases, const DesignReport& report) {
  return files::list_json(cases, [&](const design::LoadCaseReport& one) { return case_json(one, report); });
}

/// "-0.075 - 0.1 cargo.mass". @param times separator of factors
std::string law_text(const AdaptiveLaw& law, Eigen::Index index, const std::vector<std::string>& loads, double unit = 1,
                     int digits = 6, const char* times = " ") {
  std::string text;
  for (const AdaptiveLaw::Term& term : law.terms) {
    const double coefficient = term.coefficients[index] / unit;
    if (coefficient == 0) continue;
    const char* sign = coefficient < 0 ? (text.empty() ? "-" : " - ") : (text.empty() ? "" : " + ");
    text += fmt::format("{}{:.{}g}", sign, std::abs(coefficient), digits);
    for (std::size_t k = 0; k < term.powers.size(); ++k) {
      if (term.powers[k] == 0) continue;
      text += times + loads[k];
      if (term.powers[k] > 1) text += fmt::format("^{}", term.powers[k]);
    }
  }
  return text.empty() ? "0" : text;
}

Json law_json(const AdaptiveLaw& law, Eigen::Index index, const LoadCases& cases) {
  Json terms = Json::array();
  for (const AdaptiveLaw::Term& term : law.terms) {
    if (term.coefficients[index] == 0) continue;
    Json powers = Json::object();
    for (std::size_t k = 0; k < term.powers.size(); ++k)
      if (term.powers[k] > 0) powers[cases.numbers[k].name] = term.powers[k];
    terms.push_back({{"coefficient", term.coefficients[index]}, {"powers", std::move(powers)}});
  }
  return terms;
}

Json table_json(const design::AdaptedTable& table, const DesignReport& report) {
  if (table.loads.empty()) return nullptr;
  Json rows = Json::array();
  for (std::size_t row = 0; row < table.loads.size(); ++row)
    rows.push_back({{"loads", loads_json(report.study_after.design.cases, table.loads[row])},
                    {"values", files::numbers_json(table.values[row])},
                    {"largest_residual", table.residuals[row]}});
  const bool has_one_load = table.loads.front().size() == 1;
  return {{"rows", std::move(rows)},
          {"residual_between", has_one_load ? Json(table.midpoint_residual) : Json(nullptr)}};
}

Json adaptive_json(const DesignReport& report) {
  if (!report.adaptive) return nullptr;
  const design::AdaptiveReport& adaptive = *report.adaptive;
  const LoadCases& cases = report.study_after.design.cases;
  const VectorX own_load = nominal_loads(cases);
  Json numbers = Json::array();
  for (std::size_t i = 0; i < adaptive.numbers.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    Json number = {{"path", report.free_numbers[static_cast<std::size_t>(adaptive.numbers[i])].key_path},
                   {"least", adaptive.min_values[k]},
                   {"most", adaptive.max_values[k]},
                   {"law", nullptr}};
    if (adaptive.law) {
      number["law"] = {{"text", law_text(*adaptive.law, k, load_names(cases))},
                       {"affine", adaptive.law->is_affine(k)},
                       {"terms", law_json(*adaptive.law, k, cases)}};
      number["slope"] = loads_json(cases, adaptive.law->jacobian(own_load).row(k));
    }
    numbers.push_back(std::move(number));
  }
  return {{"numbers", std::move(numbers)},
          {"within_bounds", adaptive.is_within_bounds},
          {"table", table_json(adaptive.table, report)},
          {"work", adaptive.adjustment_work ? Json(*adaptive.adjustment_work) : Json(nullptr)},
          {"own_load", loads_json(cases, own_load)},
          {"not_adapted", cases_json(adaptive.fixed_design_cases, report)}};
}

}  // namespace

void add_load_cases(Json& json, const DesignReport& report) {
  json["load_cases"] = cases_json(report.load_cases, report);
  json["adaptive"] = adaptive_json(report);
}

namespace {

/// Of a law in a spec: cancellation leaves round-off in the last two digits of a double.
constexpr int law_significant_digits = 15;

const LoadCases& cases_of(const DesignReport& report) { return report.study_after.design.cases; }

/// "cargo.mass = 2 kg"
std::string describe_load(const LoadCases& cases, const VectorX& loads, const TextOptions& options) {
  std::string text;
  for (std::size_t k = 0; k < cases.numbers.size(); ++k) {
    const DisplayUnit unit = find_number_unit(cases.numbers[k].path, options);
    text += fmt::format("{}{} = {:.6g}{}", k == 0 ? "" : ", ", cases.numbers[k].name,
                        unit.convert(loads[static_cast<Eigen::Index>(k)]), append_unit(unit));
  }
  return text;
}

std::string residual_word(double residual) {
  if (std::isnan(residual)) return "-";
  return residual <= design::condition_tolerance ? "met" : fmt::format("{:.2g}", residual);
}

DisplayUnit effort_unit(const Mechanism& mechanism, int actuator, const specification::SpecUnits& units) {
  return files::find_display_unit(is_length_coordinate(mechanism, actuator) ? "N" : "N m", units);
}

/// Unit of all efforts; std::nullopt if forces and torques are among them.
std::optional<DisplayUnit> common_effort_unit(const Mechanism& mechanism, const specification::SpecUnits& units) {
  std::optional<DisplayUnit> common;
  for (const int actuator : mechanism.actuators) {
    const DisplayUnit unit = effort_unit(mechanism, actuator, units);
    if (common && common->name != unit.name) return std::nullopt;
    common = unit;
  }
  return common;
}

/// Maximum static effort of every actuator: "4.4145, 1.962"; with units if these differ.
std::string static_efforts_text(const design::LoadCaseReport& load_case, const Mechanism& mechanism,
                                const specification::SpecUnits& units) {
  const bool is_mixed = !common_effort_unit(mechanism, units);
  std::string text;
  for (const int actuator : mechanism.actuators) {
    const auto match = std::find_if(load_case.static_efforts.begin(), load_case.static_efforts.end(),
                                    [&](const conditions::PeakEffort& effort) { return effort.actuator == actuator; });
    const DisplayUnit unit = effort_unit(mechanism, actuator, units);
    text += (text.empty() ? "" : ", ") +
            files::format_figure(match == load_case.static_efforts.end() ? 0 : unit.convert(match->magnitude)) +
            (is_mixed ? append_unit(unit) : "");
  }
  return text.empty() ? "-" : text;
}

/// Peak and mean of the worst actuator's torque.
std::string torque_text(const design::LoadCaseRun& run, const specification::SpecUnits& units) {
  for (const Metric& metric : run.metrics) {
    if (metric.quantity != "torque") continue;
    const DisplayUnit unit = files::find_display_unit(metric.unit, units);
    return fmt::format("{}, {}", files::format_figure(unit.convert(metric.peak)),
                       files::format_figure(unit.convert(metric.mean)));
  }
  return "-";
}

/// "mp = 0 to 1", or the first and the last of several loads.
std::string describe_load_range(const LoadCases& cases, const VectorX& first, const VectorX& last,
                                const TextOptions& options) {
  const std::string text = describe_load(cases, first, options);
  if (first == last) return text;
  if (first.size() != 1) return fmt::format("{} to {}", text, describe_load(cases, last, options));
  const DisplayUnit unit = find_number_unit(cases.numbers.front().path, options);
  return fmt::format("{} = {:.6g} to {:.6g}{}", cases.numbers.front().name, unit.convert(first[0]),
                     unit.convert(last[0]), append_unit(unit));
}

/// Rows of a table of loads: the load, then its figures.
class LoadRows {
 public:
  LoadRows(const LoadCases& cases, const TextOptions& options) : cases_(cases), options_(options) {}

  /// Joins the row with the one before if all figures are the same and the text is not verbose.
  void add(const VectorX& loads, std::vector<std::string> figures) {
    if (!options_.verbose && !rows_.empty() && figures == rows_.back().figures)
      rows_.back().last = loads;
    else
      rows_.push_back({loads, loads, std::move(figures)});
  }

  std::vector<std::vector<std::string>> cells() const {
    std::vector<std::vector<std::string>> all;
    for (const Row& row : rows_) {
      all.push_back({describe_load_range(cases_, row.first, row.last, options_)});
      all.back().insert(all.back().end(), row.figures.begin(), row.figures.end());
    }
    return all;
  }

 private:
  struct Row {
    VectorX first, last;
    std::vector<std::string> figures;
  };
  const LoadCases& cases_;
  const TextOptions& options_;
  std::vector<Row> rows_;
};

std::string cases_table(const std::vector<design::LoadCaseReport>& cases, const DesignReport& report,
                        const TextOptions& options, const std::vector<std::string>& hidden_trajectories) {
  const Mechanism& mechanism = report.study_after.mechanism;
  const std::optional<DisplayUnit> effort = common_effort_unit(mechanism, options.units);
  const std::string unit = effort ? bracket_unit(*effort) : "";
  std::string actuators;
  for (const int actuator : mechanism.actuators)
    actuators += (actuators.empty() ? " " : ", ") + mechanism.coordinates[static_cast<std::size_t>(actuator)].name;
  const bool has_conditions = report.outcome.status != DesignStatus::no_goal;
  const auto is_shown = [&](const design::LoadCaseRun& run) {
    return std::find(hidden_trajectories.begin(), hidden_trajectories.end(), run.trajectory) ==
           hidden_trajectories.end();
  };
  files::TextTable table{{"load"}, {files::Align::left}, {}};
  if (has_conditions) table.heading.push_back("conditions");
  table.heading.push_back("peak at rest" + actuators + unit);
  for (const design::LoadCaseRun& run : cases.front().runs)
    if (is_shown(run)) table.heading.push_back(run.trajectory + ": torque peak, mean" + unit);
  table.align.resize(table.heading.size(), files::Align::right);
  LoadRows rows(cases_of(report), options);
  for (const design::LoadCaseReport& one : cases) {
    std::vector<std::string> figures;
    if (has_conditions) figures.push_back(residual_word(one.residual));
    figures.push_back(static_efforts_text(one, mechanism, options.units));
    for (const design::LoadCaseRun& run : one.runs)
      if (is_shown(run)) figures.push_back(torque_text(run, options.units));
    rows.add(one.loads, std::move(figures));
  }
  table.rows = rows.cells();
  return format_table(table, options.width);
}

std::string path_of(const DesignReport& report, std::size_t index) {
  return report.free_numbers[static_cast<std::size_t>(report.adaptive->numbers[index])].key_path;
}

DisplayUnit adapted_unit(const DesignReport& report, std::size_t index, const TextOptions& options) {
  return find_number_unit(path_of(report, index), options);
}

std::string slopes_text(const AdaptiveLaw& law, Eigen::Index i, const LoadCases& loads, const DisplayUnit& unit,
                        const TextOptions& options) {
  const MatrixX slope = law.jacobian(nominal_loads(loads));
  std::string text;
  for (Eigen::Index k = 0; k < slope.cols(); ++k)
    text += fmt::format(
        "{}{:.6g} per {}", k == 0 ? "" : ", ",
        unit.convert(slope(i, k)) * find_number_unit(loads.numbers[static_cast<std::size_t>(k)].path, options).factor,
        loads.numbers[static_cast<std::size_t>(k)].name);
  return text;
}

/// The law with the loads in their display units; its values are SI.
AdaptiveLaw convert_loads(AdaptiveLaw law, const LoadCases& loads, const TextOptions& options) {
  for (AdaptiveLaw::Term& term : law.terms)
    for (std::size_t k = 0; k < term.powers.size(); ++k)
      term.coefficients *= elementary::pow(find_number_unit(loads.numbers[k].path, options).factor, term.powers[k]);
  return law;
}

std::string law_lines(const DesignReport& report, const TextOptions& options) {
  const design::AdaptiveReport& adaptive = *report.adaptive;
  const LoadCases& loads = cases_of(report);
  std::string text =
      fmt::format("adapted to the load [{}]\n", files::has_other_units(options.units) ? "the spec's units" : "SI");
  for (std::size_t i = 0; i < adaptive.numbers.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const DisplayUnit unit = adapted_unit(report, i, options);
    text += fmt::format("  {} = {}", path_of(report, i),
                        adaptive.law
                            ? law_text(convert_loads(*adaptive.law, loads, options), k, load_names(loads), unit.factor)
                            : "by the table below");
    text += fmt::format("; from {:.6g} to {:.6g}{}", unit.convert(adaptive.min_values[k]),
                        unit.convert(adaptive.max_values[k]), append_unit(unit));
    if (adaptive.law) text += "; " + slopes_text(*adaptive.law, k, loads, unit, options);
    text += "\n";
  }
  if (!adaptive.is_within_bounds)
    text += "the law leaves the bounds of the free numbers within the range of the loads\n";
  return text;
}

std::string table_text(const DesignReport& report, const TextOptions& options) {
  const design::AdaptedTable& adapted_table = report.adaptive->table;
  if (adapted_table.loads.empty()) return "";
  const bool has_conditions = report.outcome.status != DesignStatus::no_goal;
  files::TextTable table{{"load"}, {files::Align::left}, {}};
  if (has_conditions) table.heading.push_back("conditions");
  for (std::size_t i = 0; i < report.adaptive->numbers.size(); ++i)
    table.heading.push_back(path_of(report, i) + bracket_unit(adapted_unit(report, i, options)));
  table.align.resize(table.heading.size(), files::Align::right);
  LoadRows rows(cases_of(report), options);
  for (std::size_t row = 0; row < adapted_table.loads.size(); ++row) {
    std::vector<std::string> figures;
    if (has_conditions) figures.push_back(residual_word(adapted_table.residuals[row]));
    for (std::size_t i = 0; i < report.adaptive->numbers.size(); ++i)
      figures.push_back(files::format_figure(
          adapted_unit(report, i, options).convert(adapted_table.values[row][static_cast<Eigen::Index>(i)])));
    rows.add(adapted_table.loads[row], std::move(figures));
  }
  table.rows = rows.cells();
  std::string text = format_table(table, options.width);
  if (has_conditions && adapted_table.loads.front().size() == 1)
    text +=
        fmt::format("between them by a cubic spline: conditions {}\n", residual_word(adapted_table.midpoint_residual));
  return text;
}

std::string costs_text(const DesignReport& report, const TextOptions& options,
                       const std::vector<std::string>& hidden_trajectories) {
  const DisplayUnit energy = files::find_display_unit("J", options.units);
  std::string text;
  if (report.adaptive->adjustment_work)
    text += fmt::format(
        "work against gravity and springs from the least to the largest loads, at the start of trajectory {}: {} {}\n",
        report.study_after.trajectories.front().name,
        files::format_figure(energy.convert(*report.adaptive->adjustment_work)), energy.name);
  text += fmt::format("\nnot adapted: as for {}\n",
                      describe_load(cases_of(report), nominal_loads(cases_of(report)), options));
  return text + cases_table(report.adaptive->fixed_design_cases, report, options, hidden_trajectories);
}

}  // namespace

std::vector<std::string> make_law_expressions(const DesignReport& report) {
  std::vector<std::string> texts(report.free_numbers.size());
  if (!report.adaptive || !report.adaptive->law || !report.adaptive->is_within_bounds) return texts;
  const LoadCases& loads = cases_of(report);
  std::vector<std::string> names;
  for (const study::LoadParameter& number : loads.numbers) {
    if (!number.path.starts_with("parameters.")) return texts;
    names.push_back(number.path.substr(std::string("parameters.").size()));
  }
  for (std::size_t i = 0; i < report.adaptive->numbers.size(); ++i) {
    const auto number = static_cast<std::size_t>(report.adaptive->numbers[i]);
    texts[number] = fmt::format("\"{}\"", law_text(*report.adaptive->law, static_cast<Eigen::Index>(i), names,
                                                   report.free_numbers[number].unit, law_significant_digits, " * "));
  }
  return texts;
}

std::string load_cases_text(const DesignReport& report, const TextOptions& options,
                            const std::vector<std::string>& hidden_trajectories) {
  if (report.load_cases.empty()) return "";
  std::string text =
      fmt::format("\nload cases\n{}", cases_table(report.load_cases, report, options, hidden_trajectories));
  if (report.adaptive && report.adaptive->min_values == report.adaptive->max_values && !options.verbose)
    return text + "adapted to the load: nothing; the values are the same for every load\n";
  if (report.adaptive)
    text += "\n" + law_lines(report, options) + table_text(report, options) +
            costs_text(report, options, hidden_trajectories);
  return text;
}

}  // namespace balance::reports
