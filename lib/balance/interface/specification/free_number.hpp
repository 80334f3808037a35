#pragma once
/// `{free: [lower, upper], start: v}`, and numbers that come in sizes: `{free: [lower, upper], step: s}`, `{free: {values: […]}}`.

#include "balance/foundation/expression/expression.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/interface/specification/yaml_document.hpp"
#include "balance/motion/study/study.hpp"

#include <functional>
#include <set>
#include <string>
#include <vector>

namespace balance::specification {

// What a designer adds to balance a mechanism: masses and moments of inertia of counterweights and discs, stiffnesses of springs.
// Such numbers start at 0, where nobody says otherwise: what is added is not there to begin with.

/// @param path of a number, `counterweights.cw1.mass`
bool is_added_element_path(const std::string& path);

/// The parameters that feed such numbers and nothing else, through other parameters or not, and let them have a value at 0.
/// @param root the document
std::set<std::string> list_added_element_parameters(const YamlNode& root);

// The free numbers of a spec while it is being read.

/// A free number, the mapping that says so, and the input that stands for it. Its span is not known yet.
struct FreeNumberEntry {
  const YamlNode* node = nullptr;
  FreeNumber number;
  Expression input;
  bool is_list_item = false;  ///< one of a list that the mapping stands for
};

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
