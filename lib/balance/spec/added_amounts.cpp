#include "balance/spec/added_amounts.hpp"

#include "balance/expression/parse.hpp"
#include "balance/spec/part_names.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::read {

namespace {

/// Sections that name parameters as names, not as numbers.
bool tells_names(const std::string& path) { return path.starts_with("tolerances") || path.starts_with("design.adapt"); }

/// The expression has a value where one of its names is 0.
bool has_value_without(const std::string& text, const std::string& name) {
  try {
    return std::isfinite(parse_expression(text, [&](const std::string& other) {
                           return Expression(other == name ? 0.0 : 1.0);
                         }).value());
  } catch (const ExpressionError&) {
    return true;  // what is wrong is the reader's to say
  }
}

/// Where every name of the document is used.
class Uses {
 public:
  explicit Uses(const Node& root) { visit(root, ""); }

  std::set<std::string> of_added_amounts() const {
    std::map<std::string, std::vector<std::string>> fed_by;  // per parameter: what stands in it
    std::vector<std::string> spoilt;                         // feeds something else, too
    for (const auto& [name, use] : uses_) {
      for (const std::string& parameter : use.parameters) fed_by[parameter].push_back(name);
      if (use.other || !(use.added || !use.parameters.empty())) spoilt.push_back(name);
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
    bool added = false;                ///< in an added amount
    bool other = false;                ///< in something else
    std::set<std::string> parameters;  ///< in these
  };

  void visit(const Node& node, const std::string& path) {
    for (std::size_t k = 0; k < node.items.size(); ++k) {
      const bool named = node.kind == Node::Kind::map;
      const std::string key = named ? (path.empty() ? "" : ".") + node.keys[k].text : "[" + std::to_string(k) + "]";
      visit(node.items[k], path + key);
    }
    if (node.kind != Node::Kind::scalar || tells_names(path)) return;
    for (const std::string& name : names_in(node.text).values) note(name, node.text, path);
  }

  void note(const std::string& name, const std::string& text, const std::string& path) {
    constexpr std::string_view section = "parameters.";
    Use& use = uses_[name];
    const bool parameter = path.starts_with(section);
    if ((!parameter && !is_added_amount(path)) || !has_value_without(text, name))
      use.other = true;
    else if (parameter)
      use.parameters.insert(path.substr(section.size()));
    else
      use.added = true;
  }

  std::map<std::string, Use> uses_;
};

}  // namespace

bool is_added_amount(const std::string& path) {
  const bool carried = path.starts_with("counterweights.") || path.starts_with("discs.");
  return (carried && (path.ends_with(".mass") || path.ends_with(".inertia"))) ||
         (path.starts_with("springs.") && path.ends_with(".stiffness"));
}

std::set<std::string> parameters_of_added_amounts(const Node& root) {
  const Node* parameters = find_entry(root, "parameters");
  const bool any_free = parameters != nullptr && std::any_of(parameters->items.begin(), parameters->items.end(),
                                                             [](const Node& n) { return n.kind == Node::Kind::map; });
  return any_free ? Uses(root).of_added_amounts() : std::set<std::string>{};
}

}  // namespace balance::read
