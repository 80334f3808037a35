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

namespace balance::comparison {

/// The requirement is invalid; the message says what is wrong and where: "column 6: …".
class RequirementError : public std::runtime_error {
 public:
  RequirementError(std::size_t where, const std::string& message);
  std::size_t column;  ///< in the requirement's text, from 1, in bytes
};

/// Arithmetic on figures.
struct FigureExpression {
  std::string text;                      ///< as written
  std::string expression;                ///< the arithmetic, with a variable for every figure
  std::vector<FigureReference> figures;  ///< in the order of appearance
};

struct RequirementComparison {
  FigureExpression left, right;
  std::string word;  ///< of `verdict() == word`; otherwise empty
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
  bool accepts_bare_quantities = false;  ///< `torque[J1]` is value(torque[J1]): of single states
};

/// Finds all mistakes that do not depend on the runs' quantities.
/// @throws RequirementError: syntax, no comparison, an unknown run or function
Requirement parse_requirement(const std::string& text, const RunNames& runs);

/// Arithmetic on figures without a comparison, such as `-value(joint_velocity[X], 0.3) / 2`.
/// @throws RequirementError
FigureExpression parse_figure_expression(const std::string& text, const RunNames& runs);

/// The value of arithmetic on figures.
struct ExpressionAnswer {
  double value = 0;                  ///< SI; NaN: a figure has no value
  std::string unit;                  ///< if all figures have it and the arithmetic keeps it; otherwise empty
  bool is_plain_sum = false;         ///< of figures with the factors 1, 0 and −1: no constant changes their unit
  std::vector<std::string> missing;  ///< as RequirementVerdict::missing
};

/// @param run index of the table that figures without a run belong to
/// @throws RequirementError for a figure that is a mistake in that table
ExpressionAnswer evaluate_expression(const FigureExpression& expression, const std::vector<MetricTable>& tables,
                                     std::size_t run);

/// @param quantities those of at least one run
/// @throws RequirementError for any other quantity, with the nearest name
void check_quantities(const Requirement& requirement, const std::vector<std::string>& quantities);

/// The same for tables in which the requirement's figures were evaluated.
/// @throws RequirementError for a figure that is a mistake in every table that was asked for it
void check_figures(const Requirement& requirement, const std::vector<MetricTable>& tables);

/// All figures of a requirement, in the order of appearance.
std::vector<FigureReference> list_figures(const Requirement& requirement);

/// Whether a comparison of the requirement is `verdict() == word` or `verdict() != word`.
bool refers_to_verdict(const Requirement& requirement);

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

}  // namespace balance::comparison
