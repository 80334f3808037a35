#include "balance/synthesis/conditions/spec_symbols.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/expression/expression_evaluation.hpp"
#include "balance/synthesis/conditions/geometric_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace balance::conditions {

using expression::Operation;

// Power laws of expressions in one number.

/// A quantity c · pᵉ with c independent of p, or one that is not proportional to any power of p.
struct PowerLaw {
  bool is_valid = true;
  double exponent = 0;
  double value = 0;  ///< current value; a zero does not change a sum
};

/// The algebra (foundation/expression/expression_evaluation.hpp) of power laws in one node of a graph. The node counts
/// as an independent number, whatever its operands are.
class PowerLawAlgebra {
 public:
  using Value = PowerLaw;

  /// @param base the node; if it is an input, the caller sets the exponent of that input instead
  explicit PowerLawAlgebra(const expression::ExpressionNode* base) : base_(base) {}

  PowerLaw constant(double value) const { return {true, 0, value}; }
  PowerLaw apply(const expression::ExpressionNode& node, const PowerLaw& a, const PowerLaw& b, const PowerLaw& c) const;

 private:
  const expression::ExpressionNode* base_;
};

namespace {

bool is_independent(const PowerLaw& x) { return x.is_valid && x.exponent == 0; }

/// For a sum, a choice or a comparison: valid if both powers are equal.
PowerLaw require_equal_powers(const PowerLaw& a, const PowerLaw& b) {
  return {a.is_valid && b.is_valid && a.exponent == b.exponent, a.exponent};
}

PowerLaw add_power_laws(const PowerLaw& a, const PowerLaw& b) {
  if (a.value == 0 && is_independent(a)) return b;
  if (b.value == 0 && is_independent(b)) return a;
  return require_equal_powers(a, b);
}

/// Valid if a does not depend on p: then no function of it does.
PowerLaw valid_if_independent(const PowerLaw& a) { return {is_independent(a), 0}; }

PowerLaw apply_function(const expression::ExpressionNode& node, const PowerLaw& a) {
  static const int sqrt_function = expression::find_unary_function("sqrt"),
                   abs_function = expression::find_unary_function("abs"),
                   sign_function = expression::find_unary_function("sign");
  if (node.function == sqrt_function) return {a.is_valid, a.exponent / 2};
  if (node.function == abs_function) return a;
  if (node.function == sign_function) return {a.is_valid, 0};
  return valid_if_independent(a);
}

PowerLaw apply_operation(const expression::ExpressionNode& node, const PowerLaw& a, const PowerLaw& b,
                         const PowerLaw& c) {
  switch (node.operation) {
    case Operation::constant:
    case Operation::input: break;
    case Operation::alias:
    case Operation::negate: return a;
    case Operation::add:
    case Operation::subtract: return add_power_laws(a, b);
    case Operation::multiply: return {a.is_valid && b.is_valid, a.exponent + b.exponent};
    case Operation::divide: return {a.is_valid && b.is_valid, a.exponent - b.exponent};
    case Operation::power: return {a.is_valid && is_independent(b), a.exponent * b.value};
    case Operation::minimum:
    case Operation::maximum: return require_equal_powers(a, b);
    case Operation::atan2:
    case Operation::less:
    case Operation::less_equal:
    case Operation::equal: return {require_equal_powers(a, b).is_valid, 0};
    case Operation::logical_and:
    case Operation::logical_or: return {is_independent(a) && is_independent(b), 0};
    case Operation::select: {
      const PowerLaw& chosen = a.value != 0 ? b : c;
      return {is_independent(a) && chosen.is_valid, chosen.exponent};
    }
    case Operation::function: return apply_function(node, a);
  }
  return {};
}

}  // namespace

PowerLaw PowerLawAlgebra::apply(const expression::ExpressionNode& node, const PowerLaw& a, const PowerLaw& b,
                                const PowerLaw& c) const {
  PowerLaw result = &node == base_ ? PowerLaw{true, 1} : apply_operation(node, a, b, c);
  result.value = expression::ScalarAlgebra<double>().apply(node, a.value, b.value, c.value);
  return result;
}

namespace {

/// The expression of a geometric number; for gravity, whose magnitude is the number, its nonzero components.
std::vector<Expression> expressions_of(const study::Recording& recording, const GeometricParameter& number) {
  const auto& mechanism = recording.mechanism;
  if (number.locations.front().kind != GeometricParameterLocation::Kind::gravity)
    return {geometric_value_at(mechanism, number.locations.front())};
  std::vector<Expression> components;
  for (const Expression& component : mechanism.gravity)
    if (component.value() != 0) components.push_back(component);
  return components;
}

/// How one geometric number depends on one parameter.
struct Dependence {
  bool power = true;  ///< proportional to a power of it, possibly the zeroth
  int exponent = 0;
};

/// @param components of the number, which must all follow the same power
Dependence find_dependence(const std::vector<Expression>& components, const std::vector<PowerLaw>& laws) {
  std::optional<double> exponent;
  for (const Expression& component : components) {
    const PowerLaw law = component.is_constant() ? PowerLaw{} : laws[static_cast<std::size_t>(component.node())];
    if (!law.is_valid || law.exponent != exponent.value_or(law.exponent)) return {false, 0};
    exponent = law.exponent;
  }
  const double rounded = std::round(exponent.value_or(0));
  return rounded == exponent.value_or(0) ? Dependence{true, static_cast<int>(rounded)} : Dependence{false, 0};
}

/// Dependences of all numbers on one parameter.
std::vector<Dependence> list_dependences(const study::Recording& recording, const Expression& parameter,
                                         const std::vector<std::vector<Expression>>& numbers) {
  const expression::ExpressionNode& base = recording.graph.nodes()[static_cast<std::size_t>(parameter.node())];
  std::vector<PowerLaw> inputs;
  for (const double value : recording.inputs) inputs.push_back({true, 0, value});
  if (base.operation == Operation::input) inputs[static_cast<std::size_t>(base.input)].exponent = 1;
  const std::vector<PowerLaw> laws = evaluate(recording.graph, inputs, PowerLawAlgebra(&base));
  std::vector<Dependence> result;
  for (const auto& components : numbers) result.push_back(find_dependence(components, laws));
  return result;
}

/// Parameters and exponents of a number that is their product times a small ratio.
using Powers = std::vector<std::pair<std::size_t, int>>;

class SymbolNamer {
 public:
  SymbolNamer(const Study& study, const study::Recording& recording)
      : length_(study.mechanism.units.length), numbers_(list_geometric_parameters(study.mechanism)) {
    std::vector<std::vector<Expression>> expressions;
    for (const GeometricParameter& number : numbers_) expressions.push_back(expressions_of(recording, number));
    for (const study::NamedExpression& p : recording.parameters) {
      if (p.value.value() == 0) continue;
      parameters_.push_back(p);
      dependences_.push_back(list_dependences(recording, p.value, expressions));
    }
  }

  std::vector<GeometricSymbol> symbols() {
    const std::size_t count = parameters_.size();
    std::vector<GeometricSymbol> governing(count);
    for (std::size_t p = 0; p < count; ++p) governing[p] = {parameters_[p].name, "1", parameters_[p].value.value(), {}};
    std::vector<std::pair<std::size_t, Powers>> factored_numbers;
    for (std::size_t n = 0; n < numbers_.size(); ++n) {
      if (numbers_[n].value == 0) continue;
      const Powers powers = find_powers(n);
      if (!powers.empty()) factored_numbers.emplace_back(n, powers);
    }
    for (const auto& [n, powers] : factored_numbers)
      if (powers.size() == 1 && powers[0].second == 1) assign_unit(governing[powers[0].first], numbers_[n]);
    std::set<std::size_t> explained;
    for (const auto& [n, powers] : factored_numbers) {
      if (!is_simple(n, powers, governing)) continue;
      explained.insert(n);
      for (const auto& [p, exponent] : powers) governing[p].uses.push_back({numbers_[n], exponent});
    }
    std::erase_if(governing, [](const GeometricSymbol& symbol) { return symbol.uses.empty(); });
    for (std::size_t n = 0; n < numbers_.size(); ++n)
      if (is_nontrivial(numbers_[n]) && explained.count(n) == 0) governing.push_back(standalone_symbol(numbers_[n]));
    return governing;
  }

 private:
  /// Powers of plain parameters if these explain the number completely; else of one expression to which it is
  /// proportional.
  Powers find_powers(std::size_t n) const {
    Powers plain, expressions;
    bool complete = true;
    for (std::size_t p = 0; p < parameters_.size(); ++p) {
      const Dependence& d = dependences_[p][n];
      const bool is_plain = parameters_[p].is_plain;
      if (!d.power && is_plain) complete = false;
      if (!d.power || d.exponent == 0) continue;
      if (is_plain) plain.emplace_back(p, d.exponent);
      if (!is_plain && d.exponent == 1 && expressions.empty()) expressions.emplace_back(p, 1);
    }
    const double unit = numbers_[n].unit == "m" ? length_ : 1;
    const auto explains = [&](const Powers& powers) {
      double product = unit;
      for (const auto& [p, e] : powers) product *= elementary::pow(parameters_[p].value.value(), e);
      return !powers.empty() && find_small_ratio(numbers_[n].value / product).has_value();
    };
    if (complete && explains(plain)) return plain;
    return explains(expressions) ? expressions : Powers{};
  }

  /// Converts a parameter that is a length to SI.
  void assign_unit(GeometricSymbol& symbol, const GeometricParameter& number) const {
    if (symbol.unit != "1") return;
    symbol.unit = number.unit;
    if (number.unit == "m") symbol.value *= length_;
  }

  /// Whether a number is a small ratio of its symbols in SI, too.
  bool is_simple(std::size_t n, const Powers& powers, const std::vector<GeometricSymbol>& symbols) const {
    double product = 1;
    for (const auto& [p, e] : powers) product *= elementary::pow(symbols[p].value, e);
    return find_small_ratio(numbers_[n].value / product).has_value();
  }

  /// Ratios of ±1 are left out, which is easier to read.
  static bool is_nontrivial(const GeometricParameter& number) {
    return number.value != 0 && !(number.unit == "1" && std::abs(number.value) == 1);
  }

  GeometricSymbol standalone_symbol(const GeometricParameter& number) const {
    const auto has_same_label = [&](const study::NamedExpression& p) { return p.name == number.label; };
    const auto& all = parameters_;
    const bool is_ambiguous = std::any_of(all.begin(), all.end(), has_same_label);
    return {is_ambiguous ? "gravity" : number.label, number.unit, number.value, {{number, 1}}};
  }

  double length_;                                   ///< the spec's unit of length [m]
  std::vector<study::NamedExpression> parameters_;  ///< all nonzero
  std::vector<GeometricParameter> numbers_;
  std::vector<std::vector<Dependence>> dependences_;  ///< per parameter
};

}  // namespace

std::vector<GeometricSymbol> list_symbols(const DesignSpace& space) {
  return space.recording ? SymbolNamer(space.start, *space.recording).symbols()
                         : list_geometric_symbols(space.start.mechanism);
}

}  // namespace balance::conditions
