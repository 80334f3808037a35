#include "balance/present/comparison_text.hpp"

#include "balance/base/plain_text.hpp"
#include "balance/present/markdown.hpp"
#include "balance/write/csv_field.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

namespace balance {
namespace {

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.17g}", value) : ""; }

class CsvRows {
 public:
  explicit CsvRows(const ComparedRuns& compared) : compared_(compared) {}

  void add(const std::string& quantity, const std::string& unit, const char* figure, std::size_t run, double value,
           double ratio = NAN) {
    text_ += fmt::format("{},{},{},{},{},{}\n", escape_csv_field(quantity), escape_csv_field(unit), figure,
                         escape_csv_field(compared_.runs[run].name), number(value), number(ratio));
  }

  void add(const ComparedQuantity& q, std::size_t run) {
    const auto& metric = q.metrics[run];
    for (const auto& [figure, name] : {std::pair{Statistic::peak, "peak"},
                                       {Statistic::rms, "rms"},
                                       {Statistic::mean, "mean"},
                                       {Statistic::range, "range"}}) {
      add(q.quantity, q.unit, name, run, metric ? statistic_of(*metric, figure) : NAN, ratio_to_base(q, run, figure));
    }
    add(q.quantity, "s", "peak_time", run, metric ? metric->peak_time : NAN);
    if (run == 0) return;
    const std::optional<Difference>& difference = q.differences[run];
    add(q.quantity, q.unit, "largest_difference", run, difference ? difference->largest : NAN);
    add(q.quantity, "s", "difference_time", run, difference ? difference->time : NAN);
    add(q.quantity, q.unit, "rms_difference", run, difference ? difference->rms : NAN);
  }

  const std::string& text() const { return text_; }

 private:
  const ComparedRuns& compared_;
  std::string text_ = "quantity,unit,figure,run,value,ratio\n";
};

}  // namespace

std::string format_verdict_line(const RequirementVerdict& verdict) {
  return escape_for_terminal(fmt::format("{:<6} {}{}{}{}: {}", verdict.holds ? "ok" : "FAILED", verdict.requirement,
                                         verdict.run.empty() ? "" : " [", verdict.run, verdict.run.empty() ? "" : "]",
                                         describe_verdict(verdict)));
}

std::string format_verdicts(const std::vector<RequirementVerdict>& verdicts) {
  std::string text;
  for (const RequirementVerdict& verdict : verdicts) text += format_verdict_line(verdict) + "\n";
  return text;
}

std::string comparison_text(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                            QuantitySelection shown) {
  std::string text;
  for (const TitledTextTable& one : make_comparison_tables(compared, shown)) {
    text += one.title + "\n\n" + format_table(one.table) + "\n";
  }
  for (const std::string& note : compared.notes) text += "note: " + escape_for_terminal(note) + "\n";
  if (!compared.notes.empty() && !verdicts.empty()) text += "\n";
  if (!verdicts.empty()) text += format_verdicts(verdicts) + "\n" + format_verdict_count(verdicts) + "\n";
  if (text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string comparison_markdown(const ComparedRuns& compared, const std::vector<RequirementVerdict>& verdicts,
                                QuantitySelection shown) {
  std::string text = "# Comparison with " + escape_markdown(compared.runs.front().name) + "\n";
  if (!verdicts.empty()) {
    constexpr std::size_t requirement = 1;
    text += "\n## Requirements\n\n" + format_verdict_count(verdicts) + ".\n\n" +
            format_markdown_table(verdict_table(verdicts), {requirement});
  }
  for (const TitledTextTable& one : make_comparison_tables(compared, shown)) {
    std::string title = one.title;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    text += "\n## " + escape_markdown(title) + "\n\n" + format_markdown_table(one.table);
  }
  for (const std::string& note : compared.notes) text += "\nNote: " + escape_markdown(note) + "\n";
  return text;
}

std::string comparison_csv(const ComparedRuns& compared) {
  CsvRows rows(compared);
  for (const ComparedQuantity& quantity : compared.quantities) {
    for (std::size_t run = 0; run < compared.runs.size(); ++run) rows.add(quantity, run);
  }
  const double base = compared.runs.front().energy;
  for (std::size_t run = 0; run < compared.runs.size(); ++run) {
    const double energy = compared.runs[run].energy;
    rows.add("energy", "J", "total", run, energy, base == 0 ? NAN : energy / base);
  }
  return rows.text();
}

}  // namespace balance
