#pragma once
/// The summary of a batch: its cases, their comparison with the baseline, and whether the requirements hold. As text,
/// Markdown, CSV, JSON and JUnit XML; the same records give the same bytes.

#include "balance/interface/batch/case_record.hpp"
#include "balance/interface/batch/suite.hpp"
#include "balance/interface/comparison/requirement_verdict.hpp"

#include <array>
#include <string>
#include <vector>

namespace balance::batch {

/// A requirement judged for one case, or once if it names all its runs.
struct RequirementOutcome {
  enum class Status {
    holds,
    violated,
    not_judged,  ///< a case that it refers to has no result
    invalid,     ///< it refers to a quantity that no case has
  };
  Status status = Status::holds;
  std::string text;           ///< of the requirement; of a published number, what it is
  std::string run;            ///< case that it was judged for; empty if it names all its runs
  std::string message;        ///< one line: the margin by which it holds or misses, or why it was not judged
  bool is_published = false;  ///< a row of `published`
};

/// Where a case is from, and the numbers that its source has printed.
struct PublishedCase {
  CaseSource source;
  std::vector<PublishedOutcome> rows;

  bool is_empty() const { return source.source.empty() && source.waits.empty() && rows.empty(); }
};

struct BatchSummary {
  std::string name;                ///< of the suite
  std::string baseline;            ///< name of a case; empty: none
  std::vector<std::string> specs;  ///< per case, as the suite names it
  std::vector<CaseRecord> cases;
  std::vector<RequirementOutcome> requirements;
  std::vector<PublishedCase> published;  ///< one per case

  /// The baseline's record; null if there is none or it has no result.
  const CaseRecord* baseline_record() const;
  /// 0: all cases have results and the requirements hold; 1: a requirement is missed or a design is only a compromise;
  /// otherwise the largest of 3, 4 and 5 among the cases, where an invalid requirement counts as 3.
  int exit_code() const;
};

/// @param records one per case of the suite, in its order
BatchSummary summarise_batch(const Suite& suite, std::vector<CaseRecord> records);

/// A table of the cases, the verdicts of the requirements, and what went wrong; for a terminal.
std::string format_batch_text(const BatchSummary& summary);
/// A line "FAILED …" for every case that is not done and every requirement that is missed or invalid.
std::string format_failures(const BatchSummary& summary);
std::string summary_markdown(const BatchSummary& summary);
/// One line per case and quantity.
std::string summary_csv(const BatchSummary& summary);
std::string summary_json(const BatchSummary& summary);
std::string summary_junit(const BatchSummary& summary);

/// Names of the files written by write_summary.
inline constexpr std::array<const char*, 4> summary_file_names{"summary.json", "summary.csv", "summary.md",
                                                               "junit.xml"};

/// Writes these files, each completely or not at all. @return their names with the folder
/// @throws SystemError
std::vector<std::string> write_summary(const std::string& folder, const BatchSummary& summary);

}  // namespace balance::batch
