#include "balance/interface/reports/html_report.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/reports/html_report_data.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <string>

using namespace balance;
using namespace balance::reports;

namespace {

/// The inverse of base64, written on its own.
std::string decoded(const std::string& text) {
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                                             : 63;
    bits = bits << 6 | static_cast<unsigned>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255U);
  }
  return bytes;
}

template <class Number>
std::vector<Number> numbers(const std::string& text) {
  const std::string bytes = decoded(text);
  std::vector<Number> result(bytes.size() / sizeof(Number));
  std::memcpy(result.data(), bytes.data(), bytes.size());
  return result;
}

HtmlReport sample_page(const std::string& config, long samples) {
  const Study study = read_spec_file(std::string(BALANCE_CONFIGS) + "/" + config);
  HtmlReport page;
  page.version = "1.2.3";
  page.spec_text = study.spec_text;
  page.before = study.mechanism;
  Trajectory trajectory = study.trajectories.front();
  trajectory.samples = samples;
  page.trajectories.push_back({trajectory.name, "cycloidal", "tool", simulate(study.mechanism, trajectory), {}});
  return page;
}

}  // namespace

TEST_CASE("base64 agrees with the examples of RFC 4648") {
  const std::vector<std::pair<std::string, std::string>> examples = {{"", ""},
                                                                     {"f", "Zg=="},
                                                                     {"fo", "Zm8="},
                                                                     {"foo", "Zm9v"},
                                                                     {"foob", "Zm9vYg=="},
                                                                     {"fooba", "Zm9vYmE="},
                                                                     {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : examples) CHECK(base64(bytes) == text);
}

TEST_CASE("numbers come back from their base64") {
  const VectorX exact = (VectorX(4) << 0.1, -1e300, 0, 3).finished();
  CHECK(numbers<double>(base64_doubles(exact)) == std::vector<double>{0.1, -1e300, 0, 3});
  Samples samples(2, 3);
  samples << 1, 2, 3, 4, 5, 6;
  CHECK(numbers<float>(base64_floats(samples)) == std::vector<float>{1, 2, 3, 4, 5, 6});
  CHECK(numbers<float>(base64_float_columns(samples)) == std::vector<float>{1, 4, 2, 5, 3, 6});
}

TEST_CASE("nothing in the data can end its script, and the data stay the same") {
  HtmlReport page = sample_page("rr.yaml", 3);
  page.spec_text = "# </script><script>alert(1)</script><!-- \xff \"quoted\"";
  const std::string safe = escape_script_json(format_report_data(page));
  CHECK(safe.find('<') == std::string::npos);
  const auto json = nlohmann::json::parse(safe);
  const std::string text = json["spec"];
  CHECK(text.starts_with("# </script><script>alert(1)</script><!-- "));
}

TEST_CASE("names become text in HTML") {
  CHECK(escape_html("a<b> & \"c\" 'd'") == "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
}

TEST_CASE("every quantity of the page has a value for every sample and column") {
  for (const std::string config : {"3rrr.yaml", "delta.yaml", "scotch-yoke.yaml", "stewart.yaml"}) {
    CAPTURE(config);
    const HtmlReport page = sample_page(config, 11);
    const auto json = nlohmann::json::parse(format_report_data(page));
    const auto& run = json["trajectories"][0]["before"];
    CHECK(numbers<double>(run["time"]["f64"]).size() == 11);
    const bool planar = json["space"] == "planar";
    const std::size_t bodies = json["mechanism"]["before"]["bodies"].size();
    CHECK(numbers<float>(run["poses"]["f32"]).size() == 11 * bodies * (planar ? 3 : 7));
    CHECK(run["series"].size() > 10);
    for (const auto& series : run["series"]) {
      CAPTURE(std::string(series["quantity"]));
      const std::size_t columns = series["columns"].size();
      CHECK(numbers<float>(series["values"]["f32"]).size() == 11 * columns);
      CHECK((series["units"].size() == 1 || series["units"].size() == columns));
    }
  }
}

TEST_CASE("a page of very many samples shows few of them, every extreme among them (C10)") {
  HtmlReport page = sample_page("rr.yaml", 20001);
  RunResult& run = *page.trajectories[0].before;
  run.torque(12345, 1) = 1e4;  // a spike between two evenly spread samples
  for (const Eigen::Index k : {7001, 7003, 7005}) run.power(k, 0) += 3e3;
  const auto json = nlohmann::json::parse(format_report_data(page));
  const auto& shown = json["trajectories"][0]["before"];
  CHECK(shown["samples"] == 20001);
  const std::vector<double> time = numbers<double>(shown["time"]["f64"]);
  CHECK(time.size() <= 4000);
  CHECK(time.size() > 2000);
  CHECK(std::is_sorted(time.begin(), time.end()));
  CHECK(time.front() == run.time[0]);
  CHECK(time.back() == run.time[20000]);
  CHECK(std::find(time.begin(), time.end(), run.time[12345]) != time.end());
  for (const Eigen::Index k : {7001, 7003, 7005}) CHECK(std::find(time.begin(), time.end(), run.time[k]) != time.end());
  for (const Quantity& quantity : list_sampled_quantities(run))
    for (const auto& series : shown["series"]) {
      if (series["quantity"] != quantity.name || quantity.columns == results::ColumnKind::joint_axis) continue;
      CAPTURE(quantity.name);
      const std::vector<float> values = numbers<float>(series["values"]["f32"]);
      for (Eigen::Index c = 0; c < quantity.samples->cols(); ++c) {
        const auto begin = values.begin() + c * static_cast<std::ptrdiff_t>(time.size());
        const auto [low, high] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(time.size()));
        const double round_off = column_round_off(run, quantity.member, c);
        CHECK(*low == static_cast<float>(results::suppress_round_off(round_off, quantity.samples->col(c).minCoeff())));
        CHECK(*high == static_cast<float>(results::suppress_round_off(round_off, quantity.samples->col(c).maxCoeff())));
      }
    }
}

TEST_CASE("before and after are shown at the same of very many samples (C10)") {
  HtmlReport page = sample_page("rr.yaml", 6001);
  page.trajectories[0].after = page.trajectories[0].before;
  page.trajectories[0].after->torque(3333, 0) = 1e4;
  const auto json = nlohmann::json::parse(format_report_data(page));
  const auto& trajectory = json["trajectories"][0];
  CHECK(trajectory["before"]["time"] == trajectory["after"]["time"]);
  CHECK(numbers<double>(trajectory["before"]["time"]["f64"]).size() < 4001);
}

TEST_CASE("a page shows round-off as zero (D2)") {
  HtmlReport page = sample_page("planar-rrr.yaml", 101);
  page.trajectories[0].before->shaking_force.array() += 1e-15;
  const auto json = nlohmann::json::parse(format_report_data(page));
  for (const auto& series : json["trajectories"][0]["before"]["series"])
    if (series["quantity"] == "shaking_force")
      for (const float value : numbers<float>(series["values"]["f32"])) CHECK(value == 0);
}

TEST_CASE("a page's policy allows its own script and style by their hashes, and nothing else (C12)") {
  if (!has_report_scripts()) return;
  for (const char* config : {"rr.yaml", "delta.yaml"}) {
    CAPTURE(config);
    const std::string html = format_html_report(sample_page(config, 3));
    const auto between = [&](const std::string& from, const std::string& to, std::size_t start) {
      const std::size_t begin = html.find(from, start) + from.size();
      return html.substr(begin, html.find(to, begin) - begin);
    };
    const auto hash = [](const std::string& content) {
      std::string bytes;
      const std::string digits = files::sha256(content);
      for (std::size_t i = 0; i < digits.size(); i += 2)
        bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
      return "'sha256-" + base64(bytes) + "'";
    };
    const std::string policy = between("http-equiv=\"Content-Security-Policy\" content=\"", "\"", 0);
    CHECK(policy.starts_with("default-src 'none'; "));
    CHECK(policy.find("unsafe") == std::string::npos);
    const std::string style = between("<style>", "</style>", 0);
    const std::size_t data_end = html.find("</script>");
    const std::string code = between("<script>", "</script>", data_end);
    CHECK(policy.find("script-src " + hash(code) + ";") != std::string::npos);
    CHECK(policy.find("style-src " + hash(style) + ";") != std::string::npos);
    CHECK(html.find("Content-Security-Policy") < html.find("<style>"));  // it holds for what follows it
    CHECK(html.find(" style=") == std::string::npos);
  }
}

TEST_CASE("what acts on a mechanism is in its page (D5)") {
  const auto json = nlohmann::json::parse(format_report_data(sample_page("spring-press.yaml", 3)));
  const auto& mechanism = json["mechanism"]["before"];
  for (const char* list : {"loads", "springs", "friction", "coordinates"}) {
    CAPTURE(list);
    CHECK(mechanism[list].size() > 0);
  }
  const auto geared = nlohmann::json::parse(format_report_data(sample_page("geared-five-bar.yaml", 3)));
  CHECK(geared["mechanism"]["before"]["couplings"][0]["ratio"] == -1);
}

TEST_CASE("a run that could not be made is in the page with its reason") {
  HtmlReport page = sample_page("rr.yaml", 3);
  page.trajectories[0].before->outcome = {MotionStatus::unreachable, 0.5, "too far away", {}};
  const auto json = nlohmann::json::parse(format_report_data(page));
  CHECK(json["trajectories"][0]["before"]["outcome"]["reason"] == "too far away");
  CHECK(!json["trajectories"][0]["before"].contains("series"));
}

TEST_CASE("a page is one document in itself, or says that its scripts are missing") {
  const HtmlReport page = sample_page("3rrr.yaml", 5);
  if (!has_report_scripts()) {
    CHECK_THROWS_WITH_AS(format_html_report(page), doctest::Contains("node 18"), SystemError);
    return;
  }
  const std::string html = format_html_report(page);
  CHECK(html.starts_with("<!doctype html>"));
  CHECK(html.ends_with("</html>\n"));
  for (const char* foreign : {"src=", "@import", "<link rel=\"stylesheet", "url(http"})
    CHECK(html.find(foreign) == std::string::npos);
  // Three.js comes only with mechanisms that need it.
  CHECK(html.size() < format_html_report(sample_page("delta.yaml", 5)).size() - 300'000);
}
