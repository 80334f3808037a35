#pragma once
/// The verdict on a requirement: whether it holds for a run, and by which margin.

#include <string>
#include <vector>

namespace balance::comparison {

enum class Relation { less, at_most, greater, at_least, equal, unequal };

const char* relation_symbol(Relation relation);  ///< "<", "<=", …

/// A comparison with the values of its sides.
struct JudgedComparison {
  std::string left_text, right_text;  ///< as written
  Relation relation = Relation::at_most;
  double left = 0, right = 0;  ///< SI; NaN if a run does not have a quantity
  std::string unit;            ///< of both; empty if they have no common unit
  std::string words, word;     ///< of `verdict() == word`: the verdict's words, separated by spaces; otherwise empty

  /// False with NaN. Equal means within one part in 10^9, so that round-off does not break a build.
  bool holds() const;
  /// Distance from failing, in the unit of the sides; negative if it fails.
  double margin() const;
  /// The same in percent of the right side's magnitude; NaN if that is zero.
  double margin_percent() const;
};

struct RequirementVerdict {
  std::string requirement;  ///< as written
  std::string run;          ///< that it was judged for; empty if the requirement names all its runs
  bool holds = false;
  std::vector<JudgedComparison> compared;  ///< in the order of appearance, joined by `&&` and `||`
  std::vector<std::string> missing;        ///< "rail has no torque[A4]"

  /// The deciding comparison: if the requirement fails, the failing one that misses most; if it holds, the tightest.
  /// nullptr: none.
  const JudgedComparison* deciding_comparison() const;
};

/// One line, such as "holds: 402.492 N <= 782.771 N, margin 48.6 %", "900 N is 12.5 % above the limit of 800 N", "rail
/// has no torque[A4]".
std::string describe_verdict(const RequirementVerdict& verdict);

/// "12.5 %", "0.031 %", "1640 %".
std::string format_percent(double percent);

bool do_all_hold(const std::vector<RequirementVerdict>& verdicts);

}  // namespace balance::comparison
