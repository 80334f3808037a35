#pragma once
/// Requirements on the figures of runs: `peak(shaking_force) <= 0.9 * base`, `rms(torque[A1]) < 1.2 * rms(torque[A1], base)`.
/// The language is described in docs/compare.md.

#include "balance/interface/comparison/comparison.hpp"
#include "balance/interface/comparison/requirement_verdict.hpp"

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance {

/// A requirement makes no sense; the message says what is wrong, where: "column 6: …".
class RequirementError : public std::runtime_error {
 public:
  RequirementError(std::size_t where, const std::string& message);
  std::size_t column;  ///< in the requirement's text, from 1, in bytes
};

/// A figure that a requirement asks for.
struct FigureReference {
  std::optional<Statistic> figure;  ///< of `quantity`; nothing: the energy
  std::string quantity;
  std::string run;         ///< its name; empty: the run that the requirement is judged for
  std::string variable;    ///< that stands for it in the arithmetic
  std::size_t column = 1;  ///< where it stands, from 1
};

/// Arithmetic on figures.
struct FigureExpression {
  std::string text;                      ///< as written
  std::string expression;                ///< with a variable for every figure
  std::vector<FigureReference> figures;  ///< in the order in which they stand
};

struct RequirementComparison {
  FigureExpression left, right;
  Relation relation = Relation::at_most;
  std::size_t column = 1;  ///< where it begins, from 1
};

struct Requirement {
  /// A step of a stack machine that joins what the comparisons came to.
  struct PostfixStep {
    enum class Kind { compare, logical_and, logical_or };
    Kind kind = Kind::compare;
    std::size_t comparison = 0;
  };
  std::string text;
  std::vector<RequirementComparison> comparisons;  ///< in the order in which they stand
  std::vector<PostfixStep> steps;

  /// Some figure is of no named run: the requirement is judged for each run but the base. Otherwise it is judged once.
  bool applies_to_each_run() const;
  /// Names of the runs that figures are of by name, each once; `base` stands as the name of the base.
  std::vector<std::string> named_runs() const;
};

/// The names that a requirement may use.
struct RunNames {
  std::vector<std::string> all;  ///< may hold any characters; names that are numbers stand in quotes in a requirement
  std::string base;              ///< the run that `base` means; empty: there is none
};

/// Whatever can be wrong without knowing the runs' quantities is found here.
/// @throws RequirementError: syntax, no comparison, an unknown run or function
Requirement parse_requirement(const std::string& text, const RunNames& runs);

/// @param quantities that at least one run has
/// @throws RequirementError for any other, with the nearest
void check_quantities(const Requirement& requirement, const std::vector<std::string>& quantities);

/// @param tables of all runs that the requirement names, and of the one that figures without a name are of
/// @param run index of that one; means nothing if the requirement names all its runs
/// A quantity that a run does not have is NaN, and the verdict says so: its comparison never holds.
/// @throws std::invalid_argument if there is no table of a run that the requirement names
RequirementVerdict judge_requirement(const Requirement& requirement, const std::vector<MetricTable>& tables,
                                     std::size_t run);

/// For every table but the first, or once if the requirement names all its runs.
std::vector<RequirementVerdict> judge_each_run(const Requirement& requirement, const std::vector<MetricTable>& tables);

/// Requirements as written, on runs of which the first is the base.
/// @throws std::invalid_argument "'rms(x) <': column 9: …"
std::vector<RequirementVerdict> judge_requirements(const std::vector<std::string>& texts,
                                                   const std::vector<NamedRun>& runs);

}  // namespace balance
