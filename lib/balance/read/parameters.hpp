#pragma once
/// The spec's parameters and the arithmetic over them.

#include "balance/read/calculator.hpp"
#include "balance/read/cursor.hpp"
#include "balance/study/study.hpp"

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace balance::read {

/// `{free: [lower, upper], start: v}` as written, in the spec's units. Without `start` it starts in the middle.
struct FreeValue {
  double lower = 0, upper = 0, start = 0;
};

class Parameters {
 public:
  using Overrides = std::vector<std::pair<std::string, std::string>>;

  Parameters() = default;
  /// Evaluates all parameters, in whatever order they depend on each other. Problems are collected.
  /// @param section null if the spec has none
  Parameters(const std::optional<Cursor>& section, const Overrides& overrides, Problems& problems);

  /// A number or an expression, in the spec's units. Fails unless it is finite.
  double evaluate(const Cursor& scalar);
  /// `{free: …}`; fails unless lower < upper and start is between them.
  FreeValue evaluate_free(const Cursor& map);

  const std::vector<FreeNumber>& free_numbers() const { return free_numbers_; }

 private:
  double evaluate_expression(const Cursor& scalar, const std::string& text);

  Calculator calculator_;
  std::vector<std::string> names_;  ///< in the document's order, for messages
  std::set<std::string> known_;     ///< the same, to look up
  std::vector<FreeNumber> free_numbers_;
};

}  // namespace balance::read
