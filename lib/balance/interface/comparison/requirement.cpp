#include "balance/interface/comparison/requirement.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/comparison/figure_evaluation.hpp"
#include "balance/interface/comparison/requirement_parser.hpp"
#include "balance/mechanics/results/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace balance::comparison {
namespace {

/// Values of the variables that stand for figures.
using Values = std::map<std::string, double>;

double evaluate_figure_expression(const std::string& expression, const Values& values) {
  const auto value = [&](const std::string& name) -> Expression {
    const auto found = values.find(name);
    if (found == values.end()) throw expression::ExpressionError("unknown name " + quote_for_message(name));
    return found->second;
  };
  return expression::parse_expression(expression, value).value();
}

template <class Visitor>
void for_each_figure(const Requirement& requirement, Visitor&& visit) {
  for (const RequirementComparison& comparison : requirement.comparisons) {
    for (const FigureExpression* side : {&comparison.left, &comparison.right})
      for (const FigureReference& figure : side->figures) visit(figure);
  }
}

/// Checks the arithmetic by evaluating it with ones. @param column of messages
void check_arithmetic(const FigureExpression& side, std::size_t column) {
  Values ones;
  for (const FigureReference& figure : side.figures) ones[figure.variable] = 1;
  try {
    evaluate_figure_expression(side.expression, ones);
  } catch (const expression::ExpressionError& error) {
    throw RequirementError(column,
                           quote_for_message(side.text) + ": " + error.what() + format_decimal_point_hint(side.text));
  }
}

const MetricTable& find_table(const std::string& name, const std::vector<MetricTable>& tables) {
  const auto found =
      std::find_if(tables.begin(), tables.end(), [&](const MetricTable& table) { return table.name == name; });
  if (found == tables.end())
    throw std::invalid_argument("there are no figures of a run called " + quote_for_message(name));
  return *found;
}

void add_once(std::vector<std::string>& texts, const std::string& text) {
  if (std::find(texts.begin(), texts.end(), text) == texts.end()) texts.push_back(text);
}

const MetricTable& find_metric_table(const FigureReference& figure, const std::vector<MetricTable>& tables,
                                     std::size_t run) {
  return figure.run.empty() ? tables.at(run) : find_table(figure.run, tables);
}

/// The figure as the table has it. @return without a value if the table lacks it
EvaluatedFigure find_answer(const FigureReference& figure, const MetricTable& table) {
  EvaluatedFigure answer;
  answer.text = figure.text();
  const Metric* metric = figure.function->statistic ? find_metric(table, figure.quantity) : nullptr;
  if (metric != nullptr) {
    answer.value = statistic_of(*metric, *figure.function->statistic);
    answer.unit = metric->unit;
  } else if (has_figure(table, figure)) {
    answer.value = table.energy;
    answer.unit = figure.function->unit;
  } else if (const EvaluatedFigure* found = find_evaluated_figure(table, answer.text)) {
    answer = *found;
  } else {
    answer.mistaken_name = figure.quantity.empty() ? figure.function->name : figure.quantity;
    answer.mistake = "missing";
  }
  return answer;
}

double value_of(const FigureReference& figure, const MetricTable& table) { return find_answer(figure, table).value; }

/// Whether the side is a number in the figures' own unit: a constant, or linear in a common factor of all figures.
bool has_unit_of_figures(const FigureExpression& side, const std::vector<MetricTable>& tables, std::size_t run) {
  constexpr double step = 1e-3, round_off = 1e-9;
  const auto evaluate_scaled = [&](double factor) {
    Values values;
    for (const FigureReference& figure : side.figures) {
      const double value = value_of(figure, find_metric_table(figure, tables, run));
      values[figure.variable] = factor * (value == 0 ? 1 : value);
    }
    return evaluate_figure_expression(side.expression, values);
  };
  if (side.figures.empty()) return true;
  const double minus = evaluate_scaled(1 - step), nominal = evaluate_scaled(1), plus = evaluate_scaled(1 + step),
               change = std::abs(plus - minus);
  return change > round_off * std::abs(nominal) && std::abs(plus - 2 * nominal + minus) <= round_off * change;
}

/// Whether the expression changes as much as each of its figures, or not at all.
bool is_plain_sum_of_figures(const FigureExpression& expression, const std::vector<MetricTable>& tables,
                             std::size_t run) {
  constexpr double step = 1e-3, slope_tolerance = 1e-6;
  Values values;
  for (const FigureReference& figure : expression.figures)
    values[figure.variable] = value_of(figure, find_metric_table(figure, tables, run));
  for (const auto& [variable, value] : values) {
    const double change = step * (value == 0 ? 1 : std::abs(value));
    Values lower = values, upper = values;
    lower[variable] = value - change;
    upper[variable] = value + change;
    const double slope = std::abs(evaluate_figure_expression(expression.expression, upper) -
                                  evaluate_figure_expression(expression.expression, lower)) /
                         (2 * change);
    if (!(std::min(slope, std::abs(slope - 1)) <= slope_tolerance)) return false;
  }
  return true;
}

/// The unit of all sides; empty if the figures' units differ or a side is a product, ratio, root, … of figures.
std::string common_unit(std::initializer_list<const FigureExpression*> sides, const std::vector<MetricTable>& tables,
                        std::size_t run) {
  std::vector<std::string> units;
  bool keeps_unit = true;
  for (const FigureExpression* side : sides) {
    for (const FigureReference& figure : side->figures)
      add_once(units, find_answer(figure, find_metric_table(figure, tables, run)).unit);
    keeps_unit = keeps_unit && has_unit_of_figures(*side, tables, run);
  }
  return units.size() == 1 && keeps_unit ? units.front() : "";
}

double evaluate(const FigureExpression& side, const std::vector<MetricTable>& tables, std::size_t run,
                std::vector<std::string>& missing) {
  Values values;
  bool has_all_values = true;
  for (const FigureReference& figure : side.figures) {
    const MetricTable& table = find_metric_table(figure, tables, run);
    const EvaluatedFigure answer = find_answer(figure, table);
    const double value = answer.value;
    if (!answer.reason.empty())
      add_once(missing, fmt::format("{}: {}", table.name, answer.reason));
    else if (!answer.mistaken_name.empty())
      add_once(missing, fmt::format("{} has no {}", table.name, answer.mistaken_name));
    else if (!answer.mistake.empty())
      add_once(missing, fmt::format("{}: {}", table.name, answer.mistake));
    // min(…), max(…) and the like could hide a NaN.
    has_all_values = has_all_values && !std::isnan(value);
    values[figure.variable] = value;
  }
  return has_all_values ? evaluate_figure_expression(side.expression, values)
                        : std::numeric_limits<double>::quiet_NaN();
}

std::vector<comparison::RequirementToken> tokenise(const std::string& text, const RunNames& runs) {
  if (text.size() > expression::max_expression_length)
    throw RequirementError(1, fmt::format("it is longer than {} characters", expression::max_expression_length));
  return comparison::tokenise_requirement(text, runs);
}

bool combine_comparisons(const Requirement& requirement, const std::vector<JudgedComparison>& judged) {
  std::vector<bool> stack;
  for (const Requirement::PostfixStep& step : requirement.steps) {
    if (step.kind == Requirement::PostfixStep::Kind::compare) {
      stack.push_back(judged[step.comparison].holds());
      continue;
    }
    const bool last = stack.back();
    stack.pop_back();
    stack.back() =
        step.kind == Requirement::PostfixStep::Kind::logical_and ? stack.back() && last : stack.back() || last;
  }
  return stack.back();
}

}  // namespace

RequirementError::RequirementError(std::size_t where, const std::string& message)
    : std::runtime_error(fmt::format("column {}: {}", where, message)), column(where) {}

bool Requirement::applies_to_each_run() const {
  bool found = false;
  for_each_figure(*this, [&](const FigureReference& figure) { found = found || figure.run.empty(); });
  return found;
}

std::vector<std::string> Requirement::named_runs() const {
  std::vector<std::string> names;
  for_each_figure(*this, [&](const FigureReference& figure) {
    if (!figure.run.empty()) add_once(names, figure.run);
  });
  return names;
}

Requirement parse_requirement(const std::string& text, const RunNames& runs) {
  Requirement requirement = comparison::parse_requirement_tokens(tokenise(text, runs), text, runs);
  for (const RequirementComparison& comparison : requirement.comparisons) {
    check_arithmetic(comparison.left, comparison.column);
    if (comparison.word.empty()) check_arithmetic(comparison.right, comparison.column);
  }
  return requirement;
}

FigureExpression parse_figure_expression(const std::string& text, const RunNames& runs) {
  FigureExpression expression = comparison::parse_expression_tokens(tokenise(text, runs), text, runs);
  check_arithmetic(expression, 1);
  return expression;
}

void check_quantities(const Requirement& requirement, const std::vector<std::string>& quantities) {
  for_each_figure(requirement, [&](const FigureReference& figure) {
    const bool known = std::find(quantities.begin(), quantities.end(),
                                 results::resolve_quantity_name(figure.quantity, quantities)) != quantities.end();
    if (!figure.function->statistic || known) return;
    throw RequirementError(figure.column, fmt::format("no run has a quantity {}{}", quote_for_message(figure.quantity),
                                                      append_nearest_name(figure.quantity, quantities)));
  });
}

namespace {

/// @throws RequirementError if the figure is a mistake in every table that was asked for it
void check_figure(const FigureReference& figure, const std::vector<MetricTable>& tables) {
  EvaluatedFigure mistaken;
  for (const MetricTable& table : tables) {
    if (has_figure(table, figure)) return;
    const EvaluatedFigure* answer = find_evaluated_figure(table, figure.text());
    if (answer == nullptr) continue;
    if (answer->mistake.empty()) return;
    if (mistaken.mistake.empty()) mistaken = *answer;
  }
  if (mistaken.mistake.empty()) {  // no table was asked
    if (!figure.function->statistic) return;
    const std::vector<std::string> names = list_quantity_names(tables);
    throw RequirementError(figure.column, fmt::format("no run has a quantity {}{}", quote_for_message(figure.quantity),
                                                      append_nearest_name(figure.quantity, names)));
  }
  const bool is_in_moment = figure.moment.has_quantity() && mistaken.mistaken_name == figure.moment.quantity &&
                            mistaken.mistaken_name != figure.quantity;
  throw RequirementError(is_in_moment ? figure.moment.column : figure.column, mistaken.mistake);
}

}  // namespace

void check_figures(const Requirement& requirement, const std::vector<MetricTable>& tables) {
  for_each_figure(requirement, [&](const FigureReference& figure) { check_figure(figure, tables); });
}

ExpressionAnswer evaluate_expression(const FigureExpression& expression, const std::vector<MetricTable>& tables,
                                     std::size_t run) {
  for (const FigureReference& figure : expression.figures)
    check_figure(figure, {find_metric_table(figure, tables, run)});
  ExpressionAnswer answer;
  answer.value = evaluate(expression, tables, run, answer.missing);
  answer.unit = common_unit({&expression}, tables, run);
  answer.is_plain_sum = is_plain_sum_of_figures(expression, tables, run);
  return answer;
}

std::vector<FigureReference> list_figures(const Requirement& requirement) {
  std::vector<FigureReference> figures;
  for_each_figure(requirement, [&](const FigureReference& figure) { figures.push_back(figure); });
  return figures;
}

bool refers_to_verdict(const Requirement& requirement) {
  return std::any_of(requirement.comparisons.begin(), requirement.comparisons.end(),
                     [](const RequirementComparison& comparison) { return !comparison.word.empty(); });
}

RequirementVerdict judge_requirement(const Requirement& requirement, const std::vector<MetricTable>& tables,
                                     std::size_t run) {
  RequirementVerdict verdict;
  verdict.requirement = requirement.text;
  if (requirement.applies_to_each_run()) verdict.run = tables.at(run).name;
  for (const RequirementComparison& comparison : requirement.comparisons) {
    JudgedComparison judged{comparison.left.text, comparison.right.text, comparison.relation};
    if (!comparison.word.empty()) {
      const FigureReference& figure = comparison.left.figures.front();
      const EvaluatedFigure answer = find_answer(figure, find_metric_table(figure, tables, run));
      judged.words = answer.word;
      judged.word = comparison.word;
      judged.left = judged.right = std::numeric_limits<double>::quiet_NaN();
      if (!answer.has_value())
        add_once(verdict.missing, fmt::format("{} has no verdict", find_metric_table(figure, tables, run).name));
      verdict.compared.push_back(judged);
      continue;
    }
    judged.left = evaluate(comparison.left, tables, run, verdict.missing);
    judged.right = evaluate(comparison.right, tables, run, verdict.missing);
    judged.unit = common_unit({&comparison.left, &comparison.right}, tables, run);
    verdict.compared.push_back(judged);
  }
  verdict.holds = combine_comparisons(requirement, verdict.compared);
  return verdict;
}

std::vector<RequirementVerdict> judge_each_run(const Requirement& requirement, const std::vector<MetricTable>& tables) {
  if (!requirement.applies_to_each_run()) return {judge_requirement(requirement, tables, 0)};
  std::vector<RequirementVerdict> verdicts;
  for (std::size_t run = 1; run < tables.size(); ++run) verdicts.push_back(judge_requirement(requirement, tables, run));
  return verdicts;
}

namespace {

/// Evaluates what a requirement asks of every run that it is judged for.
void evaluate_figures_of_runs(const Requirement& requirement, const std::vector<NamedRun>& runs,
                              std::vector<MetricTable>& tables) {
  const std::vector<FigureReference> figures = list_figures(requirement);
  for (std::size_t run = 0; run < runs.size(); ++run) {
    std::vector<FigureReference> asked;
    for (const FigureReference& figure : figures)
      if ((figure.run.empty() || figure.run == runs[run].name) && !has_figure(tables[run], figure))
        asked.push_back(figure);
    if (asked.empty()) continue;
    FigureSubject subject;
    subject.run = &runs[run].result;
    subject.mechanism = runs[run].mechanism.get();
    FigureEvaluator evaluator(std::move(subject));
    evaluate_figures(asked, evaluator, tables[run]);
  }
}

}  // namespace

std::vector<RequirementVerdict> judge_requirements(const std::vector<std::string>& texts,
                                                   const std::vector<NamedRun>& runs) {
  RunNames names;
  for (const NamedRun& run : runs) names.all.push_back(run.name);
  names.base = names.all.front();
  std::vector<MetricTable> tables = make_metric_tables(runs);
  std::vector<RequirementVerdict> verdicts;
  for (const std::string& text : texts) {
    try {
      const Requirement requirement = parse_requirement(text, names);
      evaluate_figures_of_runs(requirement, runs, tables);
      check_figures(requirement, tables);
      for (RequirementVerdict& verdict : judge_each_run(requirement, tables)) verdicts.push_back(std::move(verdict));
    } catch (const RequirementError& error) {
      throw std::invalid_argument(quote_for_message(text) + ": " + error.what());
    }
  }
  return verdicts;
}

}  // namespace balance::comparison
