#pragma once
/// The page that a designer hands to a colleague: one HTML file with everything in it. docs/report.md describes its data.

#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace balance {

/// One trajectory: of a spec without a design only `before`. A run that could not be made has an outcome that says so.
struct ReportedTrajectory {
  std::string name, law, drive;  ///< as in the spec
  std::optional<RunResult> before, after;
  /// Of the runs' torques, shaking forces and shaking moments: standard deviations where the numbers in `tolerances` are off.
  std::optional<RunResult> deviation_before = {}, deviation_after = {};
};

struct HtmlReport {
  std::string version;    ///< of the program
  std::string command;    ///< what makes the same page again
  std::string spec_file;  ///< its name without folders
  std::string spec_text;
  Mechanism before;                ///< as the spec's runs see it
  std::optional<Mechanism> after;  ///< designed
  std::string check;               ///< what `balance check --json` prints; empty: not checked
  std::string conditions;          ///< what `balance conditions --json` prints; empty: no goal
  std::string design;              ///< what `balance design --json` prints; empty: no design
  std::string front;  ///< what it prints of a trade-off, of which `design` is the middle; empty: none was asked for
  std::vector<std::string> goal_descriptions;  ///< the goals in words
  std::string controller, controller_type;     ///< of all runs; empty: they follow their trajectories exactly
  std::vector<ReportedTrajectory> trajectories;
  std::vector<std::string> notes;  ///< warnings and notes for the reader
};

/// The data of the page, one JSON object; docs/report.md.
/// @throws std::invalid_argument if a run does not belong to its mechanism
std::string format_report_data(const HtmlReport& page);

/// Whether this program was built with the page's scripts. Without them `format_html_report` throws.
bool has_report_scripts();

/// The complete page, UTF-8. @throws SystemError if the program was built without the page's scripts
std::string format_html_report(const HtmlReport& page);

/// Text as the content of an HTML element or attribute.
std::string escape_html(const std::string& text);

/// JSON that may stand inside <script>: no `<` is left in it.
std::string escape_script_json(const std::string& json);

/// The page's scripts and styles, bundled when the program was built.
struct HtmlReportAssets {
  std::string_view planar_script, spatial_script, style;  ///< UTF-8; all empty: built without them
};

HtmlReportAssets page_assets();

}  // namespace balance
