#pragma once
/// `{free: [lower, upper], start: v}`, and discrete numbers:
/// `{free: [lower, upper], step: s}`, `{free: {values: […]}}`.

#include "balance/foundation/expression/expression.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/motion/study/study.hpp"

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace balance::specification {

// Amounts that are added to balance a mechanism: masses and moments of inertia of counterweights and discs, stiffnesses
// of springs. They start at 0 unless the spec gives a start: nothing has been added initially.

/// @param path of a number, `counterweights.cw1.mass`
bool is_added_element_path(const std::string& path);

/// Parameters on which only such numbers depend, directly or through other parameters, and at
/// whose value 0 they are defined.
/// @param root the document
std::set<std::string> list_added_element_parameters(const YamlNode& root);

// The free numbers of a spec while it is being read.

/// A free number, the mapping that defines it, and the input that represents it. Its span is not known yet.
struct FreeNumberEntry {
  const YamlNode* node = nullptr;
  FreeNumber number;
  Expression input;
  bool is_list_item = false;  ///< one of a list that the mapping stands for
};

/// As written, in the spec's units. Without `start` it starts in the middle.
struct FreeValue {
  double lower = 0, upper = 0, start = 0;
  std::vector<double> discrete_values;  ///< the only admissible values, increasing; empty: any
  FreeNumber::StartSource start_source = FreeNumber::StartSource::midpoint;

  /// Starts at 0 if the bounds allow it and no start is given.
  void default_start_to_zero();
  /// Starts as near to a value as possible.
  void start_near(double value);
};

/// Fails unless lower < upper, and start is between them and one of the discrete values.
/// @param evaluate evaluates a plain number or an expression
/// @param others further keys that this mapping may have
FreeValue read_free_value(const SpecCursor& map, const std::function<double(const SpecCursor&)>& evaluate,
                          const std::vector<Field>& others = {});

}  // namespace balance::specification
