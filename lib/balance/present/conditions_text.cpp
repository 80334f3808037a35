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

constexpr std::size_t condition_width = 76;

std::string plural(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string residual_text(const ConditionsView& view, int row) {
  return view.is_met(row) ? "met" : fmt::format("{:.2g}", std::abs(view.residuals[row]));
}

/// Rows for one condition: further lines of a long one have only that cell.
void add_rows(Table& table, const ConditionsView& view, int row) {
  const auto lines = wrapped_condition(view, row, condition_width);
  std::vector<std::string> free;
  for (const int number : view.occurring[static_cast<std::size_t>(row)])
    free.push_back(view.numbers[static_cast<std::size_t>(number)].path);
  const bool with_free = table.heading.size() > 3;
  const std::size_t height = std::max(lines.size(), with_free ? free.size() : 0);
  for (std::size_t i = 0; i < height; ++i) {
    std::vector<std::string> cells = {i == 0 ? std::to_string(row + 1) : "", i < lines.size() ? lines[i] : "",
                                      i == 0 ? residual_text(view, row) : ""};
    if (with_free) cells.push_back(i < free.size() ? free[i] : (i == 0 ? "nothing free" : ""));
    table.rows.push_back(std::move(cells));
  }
}

std::string table_text(const ConditionsView& view) {
  Table table{{"no", "condition", "now"}, {Align::right, Align::left, Align::right}, {}};
  if (!view.numbers.empty()) {
    table.heading.push_back("depends on");
    table.align.push_back(Align::left);
  }
  for (int row = 0; row < view.own_rows(); ++row)
    if (!view.by_definition[static_cast<std::size_t>(row)]) add_rows(table, view, row);
  return table.rows.empty() ? "" : format_table(table) + "\n";
}

std::string heading_text(const ConditionsView& view) {
  const Conditions& c = view.conditions;
  std::string text = fmt::format("{}: {} conditions{}\n", view.title, list_names(c.goals),
                                 view.strategy == "modular" ? ", chain by chain" : "");
  for (const Goal& goal : c.goals) text += in_words(goal) + "\n";
  text += fmt::format("\nrank {} of {}", view.own_rows(),
                      plural(static_cast<std::size_t>(c.own_columns()), "parameter", "parameters"));
  if (c.rank > 0 && c.gap > 0) text += fmt::format(", gap {:.1f} decades", elementary::log10(c.gap));
  if (c.samples > 0) text += ", " + plural(static_cast<std::size_t>(c.samples), "sample", "samples");
  return text + "\n\n";
}

std::string closing_text(const ConditionsView& view) {
  std::vector<int> hidden;
  long open = 0;
  for (int row = 0; row < view.own_rows(); ++row) {
    if (view.by_definition[static_cast<std::size_t>(row)]) hidden.push_back(row + 1);
    if (!view.is_met(row)) ++open;
  }
  std::string text;
  if (!hidden.empty())
    text += fmt::format("{} {} for every disc that is symmetrical about its axis\n", ranges_text(hidden),
                        hidden.size() == 1 ? "holds" : "hold");
  if (view.own_rows() == 0 && !view.staying.empty()) return text;
  if (view.own_rows() == 0) return text + "nothing is asked for: the mechanism is balanced as it is\n";
  if (open == 0) return text + (view.staying.empty() ? "all are met\n" : "all that masses can meet are met\n");
  return text + fmt::format("{} of {} not met: now is what is missing, relative to the size of the terms\n", open,
                            view.own_rows());
}

std::string effort_text(const StayingEffort& effort) {
  return fmt::format("{:.4g} {} at {} {}", effort.size, effort.unit, effort.actuator,
                     effort.trajectory.empty() ? "at rest" : "along " + effort.trajectory);
}

}  // namespace

std::string ranges_text(const std::vector<int>& rows) {
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

std::vector<std::string> wrapped_condition(const ConditionsView& view, int row, std::size_t width) {
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

std::string symbols_text(const ConditionsView& view) {
  std::string text;
  for (const auto* symbols : {&view.names.symbols, &view.known}) {
    for (const Symbol& symbol : *symbols) {
      text += (text.empty() ? "" : ", ") + fmt::format("{} = {:.6g}", symbol.label, symbol.value);
      if (symbol.unit != "1") text += " " + symbol.unit;
    }
  }
  return text;
}

std::string staying_text(const ConditionsView& view) {
  if (view.staying.empty()) return "";
  std::string text = "cannot be balanced by masses or springs, and stays:\n";
  for (const Staying& staying : view.staying) {
    text += "  " + staying.text + "\n";
    for (const StayingEffort& effort : staying.efforts) text += "      up to " + effort_text(effort) + "\n";
    for (const auto& unknown : staying.unknown)
      if (unknown.trajectory.empty()) text += "      not known at rest: " + unknown.reason + "\n";
  }
  std::vector<std::string> lost;
  for (const Staying& staying : view.staying)
    for (const auto& unknown : staying.unknown)
      if (!unknown.trajectory.empty() && std::find(lost.begin(), lost.end(), unknown.trajectory) == lost.end())
        lost.push_back(unknown.trajectory);
  if (!lost.empty()) text += fmt::format("not known along {}, which cannot be followed\n", fmt::join(lost, ", "));
  return text + "--without leaves it out\n";
}

std::string conditions_text(const ConditionsView& view) {
  std::string text = heading_text(view) + table_text(view);
  const std::string symbols = symbols_text(view);
  if (!symbols.empty()) text += "where " + symbols + "\n";
  text += closing_text(view) + staying_text(view);
  for (const std::string& note : view.conditions.notes) text += "note: " + note + "\n";
  for (const std::string& note : view.names.notes) text += "note: " + note + "\n";
  return text;
}

}  // namespace balance
