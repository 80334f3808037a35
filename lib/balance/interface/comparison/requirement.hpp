#pragma once
/// Requirements on the figures of runs:
/// `peak(shaking_force) <= 0.9 * base`, `rms(torque[A1]) < 1.2 * rms(torque[A1], base)`.
/// The language is described in docs/compare.md.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/requirement_verdict.hpp"

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// The requirement is invalid; the message says what is wrong and where: "column 6: …".
class RequirementError : public std::runtime_error {
 public:
  RequirementError(std::size_t where, const std::string& message);
  std::size_t column;  ///< in the requirement's text, from 1, in bytes
};

/// A figure that a requirement refers to.
struct FigureReference {
  std::optional<Statistic> figure;  ///< of `quantity`; std::nullopt: the energy
  std::string quantity;
  std::string run;         ///< name of the run; empty: the run that the requirement is judged for
  std::string variable;    ///< its name in the arithmetic
  std::size_t column = 1;  ///< where it is written, from 1
};

/// Arithmetic on figures.
struct FigureExpression {
  std::string text;                      ///< as written
  std::string expression;                ///< the arithmetic, with a variable for every figure
  std::vector<FigureReference> figures;  ///< in the order of appearance
};

struct RequirementComparison {
  FigureExpression left, right;
  Relation relation = Relation::at_most;
  std::size_t column = 1;  ///< where it begins, from 1
};

struct Requirement {
  /// A step in postfix notation that combines the results of the comparisons.
  struct PostfixStep {
    enum class Kind { compare, logical_and, logical_or };
    Kind kind = Kind::compare;
    std::size_t comparison = 0;
  };
  std::string text;
  std::vector<RequirementComparison> comparisons;  ///< in the order of appearance
  std::vector<PostfixStep> steps;

  /// Whether some figure belongs to no named run. The requirement is then judged for each run but the base, otherwise
  /// once.
  bool applies_to_each_run() const;
  /// Names of the runs that figures refer to, each once; `base` is replaced by the base's name.
  std::vector<std::string> named_runs() const;
};

/// The names that a requirement may use.
struct RunNames {
  std::vector<std::string> all;  ///< may contain any characters; a requirement must quote names that are numbers
  std::string base;              ///< the run that `base` refers to; empty: none
};

/// Finds all mistakes that do not depend on the runs' quantities.
/// @throws RequirementError: syntax, no comparison, an unknown run or function
Requirement parse_requirement(const std::string& text, const RunNames& runs);

/// @param quantities those of at least one run
/// @throws RequirementError for any other quantity, with the nearest name
void check_quantities(const Requirement& requirement, const std::vector<std::string>& quantities);

/// A quantity that a run does not have is NaN and reported by the verdict: its comparison never holds.
/// @param tables of all runs that the requirement names, and of the run that figures without a name belong to
/// @param run index of the latter; ignored if the requirement names all its runs
/// @throws std::invalid_argument if the table of a named run is missing
RequirementVerdict judge_requirement(const Requirement& requirement, const std::vector<MetricTable>& tables,
                                     std::size_t run);

/// Judges every table but the first, or once if the requirement names all its runs.
std::vector<RequirementVerdict> judge_each_run(const Requirement& requirement, const std::vector<MetricTable>& tables);

/// Judges requirements as written; the first run is the base.
/// @throws std::invalid_argument "'rms(x) <': column 9: …"
std::vector<RequirementVerdict> judge_requirements(const std::vector<std::string>& texts,
                                                   const std::vector<NamedRun>& runs);

}  // namespace balance
