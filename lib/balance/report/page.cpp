#include "balance/report/page.hpp"

#include "balance/base/error.hpp"
#include "balance/report/page_assets.hpp"
#include "balance/report/page_mechanism.hpp"
#include "balance/report/page_run.hpp"

namespace balance {
namespace {

Json parsed(const std::string& text) { return text.empty() ? Json(nullptr) : Json::parse(text); }

Json optional_run(const Mechanism& mechanism, const std::optional<Result>& result) {
  return result ? run_page_json(mechanism, *result) : Json(nullptr);
}

Json trajectories_json(const Page& page) {
  Json list = Json::array();
  for (const PageTrajectory& t : page.trajectories)
    list.push_back({{"name", t.name},
                    {"law", t.law},
                    {"drive", t.drive},
                    {"before", optional_run(page.before, t.before)},
                    {"after", optional_run(page.after.value_or(page.before), t.after)}});
  return list;
}

/// The script must not be ended by what it contains.
std::string script(std::string_view attributes, std::string_view content) {
  std::string text = "<script";
  text += attributes;
  text += ">";
  text += content;
  return text + "</script>\n";
}

}  // namespace

std::string page_json(const Page& page) {
  Json json = {{"format", 1},
               {"version", page.version},
               {"title", page.before.name},
               {"command", page.command},
               {"spec_file", page.spec_file},
               {"spec", page.spec_text},
               {"space", page.before.space == SpaceKind::planar ? "planar" : "spatial"},
               {"gravity", vector_json(page.before.gravity, 3)},
               {"mass", total_mass(page.before)}};
  json["check"] = page.check.empty() ? Json::object() : parsed(page.check);
  json["conditions"] = parsed(page.conditions);
  json["design"] = parsed(page.design);
  json["meaning"] = page.meaning;
  json["mechanism"] = {{"before", mechanism_json(page.before)},
                       {"after", page.after ? mechanism_json(*page.after) : Json(nullptr)}};
  json["trajectories"] = trajectories_json(page);
  json["notes"] = page.notes;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string html_escaped(const std::string& text) {
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

std::string script_safe(const std::string& json) {
  std::string safe;
  safe.reserve(json.size());
  // In JSON `<` occurs inside strings only, where it may be written as an escape.
  for (const char c : json) c == '<' ? safe += "\\u003c" : safe += c;
  return safe;
}

bool has_page_scripts() { return !page_assets().style.empty(); }

std::string page_html(const Page& page) {
  const PageAssets assets = page_assets();
  if (assets.style.empty())
    throw SystemError(
        "this program was built without the scripts of the page: install node 18 or newer and npm "
        "(scripts/setup does), then configure and build again");
  const bool planar = page.before.space == SpaceKind::planar;
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"balance " +
      html_escaped(page.version) + "\">\n<link rel=\"icon\" href=\"data:,\">\n<title>" +
      html_escaped(page.before.name.empty() ? page.spec_file : page.before.name) + "</title>\n<style>";
  html += assets.style;
  html += "</style>\n</head>\n<body>\n<noscript>This page needs JavaScript, which it brings with it.</noscript>\n";
  html += script(" type=\"application/json\" id=\"balance-data\"", script_safe(page_json(page)));
  html += script("", planar ? assets.planar_script : assets.spatial_script);
  return html + "</body>\n</html>\n";
}

}  // namespace balance
