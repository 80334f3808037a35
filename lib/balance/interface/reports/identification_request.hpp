#pragma once
/// What `balance identify` was asked for, from files of records to the identified mechanism.

#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/record_reader.hpp"
#include "balance/interface/reports/report_data.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace balance::reports {

struct IdentificationRequest {
  std::vector<std::string> records = {};     ///< files; at least one, all with the same columns
  std::vector<std::string> validation = {};  ///< files that are only predicted
  specification::RecordOptions reading = {};
  double cutoff = 0;                                             ///< of the low-pass filter [Hz]; 0: from the motion
  double rest_rate = 0.02;                                       ///< below it a joint is at rest [rad/s or m/s]
  std::vector<std::pair<std::string, double>> gains = {};        ///< of measured currents, by actuator [N m/A or N/A]
  bool finds_gains = false;                                      ///< although the spec has them
  std::vector<std::pair<std::string, std::string>> loaded = {};  ///< payload and the file in which it is carried
  std::vector<std::string> payloads = {};                        ///< to be found
  std::string passive_friction = "viscous";                      ///< or "none", "dry"
  double prior_weight = 1;                                       ///< of the spec's bodies
  double correlation_time = 1;                                   ///< within which residuals are correlated [s]
  double hold_out = 0;  ///< of every two spans of this duration the second is predicted [s]; 0: all are fitted
};

/// A request that cannot be meant: `--gain: no actuator 'A9'; expected 'A1' or 'A2'`.
class IdentificationRequestError : public std::invalid_argument {
 public:
  IdentificationRequestError(const std::string& its_option, const std::string& its_reason)
      : std::invalid_argument("--" + its_option + ": " + its_reason), option(its_option), reason(its_reason) {}

  std::string option;  ///< without dashes: "find-payload"
  std::string reason;
};

struct RequestedIdentification {
  RequestFailure refusal;                 ///< status "record" or "not-identifiable"
  identification::Identification answer;  ///< valid unless refused
};

/// Reads the records and identifies the mechanism from them.
/// @throws IdentificationRequestError; SystemError for files that are no records of this mechanism; SpecError for a mechanism
/// whose equation of motion is not linear in the unknowns
RequestedIdentification identify_from_records(const Study& study, const IdentificationRequest& request);

/// The files that are read, in the words of messages.
std::vector<files::InputFile> list_record_files(const IdentificationRequest& request);

files::Provenance make_identification_provenance(const Study& study, const IdentificationRequest& request);

/// Writes the spec with the numbers that were found, complete or not at all.
/// @returns notes of format_identified_spec @throws SpecError as it; SystemError
std::vector<std::string> write_identified_spec(const std::string& path, const Study& study,
                                               const identification::Identification& found,
                                               files::OverwritePolicy existing);

}  // namespace balance::reports
