#pragma once
/// The record of a computed case: all that summaries need, and what identifies the case as finished.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/mechanics/results/result.hpp"

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::batch {

/// A file in the output folder with its SHA-256.
struct RecordedFile {
  std::string name, sha256;
};

/// Outcome of designing first.
struct RecordedDesign {
  std::string status;  ///< "balanced", "compromise", "impossible", "not-found"; "not-asked" without a goal
  std::string reason;
  double mass_before = 0, mass_after = 0;  ///< of all moving parts [kg]
  double added_mass = 0;                   ///< of counterweights and discs [kg]
};

/// Why a case has no result although no mistake in it is known.
struct RecordedFailure {
  std::string cause;  ///< "crashed", "timeout", "memory"
  double limit = 0;   ///< limit that it exceeded: seconds or bytes; 0 for a crash
};

struct CaseRecord {
  std::string name;
  std::string cache_key;  ///< see PlannedCase::key
  /// "done", "compromise", "spec", "mechanism", "failed" (its process crashed or exceeded a limit), "system", "missing"
  std::string status;
  std::string message;  ///< one sentence on what went wrong
  std::string title;    ///< the mechanism's name
  std::string trajectory;
  long samples = 0;
  double seconds = 0;                      ///< wall-clock time
  std::optional<RecordedFailure> failure;  ///< if the status is "failed"
  std::optional<RecordedDesign> design;
  std::vector<Metric> metrics;
  double energy = std::numeric_limits<double>::quiet_NaN();  ///< [J]
  std::vector<comparison::EvaluatedFigure> figures;          ///< that were asked for and no metric answers
  std::vector<std::pair<std::string, double>> solved;        ///< parameters that were solved for
  std::vector<std::string> warnings, notes;
  std::vector<RecordedFile> files;

  bool has_result() const { return status == "done" || status == "compromise"; }
  /// Whether there is a file with the samples.
  bool has_samples() const;
  /// The figures for requirements.
  comparison::MetricTable metric_table() const { return {name, metrics, energy, figures}; }
  /// Whether it answers every one of these figures, if only by a reason.
  bool answers(const std::vector<comparison::FigureReference>& asked) const;
  /// The program's exit code for this case alone: 0, 1, 3, 4 or 5.
  int exit_code() const;
};

/// The record for a case whose requirements ask for the verdict of its design: then a design that is impossible or only
/// a compromise is a result, and so is one that was not found if nothing else was to be computed.
/// @param is_design_only the case is `run: design`
CaseRecord accept_verdict(CaseRecord record, bool is_design_only);

/// JSON whose last entry is the SHA-256 of everything before it, which reveals damaged and edited records.
std::string encode_record(const CaseRecord& record);

/// std::nullopt if the text is not, byte for byte, what encode_record() writes.
std::optional<CaseRecord> decode_record(const std::string& text);

/// File names in the output folder.
std::string record_file_name(const std::string& case_name);
std::string result_file_name(const std::string& case_name);
std::string balanced_spec_file_name(const std::string& case_name);

/// Marks the temporary files of a batch.
inline constexpr const char* temporary_tag = "batch-";

/// Stores the record of a case, which must not be the record of a system failure.
/// @param text encode_record(record)
/// @throws SystemError
void store_record(const std::string& folder, const CaseRecord& record, const std::string& text);

/// The record of a case; std::nullopt unless it was computed from the same inputs and it and all its files are as they
/// were written. The target of a symbolic link does not count as one of its files.
std::optional<CaseRecord> load_valid_record(const std::string& folder, const std::string& case_name,
                                            const std::string& key);

}  // namespace balance::batch
