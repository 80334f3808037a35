#pragma once
/// A suite: many cases, the baseline that they are compared with, and requirements. The language is described in
/// docs/suite.md.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// How a case's spec is balanced before it is simulated, as by `balance design`.
struct CaseDesignOptions {
  std::vector<Goal> goals;  ///< empty: as in the spec
  bool modular = false;
  std::string minimize;  ///< YAML as for `--minimize`; empty: as in the spec
  std::optional<std::uint64_t> seed;
};

/// A requirement and its location in the suite, for messages: "suite.yaml:9:5: require[0]".
struct SuiteRequirement {
  Requirement requirement;
  SourceLocation location;
};

struct SuiteCase {
  std::string name;                                            ///< unique and valid in a file name
  std::string spec;                                            ///< path relative to the suite's folder
  std::vector<std::pair<std::string, std::string>> overrides;  ///< parameters, as for `--set`
  std::string trajectory;                                      ///< empty: the first one of the spec
  std::optional<long> samples;                                 ///< std::nullopt: as in the spec
  std::string controller;                                      ///< empty: inverse dynamics, no controller
  std::optional<CaseDesignOptions> design;                     ///< std::nullopt: the spec is simulated as it is
  std::vector<SuiteRequirement> requirements;                  ///< of this case only
  std::vector<std::pair<std::string, SourceLocation>>
      locations;  ///< "spec", "trajectory", "set.xg", … → "suite.yaml:4:7: cases.a.spec"

  /// Location of a part of the case in the suite; the location of the case if the part is not given.
  SourceLocation location_of(const std::string& key) const;
};

struct Suite {
  std::string file;  ///< as named by the user
  std::string name;
  std::vector<SuiteCase> cases;  ///< at least one
  std::string baseline;          ///< name of a case; empty: none
  std::vector<SuiteRequirement> require;
};

/// A larger number is a mistake in a matrix.
inline constexpr std::size_t max_cases = 100'000;

/// @param text the suite, UTF-8
/// @throws SpecError with all mistakes, in the order of the document
Suite parse_suite(const std::string& text, const std::string& file_name);

/// @throws SystemError if the file cannot be read; SpecError as above
Suite read_suite_file(const std::string& path);

}  // namespace balance
