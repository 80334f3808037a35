#include "balance/synthesis/formulas/symbolic_conditions.hpp"

#include "balance/mechanics/model/topology.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace balance::formulas {

namespace {

/// Longer lists are not searched for combinations, since the search takes quadratic time.
constexpr std::size_t max_compared_rows = 300;

/// Equations with more terms have no readable conditions.
constexpr std::size_t max_condition_terms = 6000;

/// The powers of lengths and gravity that all terms share. Coordinates of slides are functions of the pose instead.
Monomial common_lengths(const Polynomial& p) {
  Monomial common = p.terms()[0].monomial.select([&](int s, int) {
    const auto kind = p.ring()->symbol(s).kind;
    return kind == SymbolKind::length || kind == SymbolKind::gravity;
  });
  for (const Term& term : p.terms()) {
    Monomial shared;
    for (int k = 0; k < common.size(); ++k)
      shared.append(common.symbol(k), std::min(common.exponent(k), term.monomial.exponent_of(common.symbol(k))));
    common = shared;
  }
  return common;
}

/// Coefficients of all functions of the pose: waves times powers of slides' coordinates.
std::vector<Polynomial> coefficients(const Polynomial& p) {
  std::map<std::pair<TrigonometricId, Monomial>, std::vector<Term>> groups;
  for (const Term& term : p.terms()) {
    const auto is_pose = [&](int s) {
      const auto kind = p.ring()->symbol(s).kind;
      return kind == SymbolKind::slide || kind == SymbolKind::alias;
    };
    const Monomial pose = term.monomial.select([&](int s, int) { return is_pose(s); });
    groups[{term.wave, pose}].push_back({term.monomial / pose, 0, term.coefficient});
  }
  std::vector<Polynomial> list;
  for (auto& [key, terms] : groups) list.push_back(Polynomial::of_terms(p.ring(), std::move(terms)));
  return list;
}

/// Subtracts a multiple of a known row, if that makes the row shorter.
bool reduce_by_row(Polynomial& row, const Polynomial& pivot_row) {
  const Term& leading_term = pivot_row.terms()[0];
  for (const Term& term : row.terms()) {
    const Monomial ratio = term.monomial / leading_term.monomial;
    bool is_divisible = true;
    for (int k = 0; k < ratio.size(); ++k) is_divisible = is_divisible && ratio.exponent(k) > 0;
    if (!is_divisible) continue;
    const Polynomial reduced =
        row - Polynomial::of_terms(row.ring(), {{ratio, 0, term.coefficient / leading_term.coefficient}}) * pivot_row;
    if (reduced.size() >= row.size()) continue;
    row = reduced;
    return true;
  }
  return false;
}

bool is_combination_of(Polynomial row, const std::vector<Polynomial>& independent_rows) {
  for (bool has_changed = true; has_changed && !row.is_zero();) {
    has_changed = false;
    for (const Polynomial& pivot_row : independent_rows)
      if (!row.is_zero() && reduce_by_row(row, pivot_row)) has_changed = true;
  }
  return row.is_zero();
}

}  // namespace

std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries) {
  std::vector<Polynomial> rows;
  for (const Polynomial& entry : entries)
    for (const Polynomial& p : coefficients(entry)) {
      const Monomial common = common_lengths(p);
      const Rational leading_coefficient = p.terms()[0].coefficient;
      std::vector<Term> terms;
      for (const Term& term : p.terms())
        terms.push_back({term.monomial / common, 0, term.coefficient / leading_coefficient});
      Polynomial row = Polynomial::of_terms(p.ring(), std::move(terms));
      if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(std::move(row));
    }
  std::stable_sort(rows.begin(), rows.end(), [](auto& a, auto& b) { return a.size() < b.size(); });
  if (rows.size() > max_compared_rows) return rows;
  std::vector<Polynomial> independent_rows;
  for (const Polynomial& row : rows)
    if (!is_combination_of(row, independent_rows)) independent_rows.push_back(row);
  return independent_rows;
}

/// Derivatives of Σ m r, whose rate is the linear momentum Σ ∂h/∂q q̇; at constant speeds its own rate is
/// Σ ∂²h/∂q∂q′ q̇ q̇′.
static std::vector<Polynomial> list_force_entries(const SymbolicEquations& e, const Goal& goal) {
  const auto n = static_cast<int>(e.M.size());
  std::vector<Polynomial> entries;
  for (std::size_t axis = 0; axis < e.moment.size(); ++axis) {
    if (goal.component >= 0 && goal.component != static_cast<int>(axis)) continue;
    for (int c = 0; c < n; ++c) {
      const Polynomial momentum = column_derivative(e.tree, e.moment[axis], c);
      if (!goal.is_at_constant_speed) entries.push_back(momentum);
      for (int d = 0; goal.is_at_constant_speed && d <= c; ++d)
        entries.push_back(column_derivative(e.tree, momentum, d));
    }
  }
  return entries;
}

/// What must vanish at every pose for a goal.
static std::vector<Polynomial> list_goal_entries(const SymbolicEquations& e, const Goal& goal) {
  if (goal.kind == GoalKind::force) return list_force_entries(e, goal);
  const std::size_t n = e.M.size();
  std::vector<Polynomial> entries = e.z;
  if (goal.kind == GoalKind::statics) return entries;
  for (const Matrix& rows : e.D)
    for (const Row& row : rows) entries.insert(entries.end(), row.begin(), row.end());
  if (goal.kind != GoalKind::decoupled) return entries;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) entries.push_back(e.M[i][j]);
  return entries;
}

std::vector<SheetSection> make_condition_sections(const SymbolicEquations& e) {
  std::vector<SheetSection> sections;
  for (const GoalKind kind : {GoalKind::statics, GoalKind::force, GoalKind::gyroscopic, GoalKind::decoupled}) {
    const std::vector<Polynomial> entries = list_goal_entries(e, {.kind = kind});
    SheetSection section{
        SheetSectionKind::conditions, "Conditions for the goal " + study::goal_name({kind, false}), {}, {}, 0};
    for (const Polynomial& entry : entries) section.terms += entry.size();
    section.is_too_long = section.terms > max_condition_terms;
    if (!section.is_too_long) section.terms = 0;
    for (Polynomial& row : section.is_too_long ? std::vector<Polynomial>() : extract_conditions(entries))
      section.add({"", "", std::move(row)});
    sections.push_back(std::move(section));
  }
  return sections;
}

bool is_open_chain(const Mechanism& mechanism) {
  const model::SpanningTree tree = model::build_spanning_tree(mechanism, {});
  const bool has_split =
      std::any_of(tree.edges.begin(), tree.edges.end(), [](const model::TreeEdge& edge) { return edge.split; });
  return tree.cut.empty() && !has_split && !has_velocity_constraints(mechanism);
}

bool has_symbolic_conditions(const Mechanism& mechanism, const std::vector<Goal>& goals) {
  const bool is_open = is_open_chain(mechanism);
  const bool has_known_terms =
      !mechanism.loads.empty() || !mechanism.friction.empty() || !mechanism.force_elements.empty();
  return is_open && !has_known_terms && std::all_of(goals.begin(), goals.end(), [&](const Goal& goal) {
           const bool is_actuated =
               mechanism.actuators.size() + mechanism.couplings.size() == mechanism.coordinates.size();
           using enum GoalKind;
           const bool is_derived = goal.kind == statics || goal.kind == gyroscopic ||
                                   goal.kind == gyroscopic_independent || goal.kind == decoupled;
           const bool is_uniform =
               !goal.is_at_constant_speed || (goal.coordinates.empty() && (is_actuated || mechanism.actuators.empty()));
           return !goal.is_fully && ((goal.kind == force && is_uniform) || (is_derived && is_actuated));
         });
}

std::vector<Polynomial> derive_symbolic_conditions(const SymbolicEquations& e, const std::vector<Goal>& goals) {
  std::vector<Polynomial> entries;
  std::size_t terms = 0;
  for (const Goal& goal : goals)
    for (Polynomial& entry : list_goal_entries(e, goal)) {
      terms += entry.size();
      entries.push_back(std::move(entry));
    }
  if (terms > max_condition_terms) throw FormulaError("the conditions are too long to be solved");
  return extract_conditions(entries);
}

namespace {

/// Converts conditions with named coefficients. Numbers without a name become symbols of their own.
class ConditionConverter {
 public:
  ConditionConverter(Ring& ring, const SymbolicTree& tree, const Conditions& conditions,
                     const conditions::ConditionNames& names)
      : ring_(ring), tree_(tree), numbers_(*tree.numbers), conditions_(conditions), names_(names) {}

  ConvertedConditions run() {
    ConvertedConditions converted;
    for (int row = 0; row < conditions_.rank; ++row) {
      Polynomial sum;
      for (std::size_t p = 0; p < conditions_.parameters.size(); ++p) {
        const double value = conditions_.matrix(row, static_cast<Eigen::Index>(p));
        if (value == 0) continue;
        const dynamics::Parameter& parameter = conditions_.parameters[p];
        if (conditions::is_known_term(parameter))
          throw FormulaError(
              "the conditions contain loads, friction, dampers or springs with a table, which have no symbols: "
              "--without excludes them");
        const Polynomial quantity = parameter_polynomial(parameter);
        if (!quantity.is_zero()) sum += coefficient(row, static_cast<int>(p), value) * quantity;
      }
      if (!sum.is_zero()) converted.conditions.push_back(std::move(sum));
    }
    for (const auto& [value, symbol] : unnamed_) converted.unnamed.push_back(symbol);
    return converted;
  }

 private:
  Polynomial coefficient(int row, int parameter, double value) {
    const conditions::CoefficientFormula* formula = names_.find(row, parameter);
    if (formula != nullptr && !formula->wave) {
      Polynomial product = monomial(formula->factor), sum;
      for (const conditions::RationalMonomial& term : formula->sum) sum += monomial(term);
      return formula->sum.empty() ? product : product * sum;
    }
    if (std::abs(std::abs(value) - 1) < unit_tolerance) return {value < 0 ? -1 : 1};
    const double size = std::abs(value);
    for (const auto& [known, symbol] : unnamed_)
      if (std::abs(known - size) < unit_tolerance * size) return signed_symbol(symbol, value);
    unnamed_.emplace_back(size,
                          ring_.add_symbol("c" + std::to_string(unnamed_.size() + 1), SymbolKind::dimensionless, size));
    return signed_symbol(unnamed_.back().second, value);
  }

  Polynomial signed_symbol(int symbol, double value) {
    const Polynomial p = Polynomial::of_symbol(ring_, symbol);
    return value < 0 ? -p : p;
  }

  Polynomial monomial(const conditions::RationalMonomial& m) {
    Polynomial product(Rational(m.numerator, m.denominator));
    for (const conditions::SymbolPower& power_of_symbol : m.powers)
      product = product * power(geometric_polynomial(power_of_symbol.symbol), power_of_symbol.exponent);
    return product;
  }

  const Polynomial& geometric_polynomial(int index) {
    const auto [entry, is_new] = geometric_.try_emplace(index);
    if (is_new) entry->second = find_geometric_polynomial(names_.symbols[static_cast<std::size_t>(index)]);
    return entry->second;
  }

  /// A parameter of the spec, in its units, or a number of the mechanism.
  Polynomial find_geometric_polynomial(const conditions::GeometricSymbol& symbol) {
    const auto& parameters = tree_.model->parameters();
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (parameters[k].name != symbol.label) continue;
      const int index = static_cast<int>(k);  // parameters are the ring's first symbols
      Rational unit = 1;
      if (!find_decimal(symbol.value / ring_.symbol(index).value, unit))
        throw FormulaError(symbol.label + " has a unit that is no decimal fraction");
      if (ring_.symbol(index).kind == SymbolKind::dimensionless && symbol.unit == "m")
        ring_.set_kind(index, SymbolKind::length);
      return Polynomial(unit) * numbers_.parameter(symbol.label);
    }
    for (const conditions::GeometricParameterLocation& location : symbol.uses.at(0).number.locations)
      if (const Polynomial number = location_polynomial(location); !number.is_zero()) return number;
    throw FormulaError(symbol.label + " has no symbol");
  }

  Polynomial location_polynomial(const conditions::GeometricParameterLocation& at) {
    using enum conditions::GeometricParameterLocation::Kind;
    const auto axis = static_cast<std::size_t>(at.axis), index = static_cast<std::size_t>(at.index),
               item = static_cast<std::size_t>(at.item);
    switch (at.kind) {
      case joint_first:
      case joint_second: return numbers_.joint_point(at.index, at.kind == joint_first)[axis];
      case spring_first:
      case spring_second: return numbers_.spring_point(index, at.kind == spring_first)[axis];
      case disc: return numbers_.disc_position(at.index)[axis];
      case disc_ratio: return numbers_.ratio(at.index);
      case disc_term_ratio: return numbers_.disc_term(at.index, item);
      case coupling_ratio: return numbers_.coupling_ratio(index);
      case coupling_term_ratio: return numbers_.coupling_term(index, item);
      case free_length: return numbers_.free_length(index);
      case tool: return numbers_.tool_point()[axis];
      case gravity: {
        const Polynomial g = numbers_.gravity()[axis];  // its magnitude is meant, which is a symbol if it has one part
        return g.size() == 1 && g.terms()[0].coefficient.sign() < 0 ? -g : g;
      }
      case joint_radius: return numbers_.joint_radius(at.index);
      case body_point: return point_of_body(at)[axis];
      case constraint_factor:
      case constraint_point:
      case load: return {};
    }
    return {};
  }

  Vector point_of_body(const conditions::GeometricParameterLocation& at) {
    const auto& body = tree_.model->mechanism().bodies[static_cast<std::size_t>(at.index)];
    return numbers_.body_point(at.index, body.points[static_cast<std::size_t>(at.item)].name);
  }

  const Mass& mass_of(const dynamics::Parameter& parameter) {
    const auto [entry, is_new] = masses_.try_emplace({parameter.owner_kind, parameter.index});
    if (!is_new) return entry->second;
    using enum dynamics::ParameterOwner;
    if (parameter.owner_kind == body) return entry->second = numbers_.body(parameter.index);
    if (parameter.owner_kind == attachment) return entry->second = numbers_.attachment(parameter.index);
    if (!numbers_.is_rotor(parameter.index)) return entry->second = numbers_.disc(parameter.index);
    const Vector3E& axis = tree_.model->mechanism().discs[static_cast<std::size_t>(parameter.index)].axis;
    for (int k = 0; k < 3; ++k)
      if (std::abs(axis[k].value()) == 1) return entry->second = numbers_.rotor(parameter.index, k);
    throw FormulaError("a disc's axis is oblique to the axes of its carrier");
  }

  Polynomial parameter_polynomial(const dynamics::Parameter& parameter) {
    if (parameter.owner_kind == dynamics::ParameterOwner::spring) {
      const auto index = static_cast<std::size_t>(parameter.index);
      return parameter.symbol == "preload" ? numbers_.preload(index) : numbers_.stiffness(index);
    }
    const Mass& mass = mass_of(parameter);
    static const std::map<std::string, std::pair<int, std::size_t>> entries{
        {"m", {0, 0}},   {"mx", {1, 0}},  {"my", {1, 1}},  {"mz", {1, 2}},  {"J", {2, 2}},  {"Ixx", {2, 0}},
        {"Iyy", {2, 1}}, {"Izz", {2, 2}}, {"Ixy", {2, 3}}, {"Ixz", {2, 4}}, {"Iyz", {2, 5}}};
    const auto [order, index] = entries.at(parameter.symbol);
    return order == 0 ? mass.mass : order == 1 ? mass.moment[index] : mass.inertia[index];
  }

  /// Coefficients that differ by less are the same number.
  static constexpr double unit_tolerance = 1e-9;

  Ring& ring_;
  const SymbolicTree& tree_;
  MechanismSymbols& numbers_;
  const Conditions& conditions_;
  const conditions::ConditionNames& names_;
  std::vector<std::pair<double, int>> unnamed_;  ///< magnitude, symbol
  std::map<int, Polynomial> geometric_;
  std::map<std::pair<dynamics::ParameterOwner, int>, Mass> masses_;
};

}  // namespace

ConvertedConditions convert_conditions(Ring& ring, const SymbolicTree& tree, const Conditions& conditions,
                                       const conditions::ConditionNames& names) {
  return ConditionConverter(ring, tree, conditions, names).run();
}

}  // namespace balance::formulas
