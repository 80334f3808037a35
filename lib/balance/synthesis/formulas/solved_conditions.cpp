#include "balance/synthesis/formulas/solved_conditions.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/dynamic_parameters.hpp"
#include "balance/mechanics/model/validation.hpp"
#include "balance/synthesis/conditions/geometric_parameters.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/formulas/parameter_sampler.hpp"
#include "balance/synthesis/formulas/symbolic_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace balance::formulas {

namespace {

/// "bodies.link1.com[0]" belongs to "bodies.link1.com".
std::string path_of_vector(const std::string& path) { return path.substr(0, path.find('[')); }

bool is_path_named(const std::string& path, const std::string& name) {
  const auto without_section = [](const std::string& one) { return one.substr(one.find('.') + 1); };
  const std::string vector = path_of_vector(path);
  return name == path || name == vector || name == without_section(path) || name == without_section(vector);
}

/// The symbol that a polynomial is, up to its sign and unit; −1 if it is none.
int single_symbol(const Polynomial& p) {
  if (p.size() != 1 || p.terms()[0].wave != 0 || p.terms()[0].monomial.size() != 1) return -1;
  return p.terms()[0].monomial.exponent(0) == 1 ? p.terms()[0].monomial.symbol(0) : -1;
}

class UnknownFinder {
 public:
  UnknownFinder(const Mechanism& mechanism, const study::SpecNumberTexts& texts)
      : texts_(texts),
        tree_(build_symbolic_tree(ring_, mechanism, texts)),
        is_planar_(mechanism.space == SpaceKind::planar) {}

  std::vector<UnknownNumber> find(const std::string& name) const {
    for (const study::ParameterText& parameter : texts_.parameters)
      if (parameter.name == name || identifier_name(parameter.name) == name) return {{name, parameter.name, ""}};
    std::vector<UnknownNumber> found;
    for (const auto& [path, number] : tree_.numbers->numbers())
      if (is_path_named(path, name) && !(is_planar_ && path.ends_with("[2]"))) found.push_back({name, "", path});
    if (!found.empty()) return found;
    for (const auto& [path, number] : tree_.numbers->numbers())
      if (is_symbol_of(number, name)) return {{name, "", path}};
    throw std::invalid_argument(quote_for_message(name) + " is neither a parameter nor a number of the mechanism" +
                                append_nearest_name(name, list_names()));
  }

 private:
  /// The name of a number that is zero is the one that it would have, `lg3` or `xg3`.
  bool is_symbol_of(const SpecNumber& number, const std::string& name) const {
    if (const int symbol = single_symbol(number.value); symbol >= 0) return ring_.symbol(symbol).name == name;
    return number.value.is_zero() &&
           (number.name == name || (name.starts_with("lg") && number.name == "xg" + name.substr(2)));
  }

  std::vector<std::string> list_names() const {
    std::vector<std::string> names;
    for (const Symbol& symbol : ring_.symbols()) names.push_back(symbol.name);
    for (const auto& [path, number] : tree_.numbers->numbers()) names.push_back(path);
    return names;
  }

  const study::SpecNumberTexts& texts_;
  Ring ring_;
  SymbolicTree tree_;
  bool is_planar_;
};

int find_symbol(const SymbolicTree& tree, const UnknownNumber& unknown) {
  const auto& parameters = tree.model->parameters();
  for (std::size_t k = 0; k < parameters.size(); ++k)
    if (parameters[k].name == unknown.parameter) return static_cast<int>(k);  // they are the ring's first symbols
  const auto number = tree.numbers->numbers().find(unknown.path);
  const int symbol = number == tree.numbers->numbers().end() ? -1 : single_symbol(number->second.value);
  if (symbol < 0) throw FormulaError(unknown.name + " has no symbol of its own in these formulas");
  return symbol;
}

SheetFormula make_formula(std::string name, std::string indices, const RationalFunction& value) {
  if (const auto polynomial = as_polynomial(value)) return {std::move(name), std::move(indices), *polynomial};
  return {std::move(name), std::move(indices), value.numerator, value.denominator, ""};
}

}  // namespace

std::vector<UnknownNumber> find_unknown_numbers(const Mechanism& mechanism, const study::SpecNumberTexts& texts,
                                                const std::vector<std::string>& names) {
  const UnknownFinder finder(mechanism, texts);
  std::vector<UnknownNumber> unknowns;
  for (const std::string& name : names)
    for (UnknownNumber& one : finder.find(name)) {
      const bool is_new = std::none_of(unknowns.begin(), unknowns.end(), [&](const UnknownNumber& other) {
        return other.parameter == one.parameter && other.path == one.path;
      });
      if (is_new) unknowns.push_back(std::move(one));
    }
  return unknowns;
}

std::vector<std::string> list_inertial_paths(const Mechanism& mechanism, const study::SpecNumberTexts& texts) {
  Ring ring;
  const SymbolicTree tree = build_symbolic_tree(ring, mechanism, texts);
  std::vector<std::string> paths;
  for (const auto& [path, number] : tree.numbers->numbers()) {
    const int symbol = single_symbol(number.value);
    if (symbol < static_cast<int>(tree.model->parameters().size()) || !ring.symbol(symbol).source.is_constant())
      continue;
    const SymbolKind kind = ring.symbol(symbol).kind;
    if (is_inertial(kind) || kind == SymbolKind::com_coordinate) paths.push_back(path);
  }
  return paths;
}

namespace {

/// A number that depends on an unknown other than by a polynomial is a symbol, which must not be taken for a constant.
void check_dependences(const Ring& ring, const ParametricModel& model, const std::vector<int>& unknowns,
                       const std::vector<Polynomial>& conditions) {
  const std::vector<double> before = model.evaluate_nodes(model.inputs());
  for (const int unknown : unknowns) {
    const int input = model.input_of(ring.symbol(unknown).source).index;
    if (input < 0) continue;
    std::vector<double> inputs = model.inputs();
    double& changed = inputs[static_cast<std::size_t>(input)];
    changed = changed == 0 ? 0.1 : 1.1 * changed;
    const std::vector<double> after = model.evaluate_nodes(inputs);
    for (int s = 0; s < static_cast<int>(ring.symbols().size()); ++s) {
      const Symbol& symbol = ring.symbol(s);
      if (std::find(unknowns.begin(), unknowns.end(), s) != unknowns.end() || symbol.source.is_constant() ||
          ParametricModel::node_value(symbol.source, before) == ParametricModel::node_value(symbol.source, after))
        continue;
      for (const Polynomial& condition : conditions)
        for (const Term& term : condition.terms())
          if (term.monomial.exponent_of(s) != 0)
            throw FormulaError("the conditions cannot be solved for " + ring.symbol(unknown).name + ": " + symbol.name +
                               ", which they contain, is a function of it that is no polynomial");
    }
  }
}

}  // namespace

SolvedConditions solve_balance_conditions(Ring& ring, const Mechanism& mechanism, const SymbolicEquations& equations,
                                          const SolveRequest& request) {
  SolvedConditions solved{request.goals, request.unknowns, {}, {}, {}, {}, request.derive};
  for (const UnknownNumber& unknown : request.unknowns) solved.symbols.push_back(find_symbol(equations.tree, unknown));
  std::vector<Polynomial> conditions;
  if (request.conditions) {
    ConvertedConditions converted = convert_conditions(ring, equations.tree, *request.conditions, request.names);
    conditions = std::move(converted.conditions);
    solved.unnamed = std::move(converted.unnamed);
    solved.rank = request.conditions->rank;
  } else {
    if (!has_symbolic_conditions(mechanism, request.goals))
      throw std::invalid_argument("the conditions of this mechanism must be given");
    conditions = derive_symbolic_conditions(equations, request.goals);
  }
  check_dependences(ring, *equations.tree.model, solved.symbols, conditions);
  solved.solution = solve_conditions(conditions, solved.symbols);
  return solved;
}

SheetSection make_solution_section(const Ring& ring, const SolvedConditions& solved) {
  std::string names;
  for (const int symbol : solved.symbols) names += (names.empty() ? "" : ", ") + ring.symbol(symbol).name;
  SheetSection section{SheetSectionKind::solutions,
                       "Conditions for the goal " + study::join_goal_names(solved.goals) + ", solved for " + names,
                       {},
                       {},
                       0};
  for (const SolvedUnknown& one : solved.solution.solved) {
    section.formulas.push_back(make_formula(ring.symbol(one.symbol).name, "", one.value));
    section.terms += one.value.numerator.size() + one.value.denominator.size() - 1;
  }
  for (const Polynomial& condition : solved.solution.remaining) section.add({"", "", condition});
  return section;
}

namespace {

/// The balanced mechanism's M, D and z.
class BalancedEquations {
 public:
  BalancedEquations(const SymbolicEquations& equations, const SolvedConditions& solved)
      : solved_(solved), n_(equations.M.size()) {
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t j = i; j < n_; ++j) add(inertia_, {i, j}, equations.M[i][j]);
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t k = j; k < n_; ++k) add(others_, {i, j, k}, equations.D[i][j][k]);
    for (std::size_t i = 0; i < n_; ++i) add(others_, {i}, equations.z[i]);
  }

  SheetSection make_section() {
    const bool is_decoupled = has_constant_inertias();
    SheetSection section{SheetSectionKind::balanced,
                         is_decoupled ? "With these numbers, the torque of coordinate i is k_i times its acceleration"
                                      : "The equations of motion with these numbers",
                         {},
                         {},
                         0};
    for (const std::vector<Entry>* list : {&inertia_, &others_})
      for (const Entry& entry : *list) {
        section.terms += entry.value.numerator.size();
        if (is_decoupled && entry.value.is_zero()) continue;
        SheetFormula formula =
            make_factored_formula(is_decoupled ? "k" : "D", index_text(entry.indices, n_), entry.value);
        if (is_decoupled) formula.indices = std::to_string(entry.indices[0] + 1);
        if (entry.value.is_zero())
          section.zero.push_back(formula.label());
        else
          section.formulas.push_back(std::move(formula));
      }
    return section;
  }

 private:
  struct Entry {
    std::vector<std::size_t> indices;
    RationalFunction value;
  };

  void add(std::vector<Entry>& list, std::vector<std::size_t> indices, const Polynomial& p) {
    RationalFunction value(p);
    for (const SolvedUnknown& one : solved_.solution.solved) value = substitute(value, one.symbol, one.value);
    list.push_back({std::move(indices), std::move(value)});
  }

  /// As a product, if a solved number's numerator is one of two factors: k = (J3 + J6)/J7 (J3 + J6 + J7).
  SheetFormula make_factored_formula(std::string name, std::string indices, const RationalFunction& value) const {
    if (value.is_zero() || value.denominator.size() != 1 || group_by_trigonometric(value.numerator).size() > 1)
      return make_formula(std::move(name), std::move(indices), value);
    for (const SolvedUnknown& one : solved_.solution.solved) {
      if (one.value.numerator.size() < 2) continue;
      const Polynomial first =
          with_coprime_coefficients(multiplied_by(one.value.numerator, common_monomial(one.value.numerator).inverse()));
      const auto second = first.size() < 2 ? std::nullopt : divide_exactly(value.numerator, first);
      if (!second || second->size() < 2 || second->size() + first.size() > value.numerator.size()) continue;
      Monomial denominator = value.denominator.terms()[0].monomial;
      FormulaProduct product{take_divisors(first, denominator), 1, take_divisors(*second, denominator)};
      product.denominator = multiplied_by(value.denominator, denominator / value.denominator.terms()[0].monomial);
      return {std::move(name), std::move(indices), {}, 1, "", {std::move(product)}};
    }
    return make_formula(std::move(name), std::move(indices), value);
  }

  /// Divides a sum by the powers of symbols that most of its terms contain, and the denominator, too.
  static Polynomial take_divisors(const Polynomial& sum, Monomial& denominator) {
    Monomial taken;
    for (int k = 0; k < denominator.size(); ++k)
      if (2 * derivative_by_symbol(sum, denominator.symbol(k)).size() >= sum.size())
        taken.append(denominator.symbol(k), std::min(denominator.exponent(k), degree_in(sum, denominator.symbol(k))));
    denominator = denominator / taken;
    return multiplied_by(sum, taken.inverse());
  }

  bool has_constant_inertias() const {
    const auto is_zero = [](const Entry& entry) { return entry.value.is_zero(); };
    const auto is_constant = [](const Entry& entry) {
      const auto& terms = entry.value.numerator.terms();
      return std::all_of(terms.begin(), terms.end(), [&](const Term& term) {
        const Ring* ring = entry.value.numerator.ring();
        return term.wave == 0 &&
               term.monomial.select([&](int s, int) { return ring->symbol(s).kind == SymbolKind::slide; }).is_one();
      });
    };
    return std::all_of(others_.begin(), others_.end(), is_zero) &&
           std::all_of(inertia_.begin(), inertia_.end(), [&](const Entry& entry) {
             return entry.indices[0] == entry.indices[1] ? is_constant(entry) : is_zero(entry);
           });
  }

  const SolvedConditions& solved_;
  std::size_t n_;
  std::vector<Entry> inertia_, others_;
};

}  // namespace

SheetSection make_balanced_section(const SymbolicEquations& equations, const SolvedConditions& solved) {
  return BalancedEquations(equations, solved).make_section();
}

namespace {

/// Residuals of conditions are relative to their terms.
constexpr double solution_tolerance = 1e-9;
constexpr int solution_state_count = 2, max_newton_steps = 60;
constexpr double relative_difference = 1e-6;
/// Of a number, compared with the spec's: smaller ones have vanished to meet the conditions that remain.
constexpr double min_relative_size = 1e-3;

class SolutionComparison {
 public:
  SolutionComparison(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                     const Mechanism& mechanism, std::uint64_t seed)
      : sheet_(sheet),
        solved_(*sheet.solution),
        texts_(texts),
        model_(*sheet.equations.tree.model),
        sampler_(*sheet.ring, model_),
        random_(seed),
        is_fixed_(model_.inputs().size(), false) {
    for (const int symbol : solved_.symbols) unknowns_.push_back(model_.input_of(sheet.ring->symbol(symbol).source));
    for (std::size_t s = 0; s < sheet.sections.size(); ++s)
      if (sheet.sections[s].section == SheetSectionKind::solutions) section_ = s;
    mechanism_ = mechanism;
    if (!solved_.unnamed.empty()) fix_geometry();
  }

  void run(FormulaCheck& check) {
    for (const SolvedUnknown& one : solved_.solution.solved)
      if (unknowns_[index_of(one.symbol)].index < 0)
        return note(check, "the solution was not compared with the engine: its numbers cannot be set one by one");
    compare_states(check);
    if (check.solution_states == 0 && !has_fixed_geometry_) {
      // other lengths do not close the loops, or not in the special way of the spec's
      fix_geometry();
      compare_states(check);
    }
    if (check.solution_states == 0)
      note(check,
           "the solution was not compared with the engine: no other numbers were found that meet what remains and "
           "can be assembled");
    else if (has_fixed_geometry_)
      note(check, "the solution was compared with the engine at other masses, but only at the lengths of the spec");
  }

 private:
  void compare_states(FormulaCheck& check) {
    for (int draws = 0; check.solution_states < solution_state_count && draws < ParameterSampler::max_draws; ++draws) {
      std::vector<double> inputs = sampler_.draw(random_, draws);
      for (std::size_t i = 0; i < inputs.size(); ++i)
        if (is_fixed_[i]) inputs[i] = model_.inputs()[i];
      if (!meet_remaining(inputs) || is_degenerate(inputs) || !set_solved(inputs)) continue;
      compare(model_.build_mechanism(model_.evaluate_nodes(inputs)), check);
    }
  }

  void compare(const Mechanism& mechanism, FormulaCheck& check) {
    const Conditions conditions = solved_.derive(mechanism);
    if (conditions.status != ConditionsStatus::done) return;
    // relations between lengths that other lengths do not meet
    if (solved_.rank && *solved_.rank != conditions.rank) return;
    const VectorX residuals = scaled_residuals(conditions, dynamics::parameter_values(mechanism));
    const double error = residuals.size() == 0 ? 0 : numerics::max_abs(residuals);
    check.solution_error = std::isnan(error) ? error : std::max(check.solution_error, error);
    ++check.solution_states;
  }

  std::size_t index_of(int symbol) const {
    return static_cast<std::size_t>(std::find(solved_.symbols.begin(), solved_.symbols.end(), symbol) -
                                    solved_.symbols.begin());
  }

  /// Keeps the numbers that change lengths and ratios, as far as they are not solved for.
  void fix_geometry() {
    const auto numbers = conditions::list_geometric_parameters(mechanism_);
    const auto values_at = [&](const std::vector<double>& inputs) {
      const Mechanism other = model_.build_mechanism(model_.evaluate_nodes(inputs));
      std::vector<double> values;
      for (const auto& number : numbers) values.push_back(conditions::geometric_value(other, number));
      return values;
    };
    const std::vector<double> before = values_at(model_.inputs());
    for (std::size_t i = 0; i < is_fixed_.size(); ++i) {
      std::vector<double> inputs = model_.inputs();
      inputs[i] = inputs[i] == 0 ? 0.1 : 1.1 * inputs[i];
      is_fixed_[i] = values_at(inputs) != before;
    }
    has_fixed_geometry_ = true;
  }

  /// Moves the numbers to where the remaining conditions vanish, by Gauss and Newton with the least relative change.
  bool meet_remaining(std::vector<double>& inputs) {
    const std::vector<Polynomial>& remaining = solved_.solution.remaining;
    if (remaining.empty()) return true;
    const std::vector<double> start = inputs;
    const VectorX unit =
        remaining_at(start).size.cwiseMax(1e-300);  // of the residuals; sums of equal signs have no zero
    for (int step = 0; step < max_newton_steps; ++step) {
      const RemainingValues values = remaining_at(inputs);
      if (!values.sum.allFinite()) return false;
      if (values.is_zero(1e-15)) return true;
      MatrixX jacobian(unit.size(), static_cast<Eigen::Index>(inputs.size()));
      std::vector<double> scales;
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        const bool is_solved =
            std::any_of(unknowns_.begin(), unknowns_.end(),
                        [i](const ParametricModel::SignedInput& one) { return one.index == static_cast<int>(i); });
        scales.push_back(is_fixed_[i] && !is_solved ? 0 : std::max(std::abs(start[i]), 1e-3));
        std::vector<double> changed = inputs;
        changed[i] += relative_difference * scales.back();
        jacobian.col(static_cast<Eigen::Index>(i)) =
            (remaining_at(changed).sum - values.sum).cwiseQuotient(unit) / relative_difference;
      }
      numerics::CompleteOrthogonalDecomposition solver;
      solver.setThreshold(1e-8);
      solver.compute(jacobian);
      const VectorX change = solver.solve(values.sum.cwiseQuotient(unit).eval());
      for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i] -= scales[i] * change[static_cast<Eigen::Index>(i)];
    }
    return remaining_at(inputs).is_zero(1e-12);
  }

  /// Whether a number that is not zero in the spec has vanished: without its masses, a mechanism meets anything.
  bool is_degenerate(const std::vector<double>& inputs) const {
    for (std::size_t i = 0; i < inputs.size(); ++i)
      if (std::abs(inputs[i]) < min_relative_size * std::abs(model_.inputs()[i])) return true;
    return false;
  }

  /// The conditions that remain, and the sums of their terms' magnitudes.
  struct RemainingValues {
    VectorX sum, size;
    bool is_zero(double tolerance) const { return (sum.cwiseAbs().array() <= tolerance * size.array()).all(); }
  };
  RemainingValues remaining_at(const std::vector<double>& inputs) const {
    const ScopedSymbolValues values(*sheet_.ring, model_.evaluate_nodes(inputs));
    const std::vector<Polynomial>& remaining = solved_.solution.remaining;
    const auto count = static_cast<Eigen::Index>(remaining.size());
    RemainingValues found{VectorX::Zero(count), VectorX::Zero(count)};
    for (std::size_t r = 0; r < remaining.size(); ++r)
      for (const Term& term : remaining[r].terms()) {
        const double value = evaluate_polynomial(Polynomial::of_terms(sheet_.ring.get(), {term}));
        found.sum[static_cast<Eigen::Index>(r)] += value;
        found.size[static_cast<Eigen::Index>(r)] += std::abs(value);
      }
    return found;
  }

  /// @return false if a denominator vanishes
  bool set_solved(std::vector<double>& inputs) const {
    const ScopedSymbolValues values(*sheet_.ring, model_.evaluate_nodes(inputs));
    std::map<std::string, double> names;
    for (const Symbol& symbol : sheet_.ring->symbols()) names[symbol.name] = symbol.value;
    for (std::size_t k = 0; k < solved_.solution.solved.size(); ++k) {
      const SolvedUnknown& one = solved_.solution.solved[k];
      const auto text = texts_.find(text_key(section_, k, SheetSectionKind::solutions, ""));
      const double value = text != texts_.end()
                               ? evaluate_text(text->second, names)
                               : evaluate_polynomial(one.value.numerator) / evaluate_polynomial(one.value.denominator);
      if (!std::isfinite(value)) return false;
      const ParametricModel::SignedInput& input = unknowns_[index_of(one.symbol)];
      inputs[static_cast<std::size_t>(input.index)] = input.sign * value;
    }
    return true;
  }

  static void note(FormulaCheck& check, const std::string& text) {
    check.note += (check.note.empty() ? "" : "; ") + text;
  }

  const FormulaSheet& sheet_;
  const SolvedConditions& solved_;
  const std::map<std::string, std::string>& texts_;
  const ParametricModel& model_;
  const ParameterSampler sampler_;
  Mechanism mechanism_;
  std::size_t section_ = std::numeric_limits<std::size_t>::max();  ///< of the solution, if it is printed
  std::mt19937_64 random_;
  std::vector<ParametricModel::SignedInput> unknowns_;
  std::vector<bool> is_fixed_;  ///< per input: it keeps the spec's value
  bool has_fixed_geometry_ = false;
};

}  // namespace

void check_solution(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                    const Mechanism& mechanism, std::uint64_t seed, FormulaCheck& check) {
  if (!sheet.solution || sheet.solution->solution.solved.empty()) return;
  SolutionComparison(sheet, texts, mechanism, seed).run(check);
  if (check.solution_error < solution_tolerance) return;
  check.is_consistent = false;
  check.reason = "the solution does not meet the engine's conditions";
}

}  // namespace balance::formulas
