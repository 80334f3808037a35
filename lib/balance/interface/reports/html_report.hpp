#pragma once
/// Self-contained HTML page with the whole report. docs/report.md describes its data.

#include "balance/interface/specification/display_units.hpp"
#include "balance/mechanics/results/result.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace balance::reports {

/// One trajectory; only `before` if the spec has no design. The outcome of a failed run has the reason.
struct ReportedTrajectory {
  std::string name, law, drive;  ///< as in the spec
  std::optional<RunResult> before, after;
  /// Standard deviations of the runs' torques, shaking forces and shaking moments due to the `tolerances`.
  std::optional<RunResult> deviation_before = {}, deviation_after = {};
  std::string mode = {};  ///< what the run shows if it is a vibration mode and no motion of the spec; else empty
};

struct ReportedAnswers;  // html_report_data.hpp

struct HtmlReport {
  std::string version;    ///< of the program
  std::string command;    ///< reproduces the page
  std::string spec_file;  ///< without folders
  std::string spec_text;
  Mechanism before;                            ///< the mechanism of the spec's runs
  std::optional<Mechanism> after;              ///< the designed mechanism
  std::shared_ptr<ReportedAnswers> answers;    ///< null: none
  std::vector<std::string> goal_descriptions;  ///< the goals in words
  std::string controller, controller_type;     ///< of all runs; empty: they follow their trajectories exactly
  std::vector<ReportedTrajectory> trajectories;
  specification::SpecUnits units;           ///< in which the page shows its numbers; its data are SI
  specification::NumberUnits number_units;  ///< of free numbers and, by their names in `design: for`, of loads
  std::vector<std::string> notes;           ///< warnings and notes for the reader
};

/// Data of the page as one JSON object; see docs/report.md.
/// @throws std::invalid_argument if a run does not belong to its mechanism
std::string format_report_data(const HtmlReport& page);

/// Whether this program was built with the page's scripts. Without them format_html_report() throws.
bool has_report_scripts();

/// The complete page, UTF-8. @throws SystemError if the program was built without the page's scripts
std::string format_html_report(const HtmlReport& page);

/// Escapes text for the content of an HTML element or attribute.
std::string escape_html(const std::string& text);

/// Escapes JSON for use inside <script>: no `<` is left in it.
std::string escape_script_json(const std::string& json);

/// The page's scripts and styles, bundled at build time.
struct HtmlReportAssets {
  std::string_view planar_script, spatial_script, style;  ///< UTF-8; all empty: built without them
};

HtmlReportAssets page_assets();

}  // namespace balance::reports
