#include "balance/present/design_text.hpp"

#include "balance/analysis/objective.hpp"
#include "balance/present/chosen.hpp"
#include "balance/present/conditions_text.hpp"
#include "balance/present/load_cases_text.hpp"
#include "balance/present/names.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

/// Six digits; an exact zero is just that.
std::string number_text(double value) {
  if (std::isnan(value)) return "-";
  return value == 0 ? "0" : format_number(value);
}

std::string ratio_text(double before, double after) {
  if (!(before != 0) || std::isnan(before) || std::isnan(after)) return "-";
  return after == 0 ? "0" : fmt::format("{:.4g}", after / before);
}

/// A gap of this part of the value is none.
constexpr double gap_tolerance = 1e-12;

bool is_proved_best(const DesignReportData& view) {
  return view.report.outcome.optimality == Optimality::proved_global && !view.objective.empty();
}

/// Of a design that does not keep its limits.
std::string headline_beyond_limits(const DesignOutcome& outcome, const std::string& goals) {
  const bool impossible = outcome.status == DesignStatus::infeasible;
  if (goals.empty())
    return impossible ? "impossible: no choice of the free numbers keeps all limits"
                      : "a compromise: not all limits are kept";
  if (!outcome.unmet_conditions.empty())
    return fmt::format("{}: not balanced for {}, and not all limits are kept",
                       impossible ? "impossible" : "a compromise", goals);
  return impossible
             ? fmt::format("impossible: no choice of the free numbers that balances it for {} keeps all limits", goals)
             : fmt::format("a compromise: balanced for {}, but not all limits are kept", goals);
}

std::string headline(const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  const std::string goals = join_goal_names(outcome.conditions.goals);
  if (!outcome.within_limits && outcome.status != DesignStatus::unsolved) return headline_beyond_limits(outcome, goals);
  switch (outcome.status) {
    case DesignStatus::unsolved: return "no design for " + goals;
    case DesignStatus::balanced:
      if (is_proved_best(view))
        return fmt::format("balanced exactly for {}, with the least {} there is", goals, view.objective);
      return "balanced exactly for " + goals;
    case DesignStatus::compromise: return fmt::format("a compromise: not balanced for {}", goals);
    case DesignStatus::infeasible:
      return fmt::format("impossible: no choice of the free numbers balances it for {}", goals);
    case DesignStatus::no_feasible_start:
      return goals.empty() ? "no design was found" : fmt::format("no design for {} was found", goals);
    case DesignStatus::no_goal:
      if (is_proved_best(view)) return fmt::format("the least {} there is; no goal was asked for", view.objective);
      if (view.objective.empty()) return "all limits are kept; no goal was asked for";
      return fmt::format("a small {}; no goal was asked for", view.objective);
  }
  return "";
}

std::string objective_line(const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  if (view.objective.empty() || std::isnan(outcome.objective)) return "";
  const std::string unit = view.objective_unit.empty() ? "" : " " + view.objective_unit;
  std::string text = fmt::format("{}: {}{}", view.objective, number_text(outcome.objective), unit);
  if (!std::isnan(outcome.lower_bound) && outcome.optimality != Optimality::proved_global)
    text += fmt::format("; at least {}{} is needed", number_text(outcome.lower_bound), unit);
  text += "\n";
  for (const RobustTerm& one : view.report.robust)
    text +=
        fmt::format("  {} of {} along {}: mean {} ({} where no number is off), deviation {}\n",
                    objective_term_name(one.term.figure), one.term.quantity, one.term.trajectory,
                    number_text(one.figure.mean), number_text(one.figure.nominal), number_text(one.figure.deviation));
  return text;
}

std::string limits_text(const DesignReportData& view) {
  const auto& limits = view.report.study_before.design.subject_to;
  const auto& found = view.report.outcome.limits;
  std::string text;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const std::string unit = limits[k].unit.empty() ? "" : " " + limits[k].unit;
    const char* state = !(found[k].violation <= limit_tolerance) ? "missed" : found[k].is_active ? "active" : "kept";
    text += fmt::format("limit {}: {}{}, {}", limits[k].text, number_text(found[k].value), unit, state);
    if (!(found[k].violation <= limit_tolerance) && limits[k].bound != 0)
      text += fmt::format(" by {:.3g} %", 100 * found[k].violation);
    text += "\n";
  }
  return text;
}

/// What is known of how good it is.
std::string optimality_line(const DesignReportData& view) {
  const DesignOutcome& outcome = view.report.outcome;
  const std::string tried = outcome.search_summary.empty() ? "" : " (" + outcome.search_summary + ")";
  const char* what = !outcome.within_limits ? "the least that limits are missed by"
                     : view.objective.empty() || std::isnan(outcome.objective)
                         ? "the least that is left of the conditions"
                         : "the best";
  switch (outcome.optimality) {
    case Optimality::not_optimised: return "optimality: not-asked: nothing was to be minimized\n";
    case Optimality::proved_global:
      if (!outcome.within_limits)
        return "optimality: proved-best: no other choice misses the worst of its limits by less\n";
      if (std::isnan(outcome.lower_bound))
        return "optimality: proved-best: no other choice leaves less of the conditions\n";
      return fmt::format("optimality: proved-best: nothing is below {}, a gap of {:.2g}\n",
                         number_text(outcome.lower_bound),
                         outcome.gap() > gap_tolerance * std::abs(outcome.objective) ? outcome.gap() : 0.0);
    case Optimality::local_optimum:
      return fmt::format("optimality: local-best: the best of what was tried{}, not shown to be {}\n", tried, what);
    case Optimality::budget_exhausted:
      if (view.interrupted)
        return fmt::format("optimality: stopped: interrupted after {:.2g} s{}, not shown to be {}\n", *view.interrupted,
                           tried, what);
      return fmt::format(
          "optimality: stopped: after the {:g} s that a search may take{}, not shown to be {}; search: {{seconds: "
          "{:g}}} "
          "gives it more\n",
          view.seconds, tried, what, 4 * view.seconds);
  }
  return "";
}

/// How much of the design could be chosen differently.
std::string freedom_line(const DesignReportData& view) {
  const SolutionSet& freedom = view.report.outcome.solution_set;
  const int count = freedom.optimal_dimension >= 0 ? freedom.optimal_dimension : freedom.dimension;
  if (count < 0) return "";
  if (count == 0)
    return fmt::format("freedom: none is left: no other solution {}is near\n",
                       view.objective.empty() ? "" : "as good ");
  std::string numbers;
  for (const int i : freedom.free_variables)
    numbers += (numbers.empty() ? "" : ", ") + view.report.free_numbers[static_cast<std::size_t>(i)].key_path;
  if (freedom.optimal_dimension < 0)
    return fmt::format("freedom: the conditions leave {}, spent on a small {}: {}\n", count, view.objective, numbers);
  const bool figure = !view.objective.empty();
  return fmt::format("freedom: {} {} left{}: one of many solutions; what may still change: {}\n", count,
                     count == 1 ? "is" : "are", figure ? fmt::format(", with the same {}", view.objective) : "",
                     numbers);
}

/// Each sentence once, although several parts of the report may have it.
class UniqueSentences {
 public:
  void add(const std::string& sentence) {
    if (!sentence.empty() && text_.find(sentence) == std::string::npos) text_ += sentence + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string reasons(const DesignReportData& view) {
  UniqueSentences sentences;
  sentences.add(view.report.outcome.reason);
  if (view.report.outcome.certificate) sentences.add(view.report.outcome.certificate->statement);
  if (view.report.outcome.status == DesignStatus::infeasible)
    sentences.add(view.report.outcome.is_proved_infeasible ? "impossibility: proved" : "impossibility: not proved");
  return sentences.text() + objective_line(view) + limits_text(view) + format_optional_elements(view.report) +
         optimality_line(view) + freedom_line(view);
}

std::string bound_remark(const FreeNumber& number, int bound) {
  if (!number.discrete_values.empty()) return fmt::format("one of {} sizes", number.discrete_values.size());
  return bound < 0 ? "at its lower bound" : (bound > 0 ? "at its upper bound" : "");
}

/// What "before" is where nobody has said it.
std::string format_start_note(const std::vector<FreeNumber>& numbers) {
  std::string middle;
  for (const FreeNumber& number : numbers)
    if (number.start_source == FreeNumber::StartSource::midpoint)
      middle += (middle.empty() ? "" : ", ") + number.key_path;
  return middle.empty() ? "" : fmt::format("before: in the middle of the bounds, for want of a 'start': {}\n", middle);
}

std::string numbers_text(const DesignReportData& view) {
  const DesignReport& report = view.report;
  TextTable table{{"free number [SI]", "lower", "upper", "before (start)", "value", ""},
                  {Align::left, Align::right, Align::right, Align::right, Align::right, Align::left},
                  {}};
  for (std::size_t i = 0; i < report.free_numbers.size(); ++i) {
    const FreeNumber& number = report.free_numbers[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double value = report.outcome.x[k];
    const int bound = active_bound(number, value);
    // What rounding leaves of a zero says nothing.
    const bool zero = std::abs(value) < 1e-12 * (number.upper - number.lower);
    table.rows.push_back({number.key_path, fmt::format("{:g}", number.lower), fmt::format("{:g}", number.upper),
                          number_text(report.before[k]), number_text(zero ? 0 : value), bound_remark(number, bound)});
  }
  return format_table(table) + format_start_note(report.free_numbers) + "\n";
}

std::string residual_text(double residual) {
  if (std::isnan(residual)) return "-";
  return std::abs(residual) <= condition_tolerance ? "met" : fmt::format("{:.2g}", std::abs(residual));
}

std::string conditions_table(const DesignReportData& view) {
  const ConditionsReportData& c = view.conditions;
  TextTable table{{"no", "condition", "before", "after"}, {Align::right, Align::left, Align::right, Align::right}, {}};
  std::vector<int> hidden;
  for (int row = 0; row < c.parameter_rows(); ++row) {
    if (c.holds_by_definition[static_cast<std::size_t>(row)]) {
      hidden.push_back(row + 1);
      continue;
    }
    const auto lines = wrap_condition(c, row, 76);
    for (std::size_t i = 0; i < lines.size(); ++i)
      table.rows.push_back({i == 0 ? std::to_string(row + 1) : "", lines[i],
                            i == 0 ? residual_text(view.residuals_before[row]) : "",
                            i == 0 ? residual_text(c.residuals[row]) : ""});
  }
  std::string text = table.rows.empty() ? "" : format_table(table);
  const std::string symbols = symbols_text(c);
  if (!symbols.empty()) text += "where " + symbols + "\n";
  if (!hidden.empty())
    text += fmt::format("{} {} for every disc that is symmetrical about its axis\n", format_ranges(hidden),
                        hidden.size() == 1 ? "holds" : "hold");
  text += format_remainder(c);
  return text.empty() ? "" : text + "\n";
}

std::string cost_text(const DesignReport& report) {
  const auto amount = [](double value, double scale) {
    return std::abs(value) <= 1e-12 * scale ? "0" : fmt::format("{:.6g}", value);
  };
  return fmt::format(
             "added mass     {} kg of counterweights and discs (everything that moves: {:.6g} kg before, {:.6g} kg "
             "after)\n",
             amount(report.added_mass, report.mass_after), report.mass_before, report.mass_after) +
         fmt::format(
             "added inertia  {} kg m^2 of them (everything that moves: {:.6g} kg m^2 before, {:.6g} kg m^2 after)\n",
             amount(report.added_inertia, report.inertia_after), report.inertia_before, report.inertia_after);
}

/// What a user should know of the motion, once where before and after say the same.
std::string rerun_notes(const TrajectoryComparison& comparison) {
  const auto &before = comparison.before.outcome.notes, &after = comparison.after.outcome.notes;
  const auto has = [](const std::vector<std::string>& notes, const std::string& note) {
    return std::find(notes.begin(), notes.end(), note) != notes.end();
  };
  std::string text;
  for (const std::string& note : before) text += fmt::format("note{}: {}\n", has(after, note) ? "" : ", before", note);
  for (const std::string& note : after)
    if (!has(before, note)) text += fmt::format("note, after: {}\n", note);
  return text;
}

std::string comparison_text(const TrajectoryComparison& comparison) {
  std::string text = fmt::format("\ntrajectory {}\n", comparison.trajectory);
  const bool moved =
      comparison.before.outcome.status == MotionStatus::done && comparison.after.outcome.status == MotionStatus::done;
  for (const auto& [when, result] : {std::pair("before", &comparison.before), std::pair("after", &comparison.after)})
    if (result->outcome.status != MotionStatus::done)
      text += fmt::format("cannot be followed {}: {}\n", when, result->outcome.reason);
  if (!moved) return text + rerun_notes(comparison);
  TextTable table{{"quantity", "unit", "peak before", "after", "ratio", "rms before", "after", "ratio"}, {}, {}};
  table.align.assign(table.heading.size(), Align::right);
  table.align[0] = table.align[1] = Align::left;
  const std::vector<MetricChange> changes = list_metric_changes(comparison);
  const std::size_t actuators = comparison.before.actuator_names.size();
  for (std::size_t i = 0; i + 1 < changes.size(); i += 2) {
    const bool worst = changes[i].quantity == "torque";
    if (worst && actuators == 1) continue;  // it has a line of its own
    std::vector<std::string> row = {worst ? "torque, the worst" : changes[i].quantity, changes[i].unit};
    for (const MetricChange& change : {changes[i], changes[i + 1]}) {
      row.push_back(number_text(change.before));
      row.push_back(number_text(change.after));
      row.push_back(ratio_text(change.before, change.after));
    }
    table.rows.push_back(std::move(row));
  }
  return (table.rows.empty() ? text : text + format_table(table)) + rerun_notes(comparison);
}

std::string notes_text(const DesignReportData& view) {
  std::string text;
  for (const auto* notes : {&view.report.outcome.notes, &view.report.notes, &view.conditions.conditions.notes,
                            &view.conditions.names.notes})
    for (const std::string& note : *notes)
      if (text.find(note) == std::string::npos) text += "note: " + note + "\n";
  return text.empty() ? "" : "\n" + text;
}

}  // namespace

std::string design_text(const DesignReportData& view) {
  std::string text = fmt::format("{}: {}\n{}\n", view.conditions.title, headline(view), reasons(view));
  text += numbers_text(view) + conditions_table(view) + cost_text(view.report) + load_cases_text(view.report);
  for (const TrajectoryComparison& comparison : view.report.comparisons) text += comparison_text(comparison);
  return text + notes_text(view);
}

}  // namespace balance
