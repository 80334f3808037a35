#include "balance/compare/verdict.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance {
namespace {

constexpr double equality = 1e-9;  // above the round-off of a run, far below what anybody could build

/// What a comparison is judged by when several could be named: nothing is worse than a number that is not there.
double relative_margin(const Judged& judged) {
  const double percent = judged.margin_percent();
  if (!std::isnan(percent)) return percent;
  const double margin = judged.margin();
  if (std::isnan(margin)) return -std::numeric_limits<double>::infinity();
  return margin == 0 ? 0 : std::copysign(std::numeric_limits<double>::infinity(), margin);
}

}  // namespace

const char* symbol_of(Relation relation) {
  switch (relation) {
    case Relation::less: return "<";
    case Relation::at_most: return "<=";
    case Relation::greater: return ">";
    case Relation::at_least: return ">=";
    case Relation::equal: return "==";
  }
  return "?";
}

bool Judged::holds() const {
  switch (relation) {
    case Relation::less: return left < right;
    case Relation::at_most: return left <= right;
    case Relation::greater: return left > right;
    case Relation::at_least: return left >= right;
    case Relation::equal:
      return left == right || std::abs(left - right) <= equality * std::max(std::abs(left), std::abs(right));
  }
  return false;
}

double Judged::margin() const {
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

double Judged::margin_percent() const {
  return right == 0 ? std::numeric_limits<double>::quiet_NaN() : 100 * margin() / std::abs(right);
}

const Judged* Verdict::decisive() const {
  const Judged* found = nullptr;
  for (const Judged& judged : compared) {
    if (judged.holds() != holds) continue;
    if (found == nullptr || relative_margin(judged) < relative_margin(*found)) found = &judged;
  }
  return found;
}

std::string in_words(const Verdict& verdict) {
  if (!verdict.holds && !verdict.missing.empty()) return fmt::format("{}", fmt::join(verdict.missing, ", "));
  const Judged* judged = verdict.decisive();
  if (judged == nullptr) return verdict.holds ? "holds" : "missed";
  const std::string numbers = fmt::format("{:.6g} {} {:.6g}", judged->left, symbol_of(judged->relation), judged->right);
  const double percent = judged->margin_percent(), margin = judged->margin();
  if (std::isnan(margin)) return "missed: " + numbers + " has no number";
  const std::string by =
      std::isfinite(percent) ? percent_text(std::abs(percent)) : fmt::format("{:.6g}", std::abs(margin));
  return verdict.holds ? fmt::format("holds: {}, margin {}", numbers, by)
                       : fmt::format("missed by {}: {}", by, numbers);
}

std::string percent_text(double percent) {
  // Three digits, but no powers of ten where people expect none.
  return std::abs(percent) >= 100 && std::abs(percent) < 1e6 ? fmt::format("{:.0f} %", percent)
                                                             : fmt::format("{:.3g} %", percent);
}

bool all_hold(const std::vector<Verdict>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& verdict) { return verdict.holds; });
}

}  // namespace balance
