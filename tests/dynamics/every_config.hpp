#pragma once
/// The mechanisms of `configs/`, for laws that hold of all of them.

#include "balance/interface/specification/read_spec.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace doors {

/// Paths of all specs, starters included, in the order of their names.
inline std::vector<std::string> every_config() {
  std::vector<std::string> files;
  for (const char* folder : {BALANCE_CONFIGS, BALANCE_CONFIGS "/starters"})
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

inline balance::Study config(const std::string& name) {
  return balance::read_spec_file(std::string(BALANCE_CONFIGS "/") + name);
}

}  // namespace doors
