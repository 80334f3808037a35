#pragma once
/// The spec's parameters and expressions over them.

#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/specification/free_number.hpp"
#include "balance/interface/specification/spec_cursor.hpp"
#include "balance/motion/study/spec_expressions.hpp"

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace balance::specification {

/// Total length of the expressions of a spec, in characters.
inline constexpr std::size_t max_expressions_length = 500'000;

class SpecParameters {
 public:
  using Overrides = std::vector<std::pair<std::string, std::string>>;

  SpecParameters() = default;
  /// Evaluates all parameters in the order of their dependencies. Collects mistakes.
  /// @param section null if the spec has none
  /// @param recording gets an input or a node for each
  /// @param zero_start_parameters parameters that start at 0 (list_added_element_parameters)
  SpecParameters(const std::optional<SpecCursor>& section, const Overrides& overrides,
                 std::set<std::string> zero_start_parameters, study::Recording& recording,
                 SpecErrorCollector& problems);

  /// A number or an expression, in the spec's units. Fails unless it is finite.
  Expression evaluate(const SpecCursor& scalar);
  /// An expression of variables and parameters; a parameter takes precedence over a variable of the same name.
  /// @param value of a name; with the parameter of that name, or null for a variable
  Expression evaluate(const SpecCursor& scalar, const std::vector<std::string>& variables,
                      const std::function<Expression(const std::string& name, const Expression* parameter)>& value);
  /// `{free: …}`, as read_free_value.
  FreeValue evaluate_free(const SpecCursor& map, const std::vector<Field>& others = {});

  const std::vector<FreeNumberEntry>& free_numbers() const { return free_numbers_; }
  /// In the document's order.
  const std::vector<std::string>& names() const { return names_; }
  /// Values, mappings or scalars, that an override replaced, with its text.
  const std::vector<std::pair<const YamlNode*, std::string>>& overridden() const { return overridden_; }

 private:
  Expression evaluate_expression(const SpecCursor& scalar, const std::string& text,
                                 const std::vector<std::string>& variables,
                                 const std::function<Expression(const std::string& name)>& value);
  bool can_be_invalid(const SpecCursor& at, const std::string& name) const;
  void define(const Member& member, study::Recording& recording);
  void override_values(const Overrides& overrides, std::vector<Member>& members, SpecErrorCollector& problems);

  std::set<std::string> added_element_parameters_;
  std::size_t expressions_size_ = 0;
  std::vector<std::string> names_;  ///< in the document's order, for messages
  std::set<std::string> name_set_;  ///< the same, for lookup
  std::unordered_map<std::string, Expression> values_;
  std::vector<FreeNumberEntry> free_numbers_;
  std::vector<std::pair<const YamlNode*, std::string>> overridden_;
  std::map<std::string, YamlNode> replacements_;
};

}  // namespace balance::specification
