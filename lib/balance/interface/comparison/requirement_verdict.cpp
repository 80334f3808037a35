#include "balance/interface/comparison/requirement_verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::comparison {
namespace {

constexpr double requirement_equality_tolerance =
    1e-9;  // above the round-off of a run, far below any manufacturing tolerance

/// Whether one of several words, separated by spaces, is the given one.
bool contains_word(const std::string& words, const std::string& word) {
  return (" " + words + " ").find(" " + word + " ") != std::string::npos;
}

/// Ranks comparisons to find the deciding one; a missing number ranks lowest.
double relative_margin(const JudgedComparison& judged) {
  if (!judged.word.empty())
    return judged.holds() ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity();
  const double percent = judged.margin_percent();
  if (!std::isnan(percent)) return percent;
  const double margin = judged.margin();
  if (std::isnan(margin)) return -std::numeric_limits<double>::infinity();
  return margin == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), margin);
}

/// @param amount of the violation; empty if the sides are equal
std::string format_violation(Relation relation, const std::string& amount) {
  const bool above = relation == Relation::less || relation == Relation::at_most;
  if (relation == Relation::equal) return fmt::format("is {} from", amount);
  if (amount.empty()) return above ? "is not below the limit of" : "is not above the limit of";
  return fmt::format("is {} {} the limit of", amount, above ? "above" : "below");
}

}  // namespace

const char* relation_symbol(Relation relation) {
  switch (relation) {
    case Relation::less: return "<";
    case Relation::at_most: return "<=";
    case Relation::greater: return ">";
    case Relation::at_least: return ">=";
    case Relation::equal: return "==";
    case Relation::unequal: return "!=";
  }
  return "?";
}

bool JudgedComparison::holds() const {
  if (!word.empty()) return !words.empty() && contains_word(words, word) == (relation == Relation::equal);
  switch (relation) {
    case Relation::less: return left < right;
    case Relation::at_most: return left <= right;
    case Relation::greater: return left > right;
    case Relation::at_least: return left >= right;
    case Relation::equal:
      return left == right ||
             std::abs(left - right) <= requirement_equality_tolerance * std::max(std::abs(left), std::abs(right));
    case Relation::unequal: return false;  // of words only
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
    case Relation::equal:
    case Relation::unequal: return -std::abs(left - right);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double JudgedComparison::margin_percent() const {
  return right == 0 ? std::numeric_limits<double>::quiet_NaN() : 100 * margin() / std::abs(right);
}

const JudgedComparison* RequirementVerdict::deciding_comparison() const {
  const JudgedComparison* deciding = nullptr;
  for (const JudgedComparison& judged : compared) {
    if (judged.holds() != holds) continue;
    if (deciding == nullptr || relative_margin(judged) < relative_margin(*deciding)) deciding = &judged;
  }
  return deciding;
}

std::string describe_verdict(const RequirementVerdict& verdict) {
  if (!verdict.holds && !verdict.missing.empty()) return fmt::format("{}", fmt::join(verdict.missing, ", "));
  const JudgedComparison* judged = verdict.deciding_comparison();
  if (judged == nullptr) return verdict.holds ? "holds" : "missed";
  if (!judged->word.empty())
    return fmt::format("{}the verdict is {}{}", verdict.holds ? "holds: " : "", judged->words,
                       verdict.holds || judged->relation == Relation::unequal ? "" : ", not " + judged->word);
  const auto format_value = [&](double value) {
    return fmt::format("{:.6g}{}{}", value, judged->unit.empty() ? "" : " ", judged->unit);
  };
  const std::string left = format_value(judged->left), right = format_value(judged->right);
  const double percent = judged->margin_percent(), margin = judged->margin();
  if (std::isnan(margin))
    return fmt::format("{} {} {} cannot be decided", left, relation_symbol(judged->relation), right);
  constexpr double max_percent = 1e6;  // beyond it the limit is practically zero
  const std::string amount =
      std::abs(percent) < max_percent ? format_percent(std::abs(percent)) : format_value(std::abs(margin));
  if (verdict.holds)
    return fmt::format("holds: {} {} {}, margin {}", left, relation_symbol(judged->relation), right, amount);
  return fmt::format("{} {} {}", left, format_violation(judged->relation, margin == 0 ? "" : amount), right);
}

std::string format_percent(double percent) {
  // Three digits, but no exponent where people do not expect one.
  return std::abs(percent) >= 100 && std::abs(percent) < 1e6 ? fmt::format("{:.0f} %", percent)
                                                             : fmt::format("{:.3g} %", percent);
}

bool do_all_hold(const std::vector<RequirementVerdict>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const RequirementVerdict& verdict) { return verdict.holds; });
}

}  // namespace balance::comparison
