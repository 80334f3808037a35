// What cases come to together.

#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/batch_summary.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

namespace {

using namespace balance;
using namespace balance::batch;

CaseRecord record(const std::string& name, double peak, const std::string& status = "done") {
  CaseRecord one;
  one.name = name;
  one.status = status;
  if (one.has_result()) {
    one.metrics = {{"shaking_force", "N", peak, 0.5, peak / 2, peak / 3, peak}};
    one.energy = 2;
  }
  return one;
}

Suite suite(const std::string& rest) {
  return parse_suite("cases: {a: {spec: s}, b: {spec: s}, c: {spec: s}}\nbaseline: a\n" + rest, "suite.yaml");
}

}  // namespace

TEST_CASE("a record that is written down is the same when it is read") {
  CaseRecord one = record("a", 1.0 / 3);
  one.cache_key = "k";
  one.message = "\"quoted\" \xc3\xa9\n";
  one.title = "t";
  one.trajectory = "cycloid";
  one.samples = 11;
  one.seconds = 0.1;
  one.design = {"balanced", "because", 9.1, 1e-300};
  one.metrics.push_back({"torque[A1]", "N m", std::numeric_limits<double>::quiet_NaN(), 0.1, 0.2, 0.3, 1e308});
  one.warnings = {"w"};
  one.notes = {"n", ""};
  one.files = {{"a.h5", "00"}};
  const auto read = decode_record(encode_record(one));
  REQUIRE(read.has_value());
  CHECK(encode_record(*read) == encode_record(one));
  CHECK(read->metrics[0].peak == 1.0 / 3);
  CHECK(std::isnan(read->metrics[1].peak));
  CHECK(read->design->mass_after == 1e-300);
}

TEST_CASE("a record with one changed digit is none (C5)") {
  CaseRecord one = record("a", 15.1974);
  one.failure = {"timeout", 10};
  const std::string whole = encode_record(one);
  REQUIRE(decode_record(whole).has_value());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = changed[i] == '1' ? '2' : '1';
    CHECK_FALSE(decode_record(changed).has_value());
  }
  CHECK_FALSE(decode_record(whole + "\n").has_value());
  CHECK_FALSE(decode_record(" " + whole).has_value());
}

TEST_CASE("half a record is none") {
  const std::string whole = encode_record(record("a", 1));
  for (std::size_t size = 0; size + 2 < whole.size(); size += 7)
    CHECK_FALSE(decode_record(whole.substr(0, size)).has_value());
  CHECK_FALSE(decode_record("{}").has_value());
  CHECK_FALSE(decode_record("[1, 2]").has_value());
  CHECK_FALSE(decode_record(R"({"name": 3})").has_value());
}

TEST_CASE("the exit code is the worst of all") {
  const auto code = [](const std::string& b, const std::string& c, const std::string& require = "") {
    return summarise_batch(suite(require), {record("a", 10), record("b", 9, b), record("c", 8, c)}).exit_code();
  };
  CHECK(code("done", "done") == 0);
  CHECK(code("done", "compromise") == 1);
  CHECK(code("done", "done", "require: peak(shaking_force) < base") == 0);
  CHECK(code("done", "done", "require: peak(shaking_force) < 0.85 * base") == 1);
  CHECK(code("spec", "compromise") == 3);
  CHECK(code("mechanism", "spec") == 4);
  CHECK(code("mechanism", "system") == 5);
  CHECK(code("done", "missing") == 5);
  CHECK(code("done", "done", "require: peak(shaking_farce) < base") == 3);
}

TEST_CASE("requirements are judged for every case but the baseline, or for their own case") {
  const Suite own = parse_suite(
      "cases: {a: {spec: s}, b: {spec: s, require: peak(shaking_force) < 9.5}}\nbaseline: a\n"
      "require: [peak(shaking_force) < base, 'peak(shaking_force, b) < peak(shaking_force, a)']",
      "suite.yaml");
  const BatchSummary summary = summarise_batch(own, {record("a", 10), record("b", 9)});
  REQUIRE(summary.requirements.size() == 3);
  CHECK(summary.requirements[0].run == "b");
  CHECK(summary.requirements[1].run.empty());
  CHECK(summary.requirements[2].run == "b");
  for (const RequirementOutcome& one : summary.requirements) CHECK(one.status == RequirementOutcome::Status::holds);
}

TEST_CASE("a requirement on a case without a result is not judged") {
  const BatchSummary summary = summarise_batch(suite("require: peak(shaking_force) < base"),
                                               {record("a", 0, "mechanism"), record("b", 9), record("c", 8)});
  REQUIRE(summary.requirements.size() == 2);
  CHECK(summary.requirements[0].status == RequirementOutcome::Status::not_judged);
  CHECK(summary.requirements[0].message == "not judged: a has no result");
  CHECK(summary.baseline_record() == nullptr);
}

TEST_CASE("no text is a formula where a spreadsheet reads the table (C8)") {
  CaseRecord one = record("b", 5);
  for (const std::string text : {"=1+1", "+1", "-x", "@a", "\tx", "=a,\"b\""}) {
    one.trajectory = text;
    const std::string csv = summary_csv(summarise_batch(suite(""), {record("a", -10), one, record("c", 1)}));
    CHECK(csv.find("," + text) == std::string::npos);
    CHECK(csv.find("'" + text.substr(0, 2)) != std::string::npos);
    CHECK(csv.find(",-10,") != std::string::npos);  // a number stays one
  }
}

TEST_CASE("no text is markup, HTML or a terminal's command where a summary is read") {
  const std::string odd = "x <script>alert(1)</script> \x1b[31m &amp; `c` | *b* _i_ [l](u) $m$ ~s~ \\* ]]>";
  CaseRecord one = record("b", 5, "mechanism");
  one.message = odd + "\nsecond line";
  Suite hostile = suite("require: peak(shaking_force, c) < base");
  hostile.name = odd;
  const std::string text = summary_markdown(summarise_batch(hostile, {record("a", 10), one, record("c", 30)}));
  const std::string safe =
      "x &lt;script>alert(1)&lt;/script> \\x1b[31m &amp;amp; \\`c\\` \\| \\*b\\* \\_i\\_ [l\\](u) \\$m\\$ \\~s\\~ "
      "\\\\\\* ]]>";
  CHECK(text.find("# " + safe + "\n") == 0);
  CHECK(text.find("- b (mechanism): " + safe + " second line\n") != std::string::npos);
  CHECK(text.find("| `peak(shaking_force, c) < base` |") != std::string::npos);
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK(text.find("<s") == std::string::npos);
}

TEST_CASE("what failed is named on lines of its own, requirements with value, limit and unit") {
  const BatchSummary summary = summarise_batch(suite("require: peak(shaking_force) < base"),
                                               {record("a", 10), record("b", 12), record("c", 0, "mechanism")});
  CHECK(format_failures(summary) ==
        "FAILED c: \nFAILED peak(shaking_force) < base [b]: 12 N is 20 % above the limit of 10 N\n");
  // in a pull request they come first
  const std::string page = summary_markdown(summary);
  CHECK_MESSAGE(page.find("[b] (missed): 12 N is 20 % above the limit of 10 N\n") < page.find("## Cases"), page);
  CHECK(format_failures(summarise_batch(suite(""), {record("a", 1), record("b", 1), record("c", 1)})).empty());
}

TEST_CASE("a case's test says how long it took") {
  CaseRecord one = record("b", 5);
  one.seconds = 1.5;
  const std::string xml = summary_junit(
      summarise_batch(suite("require: peak(shaking_force) < base"), {record("a", 10), one, record("c", 9)}));
  CHECK(xml.find("<testcase name=\"b\" classname=\"suite.cases\" time=\"1.500000\"/>") != std::string::npos);
  CHECK(xml.find("peak(shaking_force) &lt; base [b]\" classname=\"suite.requirements\" time=\"0.000000\"/>") !=
        std::string::npos);
}

TEST_CASE("a case that its process did not survive is an error with its reason (C1)") {
  CaseRecord dead = record("b", 0, "failed");
  dead.message = "crashed: SIGSEGV";
  dead.failure = {"crashed", 0};
  const BatchSummary summary =
      summarise_batch(suite("require: peak(shaking_force) < base"), {record("a", 10), dead, record("c", 8)});
  CHECK(summary.exit_code() == 5);
  CHECK(summary.requirements[0].status == RequirementOutcome::Status::not_judged);
  CHECK(summary.requirements[1].status == RequirementOutcome::Status::holds);
  CHECK(format_batch_text(summary).find("b: crashed: SIGSEGV") != std::string::npos);
  CHECK(format_batch_text(summary).find("2 done, 1 failed") != std::string::npos);
  CHECK(summary_junit(summary).find("crashed: SIGSEGV") != std::string::npos);
  CHECK(summary_json(summary).find("\"cause\": \"crashed\"") != std::string::npos);
  CHECK(summary_csv(summary).find("b,s,,failed,") != std::string::npos);
  CHECK(encode_record(*decode_record(encode_record(dead))) == encode_record(dead));
}

TEST_CASE("the table for programs has as many cells in every line") {
  const std::string csv =
      summary_csv(summarise_batch(suite(""), {record("a", 10), record("b", 5), record("c", 0, "mechanism")}));
  std::size_t begin = 0, lines = 0;
  for (std::size_t end = csv.find('\n'); end != std::string::npos; end = csv.find('\n', begin)) {
    const std::string line = csv.substr(begin, end - begin);
    CHECK(std::count(line.begin(), line.end(), ',') == 13);
    begin = end + 1;
    ++lines;
  }
  CHECK(lines == 1 + 2 * 2 + 1);
  CHECK(csv.find("b,s,,done,shaking_force,N,5,0.5,2.5,1.6666666666666667,5,,0.5,0.5\n") != std::string::npos);
}
