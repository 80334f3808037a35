#pragma once
/// A suite: many cases, the baseline that they are compared with, and requirements. The language is described in
/// docs/suite.md.

#include "balance/foundation/base/error.hpp"
#include "balance/interface/batch/published_row.hpp"
#include "balance/interface/comparison/requirement.hpp"
#include "balance/motion/study/balance_goal.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::batch {

/// How a case's spec is balanced before it is simulated, as by `balance design`.
struct CaseDesignOptions {
  std::vector<Goal> goals;  ///< empty: as in the spec
  bool modular = false;
  std::string minimize;  ///< YAML as for `--minimize`; empty: as in the spec
  std::optional<std::uint64_t> seed;
};

/// What a case computes.
enum class CaseKind {
  motion,      ///< a run along a trajectory, of the designed mechanism if there is a design
  design,      ///< a design alone
  conditions,  ///< as `balance conditions`
  equations,   ///< as `balance equations --at`: a single state
  modes,       ///< as `balance modes`
};

/// A point fixed to a body, whose motion has figures.
struct CasePoint {
  std::string name, body;
  std::string body_point;        ///< name of one of the body's points; empty: its origin, or `position`
  std::vector<double> position;  ///< in the body's axes, in the spec's unit of length; empty: none
};

/// A state as `balance equations` takes it.
struct CaseState {
  std::string at, rates, accelerations;  ///< as for --at, --rates, --accelerations; empty: none
};

/// A parameter whose value is found such that a figure has a given value.
struct SolvedParameter {
  std::string parameter;
  comparison::FigureExpression figure;
  double value = 0;             ///< of the figure [SI]
  double lower = 0, upper = 0;  ///< bracket of the parameter, as written in specs
};

struct SuiteCase {
  std::string name;                                            ///< unique and valid in a file name
  std::string spec;                                            ///< path relative to the suite's folder
  std::vector<std::pair<std::string, std::string>> overrides;  ///< parameters, as for `--set`
  std::string trajectory;                                      ///< empty: the first one of the spec
  std::optional<long> samples;                                 ///< std::nullopt: as in the spec
  std::string controller;                                      ///< empty: inverse dynamics, no controller
  std::optional<CaseDesignOptions> design;                     ///< std::nullopt: the spec is simulated as it is
  CaseKind kind = CaseKind::motion;
  std::vector<Goal> goals;  ///< of conditions; empty: as in the spec
  CaseState state;          ///< of equations
  std::string sweep;        ///< of modes, as for --sweep; empty: none
  std::vector<CasePoint> points;
  std::vector<SolvedParameter> solved;         ///< the last one is solved for at every value of those before it
  std::vector<SuiteRequirement> requirements;  ///< of this case only
  CaseSource source;
  std::vector<PublishedRow> published;  ///< each is a requirement, too
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

/// The figures that requirements and published rows ask of each case, each once, in the order of the cases.
std::vector<std::vector<comparison::FigureReference>> list_asked_figures(const Suite& suite);

/// Whether a requirement or a published row of the case, or one of the suite's that is judged for it, refers to the
/// verdict of its design: then an impossible design is a result.
bool asks_for_verdict(const Suite& suite, const SuiteCase& suite_case);

/// A larger number is a mistake in a matrix.
inline constexpr std::size_t max_cases = 100'000;

/// @param text the suite, UTF-8
/// @throws SpecError with all mistakes, in the order of the document
Suite parse_suite(const std::string& text, const std::string& file_name);

/// @throws SystemError if the file cannot be read; SpecError as above
Suite read_suite_file(const std::string& path);

}  // namespace balance::batch
