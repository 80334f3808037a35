#pragma once
/// The spec's parameters and the arithmetic over them.

#include "balance/spec/calculator.hpp"
#include "balance/spec/cursor.hpp"
#include "balance/spec/free_numbers.hpp"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace balance::read {

/// `{free: [lower, upper], start: v}` as written, in the spec's units. Without `start` it starts in the middle.
struct FreeValue {
  double lower = 0, upper = 0, start = 0;
  bool start_given = false;
};

class Parameters {
 public:
  using Overrides = std::vector<std::pair<std::string, std::string>>;

  Parameters() = default;
  /// Evaluates all parameters, in whatever order they depend on each other. Problems are collected.
  /// @param section null if the spec has none
  /// @param given values of the free numbers; null: their start values
  Parameters(const std::optional<Cursor>& section, const Overrides& overrides, const FreeValues* given,
             Problems& problems);

  /// A number or an expression, in the spec's units. Fails unless it is finite, but not where free numbers are given.
  double evaluate(const Cursor& scalar);
  /// `{free: …}`; fails unless lower < upper and start is between them.
  FreeValue evaluate_free(const Cursor& map);

  const std::vector<FoundFreeNumber>& free_numbers() const { return free_numbers_; }
  /// In the document's order.
  const std::vector<std::string>& names() const { return names_; }
  /// All expressions that have been evaluated.
  const Calculated& calculated() const { return calculated_; }
  /// The values' mappings or scalars that an override replaced, with its text.
  const std::vector<std::pair<const Node*, std::string>>& overridden() const { return overridden_; }

 private:
  double evaluate_expression(const Cursor& scalar, const std::string& text);
  bool may_be_spoilt(const Cursor& at, const std::string& name) const;
  void define(const Member& member);
  double calculate(const std::string& expression);
  double calculate_anew(const std::string& expression);
  void override_values(const Overrides& overrides, std::vector<Member>& members, Problems& problems);

  std::size_t expressions_size_ = 0;
  std::optional<Calculator> calculator_;  ///< once an expression needs it
  const FreeValues* given_ = nullptr;
  std::vector<std::string> names_;  ///< in the document's order, for messages
  std::set<std::string> known_;     ///< the same, to look up
  std::unordered_map<std::string, double> values_;
  Calculated calculated_;
  std::vector<FoundFreeNumber> free_numbers_;
  std::vector<std::pair<const Node*, std::string>> overridden_;
  std::map<std::string, Node> replacements_;
};

}  // namespace balance::read
