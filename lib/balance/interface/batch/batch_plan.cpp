#include "balance/interface/batch/batch_plan.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/version.hpp"
#include "balance/interface/files/sha256.hpp"
#include "balance/interface/specification/include_expansion.hpp"
#include "balance/interface/specification/text_file.hpp"

#include <fmt/format.h>
#include <link.h>

#include <cstdint>
#include <filesystem>
#include <map>

namespace balance::batch {
namespace {

struct LoadedObjectSearch {
  std::uintptr_t address;
  std::string file;
};

/// Callback for every loaded object in turn; the program itself has an empty name.
int find_object_containing(dl_phdr_info* object, std::size_t /*size*/, void* data) {
  auto& search = *static_cast<LoadedObjectSearch*>(data);
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& segment = object->dlpi_phdr[i];
    const std::uintptr_t begin = object->dlpi_addr + segment.p_vaddr;
    if (segment.p_type != PT_LOAD || search.address < begin || search.address >= begin + segment.p_memsz) continue;
    const std::string name = object->dlpi_name;
    search.file = name.empty() ? "/proc/self/exe" : name;
    return 1;
  }
  return 0;
}

}  // namespace

std::string hash_build() {
  LoadedObjectSearch search{reinterpret_cast<std::uintptr_t>(&hash_build), ""};
  dl_iterate_phdr(find_object_containing, &search);
  std::string digits = files::sha256_of_file(search.file);
  if (digits.empty()) throw SystemError("cannot read the program itself to identify its build: " + search.file);
  return digits;
}

namespace {

namespace fs = std::filesystem;

/// Pipes and devices may never end, or differ at every read: reading them here could keep the batch from starting.
bool is_regular(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

SpecSource read_source(const std::string& path) {
  SpecSource source;
  source.path = path;
  std::error_code ignored;
  if (path == "-" || (fs::exists(path, ignored) && !is_regular(path))) {
    source.failure_reason = path + ": expected a spec file, found something else";
    return source;
  }
  try {
    source.text = specification::read_text_file(path, "spec");
  } catch (const SystemError& error) {
    source.failure_reason = error.what();
  }
  source.referenced_files = specification::list_referenced_files(source.text, path);
  return source;
}

/// Prefixes a text with its length, so that different lists of texts never read alike.
void append_length_prefixed(std::string& key_text, const std::string& text) {
  key_text += fmt::format("{}:{},", text.size(), text);
}

/// The part of a key that depends on the spec and the build alone.
std::string spec_part(const SpecSource& source, const std::string& build) {
  std::string key_text;
  append_length_prefixed(key_text, "balance case 2");
  append_length_prefixed(key_text, version());
  append_length_prefixed(key_text, build);
  append_length_prefixed(key_text, fs::path(source.path).filename().string());  // part of the result's command line
  append_length_prefixed(key_text, files::sha256(source.text));
  for (const std::string& table : source.referenced_files)
    append_length_prefixed(key_text, is_regular(table) ? files::sha256_of_file(table) : "");
  return key_text;
}

/// What the case computes besides a motion. Nothing is appended for a motion alone.
void append_settings(const SuiteCase& suite_case, std::string& key_text) {
  const auto append = [&](const std::string& text) { append_length_prefixed(key_text, text); };
  if (suite_case.kind != CaseKind::motion) {
    append("run");
    append(std::to_string(static_cast<int>(suite_case.kind)));
    for (const Goal& goal : suite_case.goals) append(goal_name(goal));
    append("at");
    append(suite_case.state.at);
    append(suite_case.state.rates);
    append(suite_case.state.accelerations);
    if (!suite_case.sweep.empty()) append(suite_case.sweep);
  }
  for (const CasePoint& point : suite_case.points) {
    append("point");
    append(point.name);
    append(point.body);
    append(point.body_point);
    for (const double x : point.position) append(fmt::format("{}", x));
  }
  for (const SolvedParameter& solved : suite_case.solved) {
    append("solve");
    append(solved.parameter);
    append(solved.figure.text);
    for (const double x : {solved.value, solved.lower, solved.upper}) append(fmt::format("{}", x));
  }
}

std::string make_cache_key(const SuiteCase& suite_case, std::string key_text) {
  append_length_prefixed(key_text, suite_case.name);  // the balanced spec is named after it
  for (const auto& [name, value] : suite_case.overrides) {
    append_length_prefixed(key_text, "set");
    append_length_prefixed(key_text, name);
    append_length_prefixed(key_text, value);
  }
  append_length_prefixed(key_text, "trajectory");
  append_length_prefixed(key_text, suite_case.trajectory);
  append_length_prefixed(key_text, suite_case.samples ? std::to_string(*suite_case.samples) : "");
  if (!suite_case.controller.empty()) {
    append_length_prefixed(key_text, "controller");
    append_length_prefixed(key_text, suite_case.controller);
  }
  if (suite_case.design) {
    append_length_prefixed(key_text, suite_case.design->modular ? "modular design" : "design");
    for (const Goal& goal : suite_case.design->goals) append_length_prefixed(key_text, goal_name(goal));
    append_length_prefixed(key_text, suite_case.design->minimize);
    append_length_prefixed(key_text, suite_case.design->seed ? std::to_string(*suite_case.design->seed) : "");
  }
  append_settings(suite_case, key_text);
  return files::sha256(key_text);
}

}  // namespace

BatchPlan make_batch_plan(Suite suite) {
  BatchPlan plan;
  const fs::path folder = fs::path(suite.file).parent_path();
  const std::string build = hash_build();
  std::map<std::string, std::size_t> index;
  std::vector<std::string> spec_keys;
  std::vector<std::vector<comparison::FigureReference>> figures = list_asked_figures(suite);
  for (const SuiteCase& suite_case : suite.cases) {
    const std::string path = (folder / suite_case.spec).string();
    const auto [entry, is_new] = index.emplace(path, plan.specs.size());
    if (is_new) {
      plan.specs.push_back(read_source(path));
      spec_keys.push_back(spec_part(plan.specs.back(), build));
    }
    plan.cases.push_back({entry->second, make_cache_key(suite_case, spec_keys[entry->second]),
                          std::move(figures[plan.cases.size()]), asks_for_verdict(suite, suite_case)});
  }
  plan.suite = std::move(suite);
  return plan;
}

bool is_in_shard(const std::string& case_name, const Shard& shard) {
  // The first 15 digits fit into 60 bits.
  const std::uint64_t number = std::stoull(files::sha256(case_name).substr(0, 15), nullptr, 16);
  return number % static_cast<std::uint64_t>(shard.count) == static_cast<std::uint64_t>(shard.index - 1);
}

}  // namespace balance::batch
