// A suite becomes cases, each with a key of everything that its result depends on.

#include "balance/interface/batch/batch_folder.hpp"
#include "balance/interface/batch/batch_plan.hpp"
#include "balance/interface/batch/batch_run.hpp"
#include "balance/interface/files/sha256.hpp"

#include <doctest/doctest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace {

using namespace balance;
using namespace balance::batch;
namespace fs = std::filesystem;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("balance-plan-" + std::to_string(::getpid()));
  Folder() { fs::create_directory(path); }
  ~Folder() { fs::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
  BatchPlan plan(const std::string& suite) const {
    return make_batch_plan(parse_suite(suite, (path / "suite.yaml").string()));
  }
  std::string key(const std::string& suite) const { return plan(suite).cases.at(0).key; }
};

std::vector<std::string> names_of(const Suite& suite) {
  std::vector<std::string> names;
  for (const SuiteCase& one : suite.cases) names.push_back(one.name);
  return names;
}

}  // namespace

TEST_CASE("a matrix is every spec with every trajectory with every value of each parameter") {
  const Suite suite = parse_suite(
      "matrix: {spec: [a.yaml, sub/b.yaml], trajectory: [t, u v], set: {x: [1, l/2], y: {from: 0, to: 1, count: 3}}}",
      "s");
  REQUIRE(suite.cases.size() == 2 * 2 * 2 * 3);
  CHECK(suite.cases[0].name == "a_t_x=1_y=0");
  CHECK(suite.cases[1].name == "a_t_x=1_y=0.5");
  CHECK(suite.cases[3].name == "a_t_x=l_2_y=0");
  CHECK(suite.cases[23].name == "b_u_v_x=l_2_y=1");
  CHECK(suite.cases[23].spec == "sub/b.yaml");
  CHECK(suite.cases[23].trajectory == "u v");
  const std::vector<std::pair<std::string, std::string>> set{{"x", "l/2"}, {"y", "1"}};
  CHECK(suite.cases[23].overrides == set);
}

TEST_CASE("cases take from the defaults what they do not say, parameters one by one") {
  const Suite suite = parse_suite(
      "defaults: {spec: a.yaml, samples: 11, set: {x: 1, y: 2}}\n"
      "cases: {one: {}, two: {set: {y: 3}, samples: 12, spec: b.yaml, design: {goal: [static, force], seed: 7}}}",
      "suite.yaml");
  CHECK(names_of(suite) == std::vector<std::string>{"one", "two"});
  CHECK(suite.cases[0].spec == "a.yaml");
  CHECK(suite.cases[0].samples == 11);
  CHECK_FALSE(suite.cases[0].design.has_value());
  const std::vector<std::pair<std::string, std::string>> set{{"x", "1"}, {"y", "3"}};
  CHECK(suite.cases[1].overrides == set);
  REQUIRE(suite.cases[1].design.has_value());
  CHECK(suite.cases[1].design->goals.size() == 2);
  CHECK(suite.cases[1].location_of("set.y").text() == "suite.yaml:2:33: cases.two.set.y");
  CHECK(suite.cases[1].location_of("trajectory").text() == "suite.yaml:2:18: cases.two");
}

TEST_CASE("what is to be minimized arrives as YAML") {
  const Suite suite =
      parse_suite("cases: {a: {spec: s, design: {minimize: [added-mass, {rms: 'torque[A1]', along: t}]}}}", "s");
  CHECK(suite.cases[0].design->minimize.find("\"torque[A1]\"") != std::string::npos);
  CHECK(suite.cases[0].design->minimize.front() == '[');
}

TEST_CASE("a key depends on everything that the result depends on, and on nothing else") {
  const Folder folder;
  folder.write("a.yaml", "loads: {p: {file: table.csv}}\n");
  folder.write("b.yaml", "loads: {p: {file: table.csv}}\n");
  folder.write("table.csv", "1");
  const std::string begin = "cases: {c: {spec: a.yaml";
  std::set<std::string> keys;
  std::size_t count = 0;
  const auto differs = [&](const std::string& suite) {
    keys.insert(folder.key(suite));
    CHECK(keys.size() == ++count);
  };
  differs(begin + "}}");
  differs(begin + ", samples: 11}}");
  differs(begin + ", trajectory: t}}");
  differs(begin + ", set: {x: 1}}}");
  differs(begin + ", set: {x: 2}}}");
  differs(begin + ", set: {y: 1}}}");
  differs(begin + ", design: true}}");
  differs(begin + ", design: {goal: static}}}");
  differs(begin + ", design: {strategy: modular}}}");
  differs(begin + ", design: {seed: 1}}}");
  differs(begin + ", design: {minimize: added-mass}}}");
  differs("cases: {c: {spec: b.yaml}}");
  folder.write("table.csv", "2");
  differs(begin + "}}");
  folder.write("a.yaml", "loads: {p: {file: table.csv}} \n");
  differs(begin + "}}");
  // The suite's other parts do not matter.
  const std::string same = folder.key(begin + "}}");
  CHECK(folder.key("name: n\n" + begin + ", design: false}, d: {spec: a.yaml}}\nbaseline: c") == same);
}

TEST_CASE("the program's build is its bytes (C11)") {
  const std::string build = hash_build();
  CHECK(build == balance::files::sha256_of_file("/proc/self/exe"));
  CHECK(build.size() == 64);
}

TEST_CASE("what a batch would replace although it reads it is found by any of its names (C4)") {
  const Folder folder;
  folder.write("a.yaml", "loads: {p: {file: table.csv}}\n");
  folder.write("table.csv", "1");
  const std::string designed = "cases: {a: {spec: a.yaml, design: true}}";
  const fs::path out = folder.path / "out", other = folder.path / "other";
  const auto trouble = [&](const std::string& suite, const fs::path& where) {
    folder.write("suite.yaml", suite);
    return find_overwritten_input(folder.plan(suite), where.string());
  };
  CHECK(trouble(designed, folder.path).find("the spec") == 0);
  CHECK(trouble("cases: {a: {spec: a.yaml}}", folder.path).empty());  // nothing is called a.yaml
  CHECK(trouble(designed, out).empty());
  fs::create_directory(out);
  CHECK(trouble(designed, out).empty());
  fs::create_symlink("../a.yaml", out / "b.h5");
  CHECK(trouble("cases: {b: {spec: a.yaml}}", out).find("the spec") == 0);
  fs::create_hard_link(folder.path / "table.csv", out / "c.case.json");
  CHECK(trouble("cases: {c: {spec: a.yaml}}", out).find("the table") == 0);
  fs::create_directory_symlink(folder.path, other);
  CHECK(trouble(designed, other).find("the spec") == 0);
  fs::create_hard_link(folder.path / "suite.yaml", out / "summary.json");
  CHECK(find_overwritten_input(folder.plan("cases: {d: {spec: a.yaml}}"), out.string()).find("the suite") == 0);
  CHECK_THROWS_AS(run_batch(folder.plan(designed), {.folder = folder.path.string(), .force = true}),
                  std::invalid_argument);
}

TEST_CASE("pipes and devices do not keep a plan waiting (C1)") {
  const Folder folder;
  REQUIRE(::mkfifo((folder.path / "pipe.yaml").c_str(), 0600) == 0);
  folder.write("endless.yaml", "loads: {p: {file: /dev/zero}, q: {file: pipe.yaml}}\n");
  const BatchPlan all = folder.plan(
      "cases: {a: {spec: pipe.yaml}, b: {spec: /dev/zero}, c: {spec: endless.yaml}, d: {spec: '-'}, e: {spec: .}}");
  for (const std::size_t i : {0U, 1U, 3U, 4U}) CHECK_FALSE(all.specs[all.cases[i].spec].failure_reason.empty());
  CHECK(all.specs[all.cases[2].spec].failure_reason.empty());
}

TEST_CASE("every case is in one shard, and shards are of about the same size") {
  for (const int count : {1, 2, 7}) {
    std::vector<int> sizes(static_cast<std::size_t>(count));
    for (int i = 0; i < 700; ++i) {
      int found = 0;
      for (int index = 1; index <= count; ++index) {
        if (!is_in_shard("case" + std::to_string(i), {index, count})) continue;
        ++found;
        ++sizes[static_cast<std::size_t>(index - 1)];
      }
      CHECK(found == 1);
    }
    for (const int size : sizes) {  // five standard deviations of throwing 700 dice
      CHECK(size >= 700 / count - 50);
      CHECK(size <= 700 / count + 50);
    }
  }
}
