#include "balance/present/conditions_text.hpp"

#include "balance/base/elementary.hpp"
#include "balance/present/names.hpp"
#include "balance/write/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace balance {
namespace {

constexpr std::size_t max_condition_width = 76;

std::string plural(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string residual_text(const ConditionsReportData& view, int row) {
  return view.is_met(row) ? "met" : fmt::format("{:.2g}", std::abs(view.residuals[row]));
}

/// Rows for one condition: further lines of a long one have only that cell.
void add_rows(TextTable& table, const ConditionsReportData& view, int row) {
  const auto lines = wrap_condition(view, row, max_condition_width);
  std::vector<std::string> free;
  for (const int number : view.free_number_indices[static_cast<std::size_t>(row)])
    free.push_back(view.numbers[static_cast<std::size_t>(number)].key_path);
  const bool with_free = table.heading.size() > 3;
  const std::size_t height = std::max(lines.size(), with_free ? free.size() : 0);
  for (std::size_t i = 0; i < height; ++i) {
    std::vector<std::string> cells = {i == 0 ? std::to_string(row + 1) : "", i < lines.size() ? lines[i] : "",
                                      i == 0 ? residual_text(view, row) : ""};
    if (with_free) cells.push_back(i < free.size() ? free[i] : (i == 0 ? "nothing free" : ""));
    table.rows.push_back(std::move(cells));
  }
}

std::string table_text(const ConditionsReportData& view) {
  TextTable table{{"no", "condition", "now"}, {Align::right, Align::left, Align::right}, {}};
  if (!view.numbers.empty()) {
    table.heading.push_back("depends on");
    table.align.push_back(Align::left);
  }
  for (int row = 0; row < view.parameter_rows(); ++row)
    if (!view.holds_by_definition[static_cast<std::size_t>(row)]) add_rows(table, view, row);
  return table.rows.empty() ? "" : format_table(table) + "\n";
}

std::string heading_text(const ConditionsReportData& view) {
  const Conditions& c = view.conditions;
  std::string text = fmt::format("{}: {} conditions{}\n", view.title, join_goal_names(c.goals),
                                 view.strategy == "modular" ? ", chain by chain" : "");
  for (const Goal& goal : c.goals) text += describe_goal(goal) + "\n";
  text += fmt::format("\nrank {} of {}", view.parameter_rows(),
                      plural(static_cast<std::size_t>(c.parameter_columns()), "parameter", "parameters"));
  if (c.rank > 0 && c.singular_value_gap > 0)
    text += fmt::format(", gap {:.1f} decades", elementary::log10(c.singular_value_gap));
  if (c.samples > 0) text += ", " + plural(static_cast<std::size_t>(c.samples), "sample", "samples");
  return text + "\n\n";
}

std::string closing_text(const ConditionsReportData& view) {
  std::vector<int> hidden;
  long open = 0;
  for (int row = 0; row < view.parameter_rows(); ++row) {
    if (view.holds_by_definition[static_cast<std::size_t>(row)]) hidden.push_back(row + 1);
    if (!view.is_met(row)) ++open;
  }
  std::string text;
  if (!hidden.empty())
    text += fmt::format("{} {} for every disc that is symmetrical about its axis\n", format_ranges(hidden),
                        hidden.size() == 1 ? "holds" : "hold");
  if (view.parameter_rows() == 0 && !view.unbalanced_remainder.empty()) return text;
  if (view.parameter_rows() == 0) return text + "nothing is asked for: the mechanism is balanced as it is\n";
  if (open == 0)
    return text + (view.unbalanced_remainder.empty() ? "all are met\n" : "all that masses can meet are met\n");
  return text + fmt::format("{} of {} not met: now is what is missing, relative to the size of the terms\n", open,
                            view.parameter_rows());
}

std::string effort_text(const RemainderEffort& effort) {
  return fmt::format("{:.4g} {} at {} {}", effort.magnitude, effort.unit, effort.actuator,
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

std::vector<std::string> wrap_condition(const ConditionsReportData& view, int row, std::size_t width) {
  const std::string text = condition_text(view.conditions, row, view.names);
  std::vector<std::string> lines;
  std::string line, term;
  const auto finish_term = [&] {
    // Further lines are indented by four.
    const std::size_t room = lines.empty() ? width : width - 4;
    if (!line.empty() && line.size() + 1 + term.size() > room) {
      lines.push_back((lines.empty() ? "" : "    ") + line);
      line.clear();
    }
    line += (line.empty() ? "" : " ") + term;
    term.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    // A term begins with its sign; signs inside brackets belong to their term.
    const bool sign = text.compare(i, 3, " + ") == 0 || text.compare(i, 3, " - ") == 0;
    const auto depth = std::count(term.begin(), term.end(), '(') - std::count(term.begin(), term.end(), ')');
    if (sign && depth == 0)
      finish_term();
    else
      term += text[i];
  }
  finish_term();
  lines.push_back((lines.empty() ? "" : "    ") + line);
  return lines;
}

std::string symbols_text(const ConditionsReportData& view) {
  std::string text;
  for (const auto* symbols : {&view.names.symbols, &view.known_terms}) {
    for (const GeometricSymbol& symbol : *symbols) {
      text += (text.empty() ? "" : ", ") + fmt::format("{} = {:.6g}", symbol.label, symbol.value);
      if (symbol.unit != "1") text += " " + symbol.unit;
    }
  }
  return text;
}

std::string format_remainder(const ConditionsReportData& view) {
  if (view.unbalanced_remainder.empty()) return "";
  std::string text = "cannot be balanced by masses or springs, and stays:\n";
  for (const UnbalancedRemainder& staying : view.unbalanced_remainder) {
    text += "  " + staying.text + "\n";
    for (const RemainderEffort& effort : staying.efforts) text += "      up to " + effort_text(effort) + "\n";
    for (const auto& unknown : staying.failed_trajectories)
      if (unknown.trajectory.empty()) text += "      not known at rest: " + unknown.reason + "\n";
  }
  std::vector<std::string> lost;
  for (const UnbalancedRemainder& staying : view.unbalanced_remainder)
    for (const auto& unknown : staying.failed_trajectories)
      if (!unknown.trajectory.empty() && std::find(lost.begin(), lost.end(), unknown.trajectory) == lost.end())
        lost.push_back(unknown.trajectory);
  if (!lost.empty()) text += fmt::format("not known along {}, which cannot be followed\n", fmt::join(lost, ", "));
  return text + "--without leaves it out\n";
}

std::string conditions_text(const ConditionsReportData& view) {
  std::string text = heading_text(view) + table_text(view);
  const std::string symbols = symbols_text(view);
  if (!symbols.empty()) text += "where " + symbols + "\n";
  text += closing_text(view) + format_remainder(view);
  for (const std::string& note : view.conditions.notes) text += "note: " + note + "\n";
  for (const std::string& note : view.names.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace balance
