#include "balance/interface/comparison/requirement_verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance {
namespace {

constexpr double requirement_equality_tolerance =
    1e-9;  // above the round-off of a run, far below what anybody could build

/// What a comparison is judged by when several could be named: nothing is worse than a number that is not there.
double relative_margin(const JudgedComparison& judged) {
  const double percent = judged.margin_percent();
  if (!std::isnan(percent)) return percent;
  const double margin = judged.margin();
  if (std::isnan(margin)) return -std::numeric_limits<double>::infinity();
  return margin == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), margin);
}

/// @param by how much; empty: the sides are equal
std::string format_violation(Relation relation, const std::string& by) {
  const bool above = relation == Relation::less || relation == Relation::at_most;
  if (relation == Relation::equal) return fmt::format("is {} from", by);
  if (by.empty()) return above ? "is not below the limit of" : "is not above the limit of";
  return fmt::format("is {} {} the limit of", by, above ? "above" : "below");
}

}  // namespace

const char* relation_symbol(Relation relation) {
  switch (relation) {
    case Relation::less: return "<";
    case Relation::at_most: return "<=";
    case Relation::greater: return ">";
    case Relation::at_least: return ">=";
    case Relation::equal: return "==";
  }
  return "?";
}

bool JudgedComparison::holds() const {
  switch (relation) {
    case Relation::less: return left < right;
    case Relation::at_most: return left <= right;
    case Relation::greater: return left > right;
    case Relation::at_least: return left >= right;
    case Relation::equal:
      return left == right ||
             std::abs(left - right) <= requirement_equality_tolerance * std::max(std::abs(left), std::abs(right));
  }
  return false;
}

double JudgedComparison::margin() const {
  if (left == right) return 0;  // infinities too
  switch (relation) {
    case Relation::less:
    case Relation::at_most: return right - left;
    case Relation::greater:
    case Relation::at_least: return left - right;
    case Relation::equal: return -std::abs(left - right);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double JudgedComparison::margin_percent() const {
  return right == 0 ? std::numeric_limits<double>::quiet_NaN() : 100 * margin() / std::abs(right);
}

const JudgedComparison* RequirementVerdict::deciding_comparison() const {
  const JudgedComparison* found = nullptr;
  for (const JudgedComparison& judged : compared) {
    if (judged.holds() != holds) continue;
    if (found == nullptr || relative_margin(judged) < relative_margin(*found)) found = &judged;
  }
  return found;
}

std::string describe_verdict(const RequirementVerdict& verdict) {
  if (!verdict.holds && !verdict.missing.empty()) return fmt::format("{}", fmt::join(verdict.missing, ", "));
  const JudgedComparison* judged = verdict.deciding_comparison();
  if (judged == nullptr) return verdict.holds ? "holds" : "missed";
  const auto number = [&](double value) {
    return fmt::format("{:.6g}{}{}", value, judged->unit.empty() ? "" : " ", judged->unit);
  };
  const std::string left = number(judged->left), right = number(judged->right);
  const double percent = judged->margin_percent(), margin = judged->margin();
  if (std::isnan(margin)) return fmt::format("{} {} {} has no number", left, relation_symbol(judged->relation), right);
  constexpr double max_percent = 1e6;  // more is a limit that is next to nothing
  const std::string by = std::abs(percent) < max_percent ? format_percent(std::abs(percent)) : number(std::abs(margin));
  if (verdict.holds)
    return fmt::format("holds: {} {} {}, margin {}", left, relation_symbol(judged->relation), right, by);
  return fmt::format("{} {} {}", left, format_violation(judged->relation, margin == 0 ? "" : by), right);
}

std::string format_percent(double percent) {
  // Three digits, but no powers of ten where people expect none.
  return std::abs(percent) >= 100 && std::abs(percent) < 1e6 ? fmt::format("{:.0f} %", percent)
                                                             : fmt::format("{:.3g} %", percent);
}

bool do_all_hold(const std::vector<RequirementVerdict>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const RequirementVerdict& verdict) { return verdict.holds; });
}

}  // namespace balance
