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

namespace balance {
namespace {

struct LoadedObjectSearch {
  std::uintptr_t address;
  std::string file;
};

/// Told of every loaded object in turn; the program itself has no name.
int take_if_it_holds(dl_phdr_info* object, std::size_t /*size*/, void* data) {
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
  dl_iterate_phdr(take_if_it_holds, &search);
  std::string digits = sha256_of_file(search.file);
  if (digits.empty()) throw SystemError("cannot read the program itself, to tell which build it is: " + search.file);
  return digits;
}

namespace {

namespace fs = std::filesystem;

/// Pipes and devices have no end or another one each time: who reads them here would never come to the cases.
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
    source.text = read_text_file(path, "spec");
  } catch (const SystemError& error) {
    source.failure_reason = error.what();
  }
  source.referenced_files = list_referenced_files(source.text, path);
  return source;
}

/// Text with its length, so that no two lists of texts read alike.
void append_length_prefixed(std::string& all, const std::string& text) {
  all += fmt::format("{}:{},", text.size(), text);
}

/// What depends on the spec alone.
std::string spec_part(const SpecSource& source, const std::string& build) {
  std::string all;
  append_length_prefixed(all, "balance case 2");
  append_length_prefixed(all, version());
  append_length_prefixed(all, build);
  append_length_prefixed(all, fs::path(source.path).filename().string());  // the result's command line names it
  append_length_prefixed(all, sha256(source.text));
  for (const std::string& table : source.referenced_files)
    append_length_prefixed(all, is_regular(table) ? sha256_of_file(table) : "");
  return all;
}

std::string make_cache_key(const SuiteCase& one, std::string all) {
  append_length_prefixed(all, one.name);  // a balanced spec is called by it
  for (const auto& [name, value] : one.overrides) {
    append_length_prefixed(all, "set");
    append_length_prefixed(all, name);
    append_length_prefixed(all, value);
  }
  append_length_prefixed(all, "trajectory");
  append_length_prefixed(all, one.trajectory);
  append_length_prefixed(all, one.samples ? std::to_string(*one.samples) : "");
  if (!one.controller.empty()) {
    append_length_prefixed(all, "controller");
    append_length_prefixed(all, one.controller);
  }
  if (one.design) {
    append_length_prefixed(all, one.design->modular ? "modular design" : "design");
    for (const Goal& goal : one.design->goals) append_length_prefixed(all, goal_name(goal));
    append_length_prefixed(all, one.design->minimize);
    append_length_prefixed(all, one.design->seed ? std::to_string(*one.design->seed) : "");
  }
  return sha256(all);
}

}  // namespace

BatchPlan make_batch_plan(Suite suite) {
  BatchPlan plan;
  const fs::path folder = fs::path(suite.file).parent_path();
  const std::string build = hash_build();
  std::map<std::string, std::size_t> index;
  std::vector<std::string> parts;
  for (const SuiteCase& one : suite.cases) {
    const std::string path = (folder / one.spec).string();
    const auto [at, is_new] = index.emplace(path, plan.specs.size());
    if (is_new) {
      plan.specs.push_back(read_source(path));
      parts.push_back(spec_part(plan.specs.back(), build));
    }
    plan.cases.push_back({at->second, make_cache_key(one, parts[at->second])});
  }
  plan.suite = std::move(suite);
  return plan;
}

bool is_in_shard(const std::string& case_name, const Shard& shard) {
  // The first 15 digits fit into 60 bits.
  const std::uint64_t number = std::stoull(sha256(case_name).substr(0, 15), nullptr, 16);
  return number % static_cast<std::uint64_t>(shard.count) == static_cast<std::uint64_t>(shard.index - 1);
}

}  // namespace balance
