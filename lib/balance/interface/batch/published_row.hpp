#pragma once
/// Numbers that a source has printed, with the figures that reproduce them.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/spec_units.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace balance::batch {

/// A requirement and its location in the suite, for messages: "suite.yaml:9:5: require[0]".
struct SuiteRequirement {
  comparison::Requirement requirement;
  SourceLocation location;
};

/// How the printed number and the exact one are related.
enum class PublishedVerdict {
  reproduced,           ///< they agree within half of the last printed digit
  first_approximation,  ///< the source neglects higher orders
  drawn,                ///< the source's solution is graphical
  rounded,              ///< the source calculates with rounded numbers
  misprint,
  source_wrong,
  improved,    ///< ours is better than the printed design, with proof
  best_known,  ///< the same without proof
};
inline constexpr std::array published_verdict_names{"reproduced", "first-approximation", "drawn",    "rounded",
                                                    "misprint",   "source-wrong",        "improved", "best-known"};
const char* name_of(PublishedVerdict verdict);

struct PublishedRow {
  std::string what;  ///< "piston speed"
  std::string unit;  ///< of the numbers below; empty: none
  specification::UnitProduct unit_value;
  double printed = 0;    ///< by the source
  double exact = 0;      ///< what the figure must be; the printed number unless the suite gives another
  double tolerance = 0;  ///< of the figure; default: half a unit of the last digit of `exact`
  PublishedVerdict verdict = PublishedVerdict::reproduced;
  std::string note;
  comparison::FigureExpression figure;    ///< [SI]
  std::optional<SuiteRequirement> proof;  ///< of an improvement
  SourceLocation figure_location, unit_location;
};

/// A printed number without a figure yet.
struct WaitingRow {
  std::string what, unit, printed, reason;
};

/// Where a case is from.
struct CaseSource {
  std::string source, page;  ///< empty: not given
  std::vector<WaitingRow> waits;
};

/// A row with its value.
struct PublishedOutcome {
  PublishedRow row;
  double ours = 0;  ///< in the row's unit; NaN: none
  bool holds = false;
};

/// "holds: 6.90536 m/s, expected 6.90536 ± 5e-06 m/s", "6.91 m/s, expected …".
std::string describe_outcome(const PublishedOutcome& outcome);

/// Reads one row of `published`.
/// @param has_proof whether the case has a requirement on its verdict
PublishedRow read_published_row(const specification::SpecCursor& at, const comparison::RunNames& names, bool has_proof,
                                const std::string& file);

/// Reads arithmetic with at least one figure. @param expectation "arithmetic of figures such as …"
comparison::FigureExpression read_figure(const specification::SpecCursor& at, const comparison::RunNames& names,
                                         const std::string& expectation);

/// Reads one requirement. @param expectation "a requirement such as …"
comparison::Requirement read_requirement(const specification::SpecCursor& at, const comparison::RunNames& names,
                                         const std::string& expectation);

/// "suite.yaml:4:7: cases.a.spec"
SourceLocation locate(const specification::SpecCursor& at, const std::string& file);

/// Reads one entry of `waits`.
WaitingRow read_waiting_row(const specification::SpecCursor& at);

/// Half a unit of the last digit of a number as written: 5e-6 of 6.90536, 50 of 1.2e3.
double half_last_digit(const std::string& text);

}  // namespace balance::batch
