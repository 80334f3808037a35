#include "balance/interface/reports/html_report.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/html_report_data.hpp"

namespace balance::reports {
namespace {

/// More samples than pixels slow the page down without improving its pictures.
constexpr Eigen::Index max_displayed_samples = 4000;

bool has_samples(const std::optional<RunResult>& run) {
  return run && run->outcome.status == MotionStatus::done && run->time.size() > 0;
}

Json optional_run(const Mechanism& mechanism, const std::optional<RunResult>& run,
                  const std::vector<Eigen::Index>& rows, const std::optional<RunResult>& deviation) {
  return run ? run_data_json(mechanism, *run, rows, deviation ? &*deviation : nullptr) : Json(nullptr);
}

/// Both runs of a trajectory at the same samples: one chart shows both.
Json trajectory_json(const HtmlReport& page, const ReportedTrajectory& t) {
  std::vector<const RunResult*> runs;
  for (const auto* run : {&t.before, &t.after})
    if (has_samples(*run)) runs.push_back(&**run);
  const bool have_same_samples = runs.size() == 2 && runs[0]->time.size() == runs[1]->time.size();
  const auto rows_of = [&](const std::optional<RunResult>& run) {
    if (!has_samples(run)) return std::vector<Eigen::Index>();
    return select_display_rows(have_same_samples ? runs : std::vector<const RunResult*>{&*run}, max_displayed_samples);
  };
  return {{"name", t.name},
          {"law", t.law},
          {"drive", t.drive},
          {"mode", files::text_or_null(t.mode)},
          {"before", optional_run(page.before, t.before, rows_of(t.before), t.deviation_before)},
          {"after", optional_run(page.after.value_or(page.before), t.after, rows_of(t.after), t.deviation_after)}};
}

/// What takes the place of each factor of an SI unit. Times stay in seconds, in which the page's clock runs.
Json units_json(specification::SpecUnits units) {
  units.time = 1, units.time_name = "s";
  Json json = Json::object();
  for (const char* factor : {"m", "kg", "rad", "N", "J", "W"}) {
    const files::DisplayUnit unit = files::find_display_unit(factor, units);
    if (unit.name != factor) json[factor] = {{"name", unit.name}, {"value", unit.factor}};
  }
  return json;
}

/// Name of an inline script or style in a content security policy: the SHA-256 of its bytes in base64.
std::string hash_source(std::string_view content) {
  const std::string hex_digest = files::sha256(content);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex_digest.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex_digest.substr(i, 2), nullptr, 16));
  return "'sha256-" + base64(bytes) + "'";
}

/// Allows only the page's own script and style to run and nothing to be fetched, so that the page is safe to pass on.
std::string content_policy(std::string_view code, std::string_view style) {
  return "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src " + hash_source(code) +
         "; style-src " + hash_source(style) + "; img-src data: blob:; base-uri 'none'; form-action 'none'\">\n";
}

/// The content must not end the script.
std::string script(std::string_view attributes, std::string_view content) {
  std::string text = "<script";
  text += attributes;
  text += ">";
  text += content;
  return text + "</script>\n";
}

}  // namespace

std::string format_report_data(const HtmlReport& page) {
  Json json = {{"format", 1},
               {"version", page.version},
               {"title", page.before.name},
               {"command", page.command},
               {"spec_file", page.spec_file},
               {"spec", page.spec_text},
               {"space", page.before.space == SpaceKind::planar ? "planar" : "spatial"},
               {"gravity", files::vector_json(page.before.gravity, 3)},
               {"mass", total_mass(page.before)}};
  const ReportedAnswers answers = page.answers ? *page.answers : ReportedAnswers{};
  json["check"] = answers.check;
  json["conditions"] = answers.conditions;
  json["design"] = answers.design;
  json["front"] = answers.front;
  json["vibrations"] = answers.vibrations;
  json["meaning"] = page.goal_descriptions;
  json["mechanism"] = {{"before", mechanism_json(page.before)},
                       {"after", page.after ? mechanism_json(*page.after) : Json(nullptr)}};
  json["controller"] = nullptr;
  if (!page.controller.empty()) json["controller"] = {{"name", page.controller}, {"type", page.controller_type}};
  json["trajectories"] =
      files::list_json(page.trajectories, [&](const ReportedTrajectory& t) { return trajectory_json(page, t); });
  json["units"] = units_json(page.units);
  json["number_units"] = page.number_units;
  json["notes"] = page.notes;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string escape_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      case '\'': escaped += "&#39;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

std::string escape_script_json(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  // in JSON `<` occurs inside strings only, where it may be escaped
  for (const char c : json) c == '<' ? safe += "\\u003c" : safe += c;
  return safe;
}

bool has_report_scripts() { return !page_assets().style.empty(); }

std::string format_html_report(const HtmlReport& page) {
  const HtmlReportAssets assets = page_assets();
  if (assets.style.empty())
    throw SystemError(
        "this program was built without the scripts of the page: install node 18 or newer and npm "
        "(scripts/setup does), then configure and build again");
  const bool planar = page.before.space == SpaceKind::planar;
  const std::string_view code = planar ? assets.planar_script : assets.spatial_script;
  std::string html = "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html += content_policy(code, assets.style);
  html +=
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"balance " +
      escape_html(page.version) + "\">\n<link rel=\"icon\" href=\"data:,\">\n<title>" +
      escape_html(page.before.name.empty() ? page.spec_file : page.before.name) + "</title>\n<style>";
  html += assets.style;
  html += "</style>\n</head>\n<body>\n<noscript>This page needs JavaScript; its scripts are included.</noscript>\n";
  html += script(" type=\"application/json\" id=\"balance-data\"", escape_script_json(format_report_data(page)));
  html += script("", code);
  return html + "</body>\n</html>\n";
}

}  // namespace balance::reports

#ifdef BALANCE_PAGE_BUNDLE
// .incbin is much faster than compiling arrays of numbers
#define BALANCE_EMBED(name, file)                                                                                    \
  __asm__(".pushsection .rodata\n.global " #name "_begin\n" #name "_begin:\n.incbin \"" BALANCE_PAGE_BUNDLE "/" file \
          "\"\n.global " #name "_end\n" #name "_end:\n.byte 0\n.popsection\n");                                      \
  extern "C" const char name##_begin[];                                                                              \
  extern "C" const char name##_end[];

BALANCE_EMBED(balance_page_planar, "planar.js")
BALANCE_EMBED(balance_page_spatial, "spatial.js")
BALANCE_EMBED(balance_page_style, "page.css")
#endif

namespace balance::reports {

HtmlReportAssets page_assets() {
#ifdef BALANCE_PAGE_BUNDLE
  return {{balance_page_planar_begin, balance_page_planar_end},
          {balance_page_spatial_begin, balance_page_spatial_end},
          {balance_page_style_begin, balance_page_style_end}};
#else
  return {};
#endif
}

}  // namespace balance::reports
