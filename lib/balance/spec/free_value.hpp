#pragma once
/// `{free: [lower, upper], start: v}`, and numbers that come in sizes: `{free: [lower, upper], step: s}`, `{free: {values: […]}}`.

#include "balance/spec/cursor.hpp"
#include "balance/study/study.hpp"

#include <functional>
#include <vector>

namespace balance::specification {

/// As written, in the spec's units. Without `start` it starts in the middle.
struct FreeValue {
  double lower = 0, upper = 0, start = 0;
  std::vector<double> discrete_values;  ///< the only values, increasing; empty: any
  FreeNumber::StartSource start_source = FreeNumber::StartSource::midpoint;

  /// Starts at 0 where the bounds allow it and nobody has said otherwise.
  void default_start_to_zero();
  /// Starts as near to a value as it can.
  void start_near(double value);
};

/// Fails unless lower < upper and start is between them, and one of the sizes.
/// @param number the value of a plain number or an expression
/// @param others keys that this mapping may have besides
FreeValue read_free_value(const SpecCursor& map, const std::function<double(const SpecCursor&)>& number,
                          const std::vector<Field>& others = {});

}  // namespace balance::specification
