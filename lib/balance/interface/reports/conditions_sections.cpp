#include "balance/interface/reports/conditions_sections.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/reports/order_condition_sections.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/synthesis/conditions/condition_text.hpp"
#include "balance/synthesis/conditions/conditions.hpp"
#include "balance/synthesis/design/solve_design.hpp"
#include "balance/synthesis/design/status_names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <span>
#include <string_view>

namespace balance::reports {

Json conditions_json(const ConditionsReportData& view, const std::vector<std::string>& warnings) {
  Json json = {{"mechanism", view.title}, {"goal", goals_json(view.conditions.goals)}};
  json["meaning"] = files::list_json(
      view.conditions.goals, [&](const Goal& goal) { return study::describe_goal(goal, view.conditions.speeds); });
  json["strategy"] = view.strategy;
  json["status"] = design::name_of(view.conditions.status);
  add_conditions(json, view, condition_fields(view));
  json["warnings"] = warnings;
  return json;
}

namespace {

Json terms_json(const ConditionsReportData& view, int row) {
  const Conditions& c = view.conditions;
  const double max_abs_entry = numerics::max_abs(c.matrix.row(row));
  Json terms = Json::array();
  for (Eigen::Index p = 0; p < c.parameter_columns(); ++p) {
    const double coefficient = c.matrix(row, p);
    if (std::abs(coefficient) <= 1e-12 * max_abs_entry) continue;
    Json term = {{"parameter", c.parameters[static_cast<std::size_t>(p)].name}, {"coefficient", coefficient}};
    if (const conditions::CoefficientFormula* formula = view.names.find(row, static_cast<int>(p)))
      term["name"] = formula_text(*formula, view.names.symbols);
    terms.push_back(std::move(term));
  }
  return terms;
}

/// Known terms of the right-hand side with their values.
Json known_terms_json(const ConditionsReportData& view, int row) {
  const Conditions& c = view.conditions;
  const double max_abs_entry = numerics::max_abs(c.matrix.row(row));
  Json terms = Json::array();
  for (Eigen::Index p = c.parameter_columns(); p < c.matrix.cols(); ++p)
    if (std::abs(c.matrix(row, p)) > 1e-12 * max_abs_entry)
      terms.push_back({{"term", c.parameters[static_cast<std::size_t>(p)].name},
                       {"coefficient", -c.matrix(row, p)},
                       {"value", c.known_term_values[p - c.parameter_columns()]}});
  return terms;
}

double right_hand_side(const ConditionsReportData& view, int row) {
  double sum = 0;
  for (const Json& term : known_terms_json(view, row))
    sum += term["coefficient"].get<double>() * term["value"].get<double>();
  return sum;
}

const std::string& parameter_name(const dynamics::Parameter& parameter) { return parameter.name; }

Json symbol_json(const conditions::GeometricSymbol& symbol) {
  return {{"name", symbol.label}, {"value", symbol.value}, {"unit", symbol.unit}};
}

Json remainder_failure_json(const design::UnbalancedRemainder::Unknown& failure) {
  return {{"along", files::text_or_null(failure.trajectory)}, {"reason", failure.reason}};
}

Json remainder_effort_json(const design::RemainderEffort& effort) {
  return {{"along", files::text_or_null(effort.trajectory)},
          {"actuator", effort.actuator},
          {"peak", effort.magnitude},
          {"unit", effort.unit}};
}

Json remainder_json(const design::UnbalancedRemainder& remainder, const std::vector<dynamics::Parameter>& parameters) {
  const dynamics::ParameterOwner owner = remainder.element.bearer;
  return {{"kind", owner == dynamics::ParameterOwner::friction ? "friction"
                   : owner == dynamics::ParameterOwner::load   ? "load"
                   : is_damper(remainder.element, parameters)  ? "damper"
                                                               : "spring"},
          {"name", remainder.element.name},
          {"text", remainder.text},
          {"terms", files::list_json(remainder.element.terms,
                                     [&](int term) { return parameters[static_cast<std::size_t>(term)].name; })},
          {"efforts", files::list_json(remainder.efforts, remainder_effort_json)},
          {"unknown", files::list_json(remainder.failed_trajectories, remainder_failure_json)}};
}

Json free_numbers_json(const ConditionsReportData& view, int row) {
  return files::list_json(view.free_number_indices[static_cast<std::size_t>(row)],
                          [&](int number) { return view.numbers[static_cast<std::size_t>(number)].key_path; });
}

}  // namespace

Json goals_json(const std::vector<Goal>& goals) {
  if (goals.size() == 1) return goal_name(goals.front());
  return files::list_json(goals, study::goal_name);
}

files::ReportFields<int> condition_fields(const ConditionsReportData& view) {
  const Conditions& c = view.conditions;
  return {{[&](int row) { return condition_text(c, row, view.names); }, JsonKey{"text"},
           Hdf5Dataset{"what must vanish", "condition"}},
          {[&](int row) { return terms_json(view, row); }, JsonKey{"terms"}},
          {[&](int row) { return view.residuals[row]; }, JsonKey{"residual"}, SiUnit{"1"},
           Hdf5Dataset{"scaled residual of the designed mechanism", "residual_after"}},
          {[&](int row) { return view.is_met(row); }, JsonKey{"met"}},
          {[&](int row) { return static_cast<bool>(view.holds_by_definition[static_cast<std::size_t>(row)]); },
           JsonKey{"by_definition"}},
          {[&](int row) { return c.row_scales[row]; }, JsonKey{"scale"},
           Hdf5Dataset{"size of the terms, by which residuals are divided", "condition_scale"}},
          {[&](int row) { return free_numbers_json(view, row); }, JsonKey{"free"}},
          {[&](int row) { return condition_latex(c, row, view.names); }, JsonKey{"latex"}},
          {[&](int row) { return known_terms_json(view, row); }, JsonKey{"known"}},
          {[&](int row) { return right_hand_side(view, row); }, JsonKey{"right_hand_side"}}};
}

void add_conditions(Json& json, const ConditionsReportData& view, const files::ReportFields<int>& fields) {
  const Conditions& c = view.conditions;
  json["rank"] = view.parameter_rows();
  json["gap"] = c.singular_value_gap;
  json["gap_decades"] = c.singular_value_gap > 0 ? Json(elementary::log10(c.singular_value_gap)) : Json(nullptr);
  json["singular_values"] = {{"smallest_kept", c.min_kept_singular_value},
                             {"largest_dropped", c.max_dropped_singular_value}};
  json["samples"] = c.samples;
  json["parameters"] =
      files::list_json(std::span(c.parameters).first(static_cast<std::size_t>(c.parameter_columns())), parameter_name);
  json["symbols"] = files::list_json(view.names.symbols, symbol_json);
  json["conditions"] = rows_json(files::list_indices(view.parameter_rows()), fields);
  add_orders(json, view);
  json["staying"] = files::list_json(view.unbalanced_remainder, [&](const design::UnbalancedRemainder& remainder) {
    return remainder_json(remainder, c.parameters);
  });
  Json notes = c.notes;
  for (const std::string& note : view.names.notes) notes.push_back(note);
  json["notes"] = std::move(notes);
}

namespace {

constexpr std::size_t min_condition_width = 30;
constexpr std::size_t residual_width = 7, number_width = 4;  ///< of the other columns
constexpr std::size_t max_path_width = 24;                   ///< longer paths are broken

/// Columns that the text of a condition may have beside the others.
std::size_t condition_width(const ConditionsReportData& view, std::size_t width) {
  std::size_t others = number_width + residual_width + 4, max_path_size = 0;
  for (const FreeNumber& number : view.numbers) max_path_size = std::max(max_path_size, number.key_path.size());
  if (!view.numbers.empty()) others += 2 + std::clamp<std::size_t>(max_path_size, 12, max_path_width);
  return width > others + min_condition_width ? width - others : min_condition_width;
}

std::string residual_text(const ConditionsReportData& view, int row) {
  return view.is_met(row) ? "met" : fmt::format("{:.2g}", std::abs(view.residuals[row]));
}

/// Rows of one condition; further lines of a long one fill only its own cell.
void add_rows(files::TextTable& table, const ConditionsReportData& view, int row, std::size_t width) {
  const auto lines = wrap_condition(view, row, condition_width(view, width));
  std::vector<std::string> paths;
  for (const int number : view.free_number_indices[static_cast<std::size_t>(row)])
    paths.push_back(view.numbers[static_cast<std::size_t>(number)].key_path);
  const bool has_free_column = table.heading.size() > 3;
  const std::size_t height = std::max(lines.size(), has_free_column ? paths.size() : 0);
  for (std::size_t i = 0; i < height; ++i) {
    std::vector<std::string> cells = {i == 0 ? std::to_string(row + 1) : "", i < lines.size() ? lines[i] : "",
                                      i == 0 ? residual_text(view, row) : ""};
    if (has_free_column) cells.push_back(i < paths.size() ? paths[i] : (i == 0 ? "nothing free" : ""));
    table.rows.push_back(std::move(cells));
  }
}

std::string table_text(const ConditionsReportData& view, std::size_t width) {
  files::TextTable table{
      {"no", "condition", "now"}, {files::Align::right, files::Align::left, files::Align::right}, {}};
  if (!view.numbers.empty()) {
    table.heading.push_back("depends on");
    table.align.push_back(files::Align::left);
  }
  for (int row = 0; row < view.parameter_rows(); ++row)
    if (!view.holds_by_definition[static_cast<std::size_t>(row)]) add_rows(table, view, row, width);
  return table.rows.empty() ? "" : format_table(table, width) + "\n";
}

std::string heading_text(const ConditionsReportData& view) {
  const Conditions& c = view.conditions;
  std::string text = fmt::format("{}: {} conditions{}\n", view.title, join_goal_names(c.goals),
                                 view.strategy == "modular" ? ", chain by chain" : "");
  for (const Goal& goal : c.goals) text += describe_goal(goal, c.speeds) + "\n";
  text += fmt::format("\nrank {} of {}", view.parameter_rows(),
                      count_noun(c.parameter_columns(), "parameter", "parameters"));
  if (c.rank > 0 && c.singular_value_gap > 0)
    text += fmt::format(", gap {:.1f} decades", elementary::log10(c.singular_value_gap));
  if (c.samples > 0) text += ", " + count_noun(c.samples, "sample", "samples");
  return text + "\n\n";
}

std::string closing_text(const ConditionsReportData& view) {
  std::vector<int> symmetric_rows;
  long unmet_count = 0;
  for (int row = 0; row < view.parameter_rows(); ++row) {
    if (view.holds_by_definition[static_cast<std::size_t>(row)]) symmetric_rows.push_back(row + 1);
    if (!view.is_met(row)) ++unmet_count;
  }
  std::string text;
  if (!symmetric_rows.empty())
    text += fmt::format("{} {} for every disc that is symmetrical about its axis\n", format_ranges(symmetric_rows),
                        symmetric_rows.size() == 1 ? "holds" : "hold");
  if (view.parameter_rows() == 0 && !view.unbalanced_remainder.empty()) return text;
  if (view.parameter_rows() == 0) return text + "no conditions: the mechanism is balanced as it is\n";
  if (unmet_count == 0)
    return text + (view.unbalanced_remainder.empty() ? "all are met\n" : "all that masses can meet are met\n");
  return text + fmt::format("{} of {} not met: 'now' is the residual, relative to the size of the terms\n", unmet_count,
                            view.parameter_rows());
}

std::string effort_text(const design::RemainderEffort& effort, const specification::SpecUnits& units) {
  const files::DisplayUnit unit = files::find_display_unit(effort.unit, units);
  return fmt::format("{:.4g} {} at {} {}", unit.convert(effort.magnitude), unit.name, effort.actuator,
                     effort.trajectory.empty() ? "at rest" : "along " + effort.trajectory);
}

}  // namespace

std::string format_ranges(const std::vector<int>& rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    text += text.empty() ? "" : ", ";
    text += std::to_string(rows[i]);
    if (end - i > 1) text += (end - i == 2 ? ", " : "-") + std::to_string(rows[end - 1]);
    i = end;
  }
  return text;
}

namespace {

bool is_plain_number(const conditions::CoefficientFormula& formula) {
  return formula.factor.powers.empty() && formula.sum.empty() && !formula.wave;
}

}  // namespace

ConditionsReportData convert_coefficients(ConditionsReportData view, const specification::SpecUnits& units) {
  MatrixX& matrix = view.conditions.matrix;
  VectorX si_values(matrix.cols());
  for (Eigen::Index p = 0; p < matrix.cols(); ++p)
    si_values[p] =
        files::find_display_unit(unit_of(view.conditions.parameters[static_cast<std::size_t>(p)]), units).factor;
  if ((si_values.array() == 1).all()) return view;
  VectorX& known = view.conditions.known_term_values;
  if (known.size() > 0) known.array() /= si_values.tail(known.size()).array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    const double largest = numerics::max_abs(matrix.row(row));
    Eigen::Index unit_column = 0;  // the parameter whose coefficient is 1 keeps it
    for (Eigen::Index p = matrix.cols(); p-- > 0;)
      if (std::abs(matrix(row, p)) == 1) unit_column = p;
    for (Eigen::Index p = 0; p < matrix.cols(); ++p) {
      if (std::abs(matrix(row, p)) <= 1e-12 * largest) matrix(row, p) = 0;
      const double ratio = si_values[p] / si_values[unit_column];
      matrix(row, p) *= ratio;
      if (ratio == 1 || static_cast<std::size_t>(row) >= view.names.formulas.size()) continue;
      auto& formula = view.names.formulas[static_cast<std::size_t>(row)][static_cast<std::size_t>(p)];
      if (formula && is_plain_number(*formula)) formula.reset();
    }
  }
  return view;
}

std::vector<std::string> wrap_condition(const ConditionsReportData& view, int row, std::size_t width) {
  const std::string text = condition_text(view.conditions, row, view.names);
  std::vector<std::string> lines;
  std::string line, term;
  const auto finish_term = [&] {
    // further lines are indented by four
    const std::size_t available_width = lines.empty() ? width : width - 4;
    if (!line.empty() && line.size() + 1 + term.size() > available_width) {
      lines.push_back((lines.empty() ? "" : "    ") + line);
      line.clear();
    }
    line += (line.empty() ? "" : " ") + term;
    term.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    // a term begins with its sign; signs inside brackets begin none
    const bool is_sign = text.compare(i, 3, " + ") == 0 || text.compare(i, 3, " - ") == 0;
    const auto depth = std::count(term.begin(), term.end(), '(') - std::count(term.begin(), term.end(), ')');
    if (is_sign && depth == 0)
      finish_term();
    else
      term += text[i];
  }
  finish_term();
  lines.push_back((lines.empty() ? "" : "    ") + line);
  return lines;
}

std::string symbols_text(const ConditionsReportData& view, const specification::SpecUnits& units) {
  std::string text;
  for (const auto* symbols : {&view.names.symbols, &view.known_terms}) {
    for (const conditions::GeometricSymbol& symbol : *symbols) {
      const files::DisplayUnit unit = files::find_display_unit(symbol.unit, units);
      text += (text.empty() ? "" : ", ") +
              fmt::format("{} = {:.6g}{}", symbol.label, unit.convert(symbol.value), append_unit(unit));
    }
  }
  return text;
}

namespace {

/// The sentence with the numbers that it states in other units: "push (fx = 5 N)". They are SI.
std::string convert_stated_numbers(const std::string& sentence, const specification::SpecUnits& units) {
  if (!files::has_other_units(units)) return sentence;
  std::string text;
  for (std::size_t at = 0; at < sentence.size();) {
    const std::size_t end = std::min(sentence.find(' ', at), sentence.size());
    const std::string word = sentence.substr(at, end - at);
    char* rest = nullptr;
    const double number = std::strtod(word.c_str(), &rest);
    const bool is_number = !word.empty() && *rest == '\0';
    std::string converted;
    for (const char* si_unit : {"N m s/rad", "N m/rad", "N s/m", "N/m", "N m", "N"}) {
      const std::size_t length = std::string_view(si_unit).size();
      const std::size_t next = end + 1 + length;
      if (!is_number || sentence.compare(end + 1, length, si_unit) != 0) continue;
      if (next < sentence.size() && std::isalpha(static_cast<unsigned char>(sentence[next])) != 0) continue;
      const files::DisplayUnit unit = files::find_display_unit(si_unit, units);
      converted = fmt::format("{:.6g} {}", unit.convert(number), unit.name);
      at = next;
      break;
    }
    if (!converted.empty()) {
      text += converted;
      continue;
    }
    text += word + (end < sentence.size() ? " " : "");
    at = end + 1;
  }
  return text;
}

}  // namespace

std::string format_remainder(const ConditionsReportData& view, const specification::SpecUnits& units) {
  if (view.unbalanced_remainder.empty()) return "";
  std::string text = "cannot be balanced by masses or springs and remains:\n";
  for (const design::UnbalancedRemainder& remainder : view.unbalanced_remainder) {
    text += "  " + convert_stated_numbers(remainder.text, units) + "\n";
    for (const design::RemainderEffort& effort : remainder.efforts)
      text += "      up to " + effort_text(effort, units) + "\n";
    for (const auto& failure : remainder.failed_trajectories)
      if (failure.trajectory.empty()) text += "      not known at rest: " + failure.reason + "\n";
  }
  std::vector<std::string> failed_trajectories;
  for (const design::UnbalancedRemainder& remainder : view.unbalanced_remainder)
    for (const auto& failure : remainder.failed_trajectories)
      if (!failure.trajectory.empty() && std::find(failed_trajectories.begin(), failed_trajectories.end(),
                                                   failure.trajectory) == failed_trajectories.end())
        failed_trajectories.push_back(failure.trajectory);
  if (!failed_trajectories.empty())
    text += fmt::format("not known along {}, which cannot be followed\n", fmt::join(failed_trajectories, ", "));
  return text + "--without excludes it\n";
}

namespace {

std::string meaning_of(const dynamics::Parameter& p) {
  const std::string axis(1, p.symbol.back());
  const bool is_planar = p.symbol == "J";
  switch (p.kind) {
    case dynamics::ParameterKind::mass: return "a mass";
    case dynamics::ParameterKind::first_moment: return "mass times " + axis + " of the centre of mass";
    case dynamics::ParameterKind::moment_of_inertia:
      return std::string("a moment of inertia about ") +
             (p.owner_kind == dynamics::ParameterOwner::disc ? "the disc's centre" : "the origin of the body's frame") +
             (is_planar ? "" : ", axis " + axis);
    case dynamics::ParameterKind::product_of_inertia:
      return "a product of inertia, -integral of " + p.symbol.substr(1) + " dm";
    case dynamics::ParameterKind::stiffness: return "a stiffness";
    case dynamics::ParameterKind::stiffness_moment:
      return p.symbol == "preload" ? "the spring's torque or force at 0"
                                   : "stiffness times coordinates of the spring's ends a and b";
    default: return "";
  }
}

}  // namespace

std::string parameter_legend(const ConditionsReportData& view) {
  const Conditions& c = view.conditions;
  std::vector<std::string> meanings;
  std::string text;
  for (Eigen::Index column = 0; column < c.parameter_columns(); ++column) {
    const dynamics::Parameter& parameter = c.parameters[static_cast<std::size_t>(column)];
    if (c.matrix.col(column).head(view.parameter_rows()).isZero(0)) continue;
    const std::string meaning = meaning_of(parameter);
    if (meaning.empty() || std::find(meanings.begin(), meanings.end(), meaning) != meanings.end()) continue;
    meanings.push_back(meaning);
    text += (text.empty() ? "" : "; ") + parameter.name + (text.empty() ? " is " : ": ") + meaning;
  }
  return text;
}

std::string conditions_text(const ConditionsReportData& si_view, const files::TextOptions& options) {
  const ConditionsReportData view = convert_coefficients(si_view, options.units);
  std::string text = heading_text(view) + table_text(view, options.width);
  const std::string symbols = symbols_text(view, options.units);
  if (!symbols.empty()) text += "where " + symbols + "\n";
  if (const std::string legend = parameter_legend(view); !legend.empty()) text += legend + "\n";
  text += closing_text(view) + orders_text(si_view, options) + format_remainder(view, options.units);
  for (const std::string& note : view.conditions.notes) text += "note: " + note + "\n";
  for (const std::string& note : view.names.notes) text += "note: " + note + "\n";
  return files::wrap_lines(text, options.width);
}

bool ConditionsReportData::is_met(int row) const { return std::abs(residuals[row]) <= design::condition_tolerance; }

namespace {

/// Known terms of the conditions that also have parameters.
std::vector<conditions::GeometricSymbol> known_values_of(const Conditions& conditions, const VectorX& values) {
  std::vector<conditions::GeometricSymbol> symbols;
  for (Eigen::Index column = conditions.parameter_columns(); column < values.size(); ++column) {
    const dynamics::Parameter& term = conditions.parameters[static_cast<std::size_t>(column)];
    if (!conditions.matrix.col(column).head(conditions.parameter_rows()).isZero(0))
      symbols.push_back({term.name, unit_of(term), values[column], {}});
  }
  return symbols;
}

/// Which attachments are there, for every state of a mechanism whose payloads come and go, the fullest first.
std::vector<std::vector<bool>> list_load_states(const Mechanism& mechanism,
                                                const std::vector<Trajectory>& trajectories) {
  double end = 1;  // of a motion that contains all changes
  for (const double time : model::payload_switch_times(mechanism)) end = std::max(end, 2 * time);
  std::vector<double> durations;
  for (const Trajectory& trajectory : trajectories) durations.push_back(trajectory.duration);
  if (durations.empty()) durations.push_back(end);
  std::vector<std::vector<bool>> states;
  for (const double duration : durations) {
    const model::PayloadIntervals intervals(mechanism, duration);
    for (int k = 0; k < intervals.count(); ++k) {
      std::vector<bool> state;
      for (std::size_t a = 0; a < mechanism.attachments.size(); ++a) state.push_back(intervals.is_attached(a, k));
      states.push_back(std::move(state));
    }
  }
  std::sort(states.begin(), states.end(), std::greater<>());
  states.erase(std::unique(states.begin(), states.end()), states.end());
  return states;
}

/// "without cargo"
std::string describe_load_state(const Mechanism& mechanism, const std::vector<bool>& state) {
  std::vector<std::string> there, missing;
  for (std::size_t a = 0; a < state.size(); ++a)
    if (is_temporary_payload(mechanism.attachments[a]))
      (state[a] ? there : missing).push_back(mechanism.attachments[a].name);
  std::string text = there.empty() ? "" : fmt::format("with {}", fmt::join(there, ", "));
  if (!missing.empty()) text += fmt::format("{}without {}", text.empty() ? "" : " ", fmt::join(missing, ", "));
  return text;
}

/// Per condition the largest residual of all load states; notes say which are met with what.
VectorX evaluate_load_states(ConditionsReportData& view, const Mechanism& mechanism,
                             const std::vector<Trajectory>& trajectories, const ConditionOptions& options) {
  VectorX largest;
  for (const std::vector<bool>& state : list_load_states(mechanism, trajectories)) {
    Mechanism loaded = mechanism;
    for (std::size_t a = 0; a < state.size(); ++a)
      if (!state[a]) model::detach(loaded.attachments[a]);
    const VectorX residuals = scaled_residuals(view.conditions, conditions::term_values(loaded, options.loose_springs));
    if (largest.size() == 0) largest = VectorX::Zero(residuals.size());
    Eigen::Index unmet = 0;
    for (Eigen::Index row = 0; row < residuals.size(); ++row) {
      if (!(std::abs(residuals[row]) <= std::abs(largest[row]))) largest[row] = residuals[row];
      if (!(std::abs(residuals[row]) <= design::condition_tolerance)) ++unmet;
    }
    view.conditions.notes.push_back(
        fmt::format("{}: {}", describe_load_state(mechanism, state),
                    unmet == 0 ? "all conditions are met" : fmt::format("{} of {} not met", unmet, residuals.size())));
  }
  return largest;
}

}  // namespace

void evaluate_conditions(ConditionsReportData& view, const Mechanism& mechanism,
                         const std::vector<Trajectory>& trajectories, const ConditionOptions& options) {
  const VectorX values = conditions::term_values(mechanism, options.loose_springs);
  view.conditions.known_term_values = values.tail(view.conditions.known_term_values.size());
  view.residuals = has_temporary_payloads(mechanism) ? evaluate_load_states(view, mechanism, trajectories, options)
                                                     : scaled_residuals(view.conditions, values);
  view.known_terms = known_values_of(view.conditions, values);
  evaluate_orders(view, mechanism, options);
  view.unbalanced_remainder = design::list_unbalanced_remainders(mechanism, trajectories, view.conditions, options);
  // what a free number may change is left to the design
  std::erase_if(view.unbalanced_remainder, [&](const design::UnbalancedRemainder& remainder) {
    const auto& rows = remainder.element.rows;
    return std::any_of(rows.begin(), rows.end(),
                       [&](int row) { return !view.free_number_indices[static_cast<std::size_t>(row)].empty(); });
  });
  view.holds_by_definition.clear();
  for (int row = 0; row < view.residuals.size(); ++row)
    view.holds_by_definition.push_back(view.is_met(row) && is_met_by_symmetric_discs(view.conditions, row, mechanism));
}

dynamics::FreeSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism) {
  dynamics::FreeSprings loose(mechanism.springs.size(), false);
  for (const dynamics::Parameter& p : conditions.parameters)
    if (p.owner_kind == dynamics::ParameterOwner::spring && p.slot > 0) loose[static_cast<std::size_t>(p.index)] = true;
  return loose;
}

}  // namespace balance::reports
