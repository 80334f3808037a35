#include "balance/compare/run_names.hpp"

#include "balance/base/plain_text.hpp"

#include <algorithm>
#include <filesystem>

namespace balance {
namespace {

/// From the shortest name to the longest.
std::vector<std::string> list_candidates(const RunLocation& place) {
  const std::filesystem::path path = std::filesystem::path(place.path).lexically_normal();
  const std::string stem = escape_for_terminal(path.stem().string());
  const std::string folder = escape_for_terminal(path.parent_path().filename().string());
  const std::string behind = place.group.empty() ? "" : ":" + place.group;
  std::vector<std::string> names;
  if (!place.group.empty()) names.push_back(place.group);
  names.push_back(stem + behind);
  if (!folder.empty()) names.push_back(folder + "/" + stem + behind);
  names.push_back(escape_for_terminal((path.parent_path() / path.stem()).string()) + behind);
  return names;
}

bool is_taken(const std::vector<std::string>& names, std::size_t run) {
  if (run > 0 && names[run] == "base") return true;
  return std::count(names.begin(), names.end(), names[run]) > 1;
}

}  // namespace

std::vector<std::string> make_run_names(const std::vector<RunLocation>& places) {
  std::vector<std::vector<std::string>> candidates;
  std::vector<std::string> names;
  std::size_t longest = 0;
  for (const RunLocation& place : places) {
    candidates.push_back(list_candidates(place));
    names.push_back(candidates.back().front());
    longest = std::max(longest, candidates.back().size());
  }
  for (std::size_t length = 1; length < longest; ++length) {
    std::vector<std::string> longer = names;
    for (std::size_t run = 0; run < names.size(); ++run) {
      if (is_taken(names, run)) longer[run] = candidates[run][std::min(length, candidates[run].size() - 1)];
    }
    names = longer;
  }
  for (std::size_t run = 1; run < names.size(); ++run) {
    const std::string name = names[run];
    for (std::size_t number = 2; is_taken(names, run); ++number) names[run] = name + "-" + std::to_string(number);
  }
  return names;
}

}  // namespace balance
