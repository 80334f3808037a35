#pragma once
/// The front door: YAML text in, a complete and validated Study out. The language is described in docs/spec.md.

#include "balance/study/study.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance {

struct ReadOptions {
  /// Parameters to override, name and value; the value may be an expression over the other parameters.
  std::vector<std::pair<std::string, std::string>> set;
};

/// @param text the spec, UTF-8, at most 4 MiB
/// @param file_name what messages call it; files that the spec names are looked for in its folder
/// @throws SpecError with the first thing that is wrong, in the order of the document
Study read_spec(const std::string& text, const std::string& file_name, const ReadOptions& options = {});

/// @throws SystemError if the file cannot be read; SpecError as above
Study read_spec_file(const std::string& path, const ReadOptions& options = {});

}  // namespace balance
