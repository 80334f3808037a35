#include "balance/spec/added_amounts.hpp"

#include "balance/expression/parse.hpp"
#include "balance/spec/part_names.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::specification {

namespace {

/// Sections that name parameters as names, not as numbers.
bool holds_parameter_names(const std::string& path) {
  return path.starts_with("tolerances") || path.starts_with("design.adapt");
}

/// The expression has a value where one of its names is 0.
bool has_value_at_zero(const std::string& text, const std::string& name) {
  try {
    return std::isfinite(parse_expression(text, [&](const std::string& other) {
                           return Expression(other == name ? 0.0 : 1.0);
                         }).value());
  } catch (const ExpressionError&) {
    return true;  // what is wrong is the reader's to say
  }
}

/// Where every name of the document is used.
class ParameterUses {
 public:
  explicit ParameterUses(const YamlNode& root) { visit(root, ""); }

  std::set<std::string> find_added_element_parameters() const {
    std::map<std::string, std::vector<std::string>> fed_by;  // per parameter: what stands in it
    std::vector<std::string> spoilt;                         // feeds something else, too
    for (const auto& [name, use] : uses_) {
      for (const std::string& parameter : use.parameters) fed_by[parameter].push_back(name);
      if (use.is_in_other_value || !(use.is_in_added_element || !use.parameters.empty())) spoilt.push_back(name);
    }
    std::set<std::string> not_only(spoilt.begin(), spoilt.end());
    while (!spoilt.empty()) {
      const std::string name = std::move(spoilt.back());
      spoilt.pop_back();
      for (const std::string& other : fed_by[name])
        if (not_only.insert(other).second) spoilt.push_back(other);
    }
    std::set<std::string> found;
    for (const auto& [name, use] : uses_)
      if (!not_only.contains(name)) found.insert(name);
    return found;
  }

 private:
  struct Use {
    bool is_in_added_element = false;  ///< in an added amount
    bool is_in_other_value = false;    ///< in something else
    std::set<std::string> parameters;  ///< in these
  };

  void visit(const YamlNode& node, const std::string& path) {
    for (std::size_t k = 0; k < node.items.size(); ++k) {
      const bool named = node.kind == YamlNode::Kind::map;
      const std::string key = named ? (path.empty() ? "" : ".") + node.keys[k].text : "[" + std::to_string(k) + "]";
      visit(node.items[k], path + key);
    }
    if (node.kind != YamlNode::Kind::scalar || holds_parameter_names(path)) return;
    for (const std::string& name : find_expression_names(node.text).values) add_use(name, node.text, path);
  }

  void add_use(const std::string& name, const std::string& text, const std::string& path) {
    constexpr std::string_view section = "parameters.";
    Use& use = uses_[name];
    const bool parameter = path.starts_with(section);
    if ((!parameter && !is_added_element_path(path)) || !has_value_at_zero(text, name))
      use.is_in_other_value = true;
    else if (parameter)
      use.parameters.insert(path.substr(section.size()));
    else
      use.is_in_added_element = true;
  }

  std::map<std::string, Use> uses_;
};

}  // namespace

bool is_added_element_path(const std::string& path) {
  const bool carried = path.starts_with("counterweights.") || path.starts_with("discs.");
  return (carried && (path.ends_with(".mass") || path.ends_with(".inertia"))) ||
         (path.starts_with("springs.") && path.ends_with(".stiffness"));
}

std::set<std::string> list_added_element_parameters(const YamlNode& root) {
  const YamlNode* parameters = find_entry(root, "parameters");
  const bool any_free =
      parameters != nullptr && std::any_of(parameters->items.begin(), parameters->items.end(),
                                           [](const YamlNode& n) { return n.kind == YamlNode::Kind::map; });
  return any_free ? ParameterUses(root).find_added_element_parameters() : std::set<std::string>{};
}

}  // namespace balance::specification
