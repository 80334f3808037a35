#include "balance/interface/specification/free_number.hpp"

#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/interface/specification/part_insertion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace balance::specification {

namespace {

/// Sections that refer to parameters by name, not as numbers.
bool holds_parameter_names(const std::string& path) {
  return path.starts_with("tolerances") || path.starts_with("design.adapt");
}

/// Whether the expression has a value if one of its names is 0.
bool has_value_at_zero(const std::string& text, const std::string& name) {
  try {
    return std::isfinite(expression::parse_expression(text, [&](const std::string& other) {
                           return Expression(other == name ? 0.0 : 1.0);
                         }).value());
  } catch (const expression::ExpressionError&) {
    return true;  // the reader reports what is wrong with it
  }
}

/// Uses of every name in the document.
class ParameterUses {
 public:
  explicit ParameterUses(const YamlNode& root) { visit(root, ""); }

  std::set<std::string> find_added_element_parameters() const {
    std::map<std::string, std::vector<std::string>> names_in_expression;  // per parameter: names in its expression
    std::vector<std::string> pending;                                     // used in something else, too
    for (const auto& [name, use] : uses_) {
      for (const std::string& parameter : use.parameters) names_in_expression[parameter].push_back(name);
      if (use.is_in_other_value || !(use.is_in_added_element || !use.parameters.empty())) pending.push_back(name);
    }
    std::set<std::string> excluded(pending.begin(), pending.end());
    while (!pending.empty()) {
      const std::string name = std::move(pending.back());
      pending.pop_back();
      for (const std::string& other : names_in_expression[name])
        if (excluded.insert(other).second) pending.push_back(other);
    }
    std::set<std::string> names;
    for (const auto& [name, use] : uses_)
      if (!excluded.contains(name)) names.insert(name);
    return names;
  }

 private:
  struct Use {
    bool is_in_added_element = false;  ///< used in an added amount
    bool is_in_other_value = false;    ///< used in something else
    std::set<std::string> parameters;  ///< parameters whose expressions use it
  };

  void visit(const YamlNode& node, const std::string& path) {
    for (std::size_t k = 0; k < node.items.size(); ++k) {
      const bool is_map = node.kind == YamlNode::Kind::map;
      const std::string key = is_map ? (path.empty() ? "" : ".") + node.keys[k].text : "[" + std::to_string(k) + "]";
      visit(node.items[k], path + key);
    }
    if (node.kind != YamlNode::Kind::scalar || holds_parameter_names(path)) return;
    for (const std::string& name : expression::find_expression_names(node.text).values) add_use(name, node.text, path);
  }

  void add_use(const std::string& name, const std::string& text, const std::string& path) {
    constexpr std::string_view prefix = "parameters.";
    Use& use = uses_[name];
    const bool is_parameter = path.starts_with(prefix);
    if ((!is_parameter && !is_added_element_path(path)) || !has_value_at_zero(text, name))
      use.is_in_other_value = true;
    else if (is_parameter)
      use.parameters.insert(path.substr(prefix.size()));
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

namespace {

using NumberReader = std::function<double(const SpecCursor&)>;

constexpr const char* free_value_form = "a number, an expression or {free: [lower, upper]}";
constexpr std::size_t max_discrete_values = 10'000;
/// Relative to a step, or to the range between the bounds; covers round-off of expressions.
constexpr double step_count_tolerance = 1e-9;

double find_nearest_value(const std::vector<double>& values, double value) {
  return *std::min_element(values.begin(), values.end(),
                           [value](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
}

void read_bounds(const SpecCursor& at, const NumberReader& evaluate, FreeValue& free) {
  double* bound = &free.lower;
  read_each(at.items("[lower, upper]", 2),
            [&](const SpecCursor& item) { *std::exchange(bound, &free.upper) = evaluate(item); });
  if (!(free.lower < free.upper))
    at.fail({.expected = "lower < upper", .found = fmt::format("[{}, {}]", free.lower, free.upper)});
}

void read_discrete_values(const SpecCursor& at, const NumberReader& evaluate, FreeValue& free) {
  read_each(at.items("sizes [a, b, …]"), [&](const SpecCursor& item) {
    const double value = evaluate(item);
    if (std::find(free.discrete_values.begin(), free.discrete_values.end(), value) != free.discrete_values.end())
      item.fail({.expected = "each size only once", .found = item.describe_found() + " again"});
    if (free.discrete_values.size() == max_discrete_values)
      at.fail({.expected = fmt::format("at most {} sizes", max_discrete_values)});
    free.discrete_values.push_back(value);
  });
  if (free.discrete_values.size() < 2)
    at.fail({.expected = "at least two sizes", .found = fmt::format("{}", free.discrete_values.size())});
  std::sort(free.discrete_values.begin(), free.discrete_values.end());
}

/// Multiples of steps such as 0.1 are rounded to what people would write.
double step_multiple(double lower, double step, double count) {
  const double steps_per_unit = std::round(1 / step), lower_in_steps = lower * steps_per_unit;
  if (std::abs(steps_per_unit * step - 1) > 1e-12 ||
      std::abs(lower_in_steps - std::round(lower_in_steps)) > step_count_tolerance)
    return lower + count * step;
  return (std::round(lower_in_steps) + count) / steps_per_unit;
}

void read_step(const SpecCursor& at, const NumberReader& evaluate, FreeValue& free) {
  const double step = evaluate(at);
  if (!(step > 0)) at.fail({.kind = "must be positive", .expected = "a number > 0", .found = fmt::format("{}", step)});
  const double count = std::floor((free.upper - free.lower) / step + step_count_tolerance);
  if (!(count >= 1))
    at.fail({.expected = fmt::format("a step of at most {}, the distance between the bounds", free.upper - free.lower),
             .found = fmt::format("{}", step)});
  if (!(count < static_cast<double>(max_discrete_values)))
    at.fail({.expected = fmt::format("a step that makes at most {} sizes", max_discrete_values),
             .found = fmt::format("{}", step)});
  for (int k = 0; k <= static_cast<int>(count); ++k) free.discrete_values.push_back(step_multiple(free.lower, step, k));
}

void check_start(const SpecCursor& map, FreeValue& free) {
  if (!(free.start >= free.lower && free.start <= free.upper))
    map.fail({.expected = fmt::format("a start between {} and {}", free.lower, free.upper),
              .found = fmt::format("{}", free.start)});
  if (free.discrete_values.empty()) return;
  const double nearest = find_nearest_value(free.discrete_values, free.start);
  if (std::abs(nearest - free.start) > step_count_tolerance * (free.upper - free.lower))
    map.fail({.expected = "a start that is one of the sizes",
              .found = fmt::format("{}", free.start),
              .hint = fmt::format("nearest is {}", nearest)});
  free.start = nearest;
}

}  // namespace

void FreeValue::default_start_to_zero() {
  if (start_source != FreeNumber::StartSource::midpoint || lower > 0 || upper < 0) return;
  start_near(0);
  start_source = FreeNumber::StartSource::zero_of_added_element;
}

void FreeValue::start_near(double value) {
  start = discrete_values.empty() ? value : find_nearest_value(discrete_values, value);
}

FreeValue read_free_value(const SpecCursor& map, const NumberReader& evaluate, const std::vector<Field>& others) {
  FreeValue free;
  std::optional<double> start;
  std::optional<SpecCursor> step;
  const auto read_free = [&](const SpecCursor& c) {
    if (!c.is_map()) return read_bounds(c, evaluate, free);
    if (!read_fields(
            c, "[lower, upper] or {values: [a, b, …]}",
            {{"values", Presence::required, [&](const SpecCursor& v) { read_discrete_values(v, evaluate, free); }}}))
      throw CascadingError();
  };
  std::vector<Field> fields{{"free", Presence::required, read_free},
                            {"start", Presence::optional, [&](const SpecCursor& c) { start = evaluate(c); }},
                            {"step", Presence::optional, [&](const SpecCursor& c) { step = c; }}};
  fields.insert(fields.end(), others.begin(), others.end());
  if (!read_fields(map, free_value_form, fields)) throw CascadingError();
  if (step && !free.discrete_values.empty())
    step->fail({.expected = "no 'step' with 'values', which list the sizes already", .found = step->describe_found()});
  if (step) read_step(*step, evaluate, free);
  if (!free.discrete_values.empty()) {
    free.lower = free.discrete_values.front();
    free.upper = free.discrete_values.back();
  }
  if (start) free.start_source = FreeNumber::StartSource::spec;
  free.start_near(free.lower + (free.upper - free.lower) / 2);
  if (start) free.start = *start;
  check_start(map, free);
  return free;
}

}  // namespace balance::specification
