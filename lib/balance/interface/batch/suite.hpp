#pragma once
/// A suite: many cases, what they are compared with and what is required of them. The language is described in docs/suite.md.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance {

/// How a case's spec is balanced before it moves, as `balance design` does.
struct CaseDesignOptions {
  std::vector<Goal> goals;  ///< empty: the spec's
  bool modular = false;
  std::string minimize;  ///< YAML as for `--minimize`; empty: the spec's
  std::optional<std::uint64_t> seed;
};

/// A requirement and where the suite says it, for messages: "suite.yaml:9:5: require[0]".
struct SuiteRequirement {
  Requirement requirement;
  SourceLocation location;
};

struct SuiteCase {
  std::string name;                                            ///< of its own, fit for a file
  std::string spec;                                            ///< path seen from the suite's folder
  std::vector<std::pair<std::string, std::string>> overrides;  ///< parameters, as for `--set`
  std::string trajectory;                                      ///< empty: the first of the spec
  std::optional<long> samples;                                 ///< nothing: as in the spec
  std::string controller;                                      ///< empty: inverse dynamics, no controller
  std::optional<CaseDesignOptions> design;                     ///< nothing: the spec moves as it is
  std::vector<SuiteRequirement> requirements;                  ///< of this case alone
  std::vector<std::pair<std::string, SourceLocation>>
      locations;  ///< "spec", "trajectory", "set.xg", … → "suite.yaml:4:7: cases.a.spec"

  /// Where the suite says a part of the case; the case itself if it does not say it.
  SourceLocation location_of(const std::string& part) const;
};

struct Suite {
  std::string file;  ///< as named by the user
  std::string name;
  std::vector<SuiteCase> cases;  ///< at least one
  std::string baseline;          ///< name of a case; empty: none
  std::vector<SuiteRequirement> require;
};

/// More are a mistake in a matrix.
inline constexpr std::size_t max_cases = 100'000;

/// @param text the suite, UTF-8
/// @throws SpecError with everything that is wrong, in the order of the document
Suite parse_suite(const std::string& text, const std::string& file_name);

/// @throws SystemError if the file cannot be read; SpecError as above
Suite read_suite_file(const std::string& path);

}  // namespace balance
