#pragma once
/// What is remembered of a case that has been computed: all that summaries need, and by what to recognise that it is finished.

#include "balance/mechanics/results/result.hpp"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// A file in the output folder with its SHA-256.
struct RecordedFile {
  std::string name, sha256;
};

/// What designing first came to.
struct RecordedDesign {
  std::string status;  ///< "balanced", "compromise", "impossible", "not-found"; "not-asked" without a goal
  std::string reason;
  double mass_before = 0, mass_after = 0;  ///< of everything that moves [kg]
  double added_mass = 0;                   ///< of counterweights and discs [kg]
};

/// Why a case has no result although nothing is known to be wrong with it.
struct RecordedFailure {
  std::string cause;  ///< "crashed", "timeout", "memory"
  double limit = 0;   ///< that it did not keep to: seconds or bytes; 0 for a crash
};

struct CaseRecord {
  std::string name;
  std::string cache_key;  ///< as PlannedCase::key
  /// "done", "compromise", "spec", "mechanism", "failed" (its process crashed or went beyond a limit), "system", "missing"
  std::string status;
  std::string message;  ///< one sentence on what is not as it should be
  std::string title;    ///< the mechanism's name
  std::string trajectory;
  long samples = 0;
  double seconds = 0;                      ///< that it took by the clock on the wall
  std::optional<RecordedFailure> failure;  ///< where the status is "failed"
  std::optional<RecordedDesign> design;
  std::vector<Metric> metrics;
  double energy = std::numeric_limits<double>::quiet_NaN();  ///< [J]
  std::vector<std::string> warnings, notes;
  std::vector<RecordedFile> files;

  /// Whether there is a result.
  bool has_result() const { return status == "done" || status == "compromise"; }
  /// Whether there is a file with the samples.
  bool has_samples() const;
  /// The program's exit code for this case alone: 0, 1, 3, 4 or 5.
  int exit_code() const;
};

/// JSON whose last entry, the SHA-256 of all that stands before, tells what was damaged or edited from what was written.
std::string encode_record(const CaseRecord& record);

/// Nothing if the text is not, byte for byte, what encode makes of a record.
std::optional<CaseRecord> decode_record(const std::string& text);

/// Names in the output folder.
std::string record_file_name(const std::string& case_name);
std::string result_file_name(const std::string& case_name);
std::string balanced_spec_file_name(const std::string& case_name);

/// Marks the temporary files of a batch.
inline constexpr const char* temporary_tag = "batch-";

/// Remembers a case that a system's failure did not spoil.
/// @param text encode(record)
/// @throws SystemError
void store_record(const std::string& folder, const CaseRecord& record, const std::string& text);

/// The record of a case, if it was computed from the same, and it and all its files are as they were written. What a symbolic link
/// leads to is none of its files.
std::optional<CaseRecord> load_valid_record(const std::string& folder, const std::string& case_name,
                                            const std::string& key);

}  // namespace balance
