#pragma once
/// What became of a requirement: whether it holds for a run, and by how much.

#include <string>
#include <vector>

namespace balance {

enum class Relation { less, at_most, greater, at_least, equal };

const char* relation_symbol(Relation relation);  ///< "<", "<=", …

/// One comparison with the numbers that it came to.
struct JudgedComparison {
  std::string left_text, right_text;  ///< as written
  Relation relation = Relation::at_most;
  double left = 0, right = 0;  ///< SI; NaN where a run lacks a quantity
  std::string unit;            ///< of both; empty: they have none in common

  /// Never with NaN. Equal means within one part in 10^9: nobody's round-off should break a build.
  bool holds() const;
  /// How far it is from failing, in the numbers' unit; negative: by how much it misses.
  double margin() const;
  /// The same in percent of the right side's magnitude; NaN if that is zero.
  double margin_percent() const;
};

struct RequirementVerdict {
  std::string requirement;  ///< as written
  std::string run;          ///< that it was judged for; empty: it names all its runs itself
  bool holds = false;
  std::vector<JudgedComparison> compared;  ///< in the order in which they stand; `&&` and `||` join them
  std::vector<std::string> missing;        ///< "rail has no torque[A4]"

  /// The comparison that decides: of those that fail the one that misses by most; if it holds, the tightest. Null: none.
  const JudgedComparison* deciding_comparison() const;
};

/// One line: "holds: 402.492 N <= 782.771 N, margin 48.6 %", "900 N is 12.5 % above the limit of 800 N", "rail has no torque[A4]".
std::string describe_verdict(const RequirementVerdict& verdict);

/// "12.5 %", "0.031 %", "1640 %".
std::string format_percent(double percent);

bool do_all_hold(const std::vector<RequirementVerdict>& verdicts);

}  // namespace balance
