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
    text_ += fmt::format("{},{},{},{},{},{}\n", csv_field(quantity), csv_field(unit), figure,
                         csv_field(compared_.runs[run].name), number(value), number(ratio));
  }

  void add(const ComparedQuantity& q, std::size_t run) {
    const auto& metric = q.metrics[run];
    for (const auto& [figure, name] :
         {std::pair{Figure::peak, "peak"}, {Figure::rms, "rms"}, {Figure::mean, "mean"}, {Figure::range, "range"}}) {
      add(q.quantity, q.unit, name, run, metric ? figure_of(*metric, figure) : NAN, ratio_to_base(q, run, figure));
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

std::string verdict_line(const Verdict& verdict) {
  return visible(fmt::format("{:<6} {}{}{}{}: {}", verdict.holds ? "ok" : "FAILED", verdict.requirement,
                             verdict.run.empty() ? "" : " [", verdict.run, verdict.run.empty() ? "" : "]",
                             in_words(verdict)));
}

std::string verdicts_text(const std::vector<Verdict>& verdicts) {
  std::string text;
  for (const Verdict& verdict : verdicts) text += verdict_line(verdict) + "\n";
  return text;
}

std::string comparison_text(const ComparedRuns& compared, const std::vector<Verdict>& verdicts, ShownQuantities shown) {
  std::string text;
  for (const TitledTable& one : list_tables(compared, shown)) {
    text += one.title + "\n\n" + format_table(one.table) + "\n";
  }
  for (const std::string& note : compared.notes) text += "note: " + visible(note) + "\n";
  if (!compared.notes.empty() && !verdicts.empty()) text += "\n";
  if (!verdicts.empty()) text += verdicts_text(verdicts) + "\n" + count_text(verdicts) + "\n";
  if (text.ends_with("\n\n")) text.pop_back();
  return text;
}

std::string comparison_markdown(const ComparedRuns& compared, const std::vector<Verdict>& verdicts,
                                ShownQuantities shown) {
  std::string text = "# Comparison with " + markdown_text(compared.runs.front().name) + "\n";
  if (!verdicts.empty()) {
    constexpr std::size_t requirement = 1;
    text += "\n## Requirements\n\n" + count_text(verdicts) + ".\n\n" +
            markdown_table(verdict_table(verdicts), {requirement});
  }
  for (const TitledTable& one : list_tables(compared, shown)) {
    std::string title = one.title;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    text += "\n## " + markdown_text(title) + "\n\n" + markdown_table(one.table);
  }
  for (const std::string& note : compared.notes) text += "\nNote: " + markdown_text(note) + "\n";
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
