#include "balance/synthesis/formulas/reduced_equations.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

namespace balance::formulas {

namespace {

/// Longer entries of the tree's equations are referred to by name.
constexpr std::size_t max_inline_terms = 4;

class ReducedSection {
 public:
  ReducedSection(Ring& ring, const SymbolicEquations& equations, ClosureElimination& elimination, bool has_rates)
      : ring_(ring),
        e_(equations),
        elimination_(elimination),
        has_rates_(has_rates),
        n_(equations.tree.columns.size()),
        d_(elimination.independent().size()) {}

  SheetSection make() {
    section_.section = SheetSectionKind::reduced;
    section_.heading = "Torques of " + independent_names(e_, elimination_.independent()) +
                       " that move the mechanism: that of the i-th has Mhat_ij times the acceleration of the j-th, "
                       "Dhat_ijk times the rates of the j-th and k-th, for both orders, and zhat_i";
    elimination_.derive_accelerations();
    for (std::size_t i = 0; i < d_; ++i)
      for (std::size_t j = i; j < d_; ++j) add_inertia(i, j);
    for (std::size_t i = 0; i < d_; ++i)
      for (std::size_t j = 0; j < d_; ++j)
        for (std::size_t k = j; k < d_; ++k) add_velocity(i, j, k);
    for (std::size_t i = 0; i < d_; ++i) {
      SheetFormula formula = begin("zhat", {i});
      for (std::size_t a = 0; a < n_; ++a) add(formula, elimination_.rate(a, i), e_.z[a], {a});
      finish(std::move(formula));
    }
    return assemble();
  }

 private:
  SheetFormula begin(const std::string& name, std::initializer_list<std::size_t> indices) const {
    return {name, index_text(indices, d_), {}};
  }

  /// Adds a multiple of an entry of the tree's equations.
  void add(SheetFormula& formula, const Polynomial& factor, const Polynomial& entry,
           std::initializer_list<std::size_t> indices) {
    if (factor.is_zero() || entry.is_zero()) return;
    const Polynomial named = entry.size() <= max_inline_terms ? entry : name_entry(entry, indices);
    if (factor == Polynomial(1))
      formula.value += named;
    else if (named.size() == 1)
      formula.value += factor * named;
    else
      add_product(formula.products, factor, named);
  }

  /// Products of the same entry, or of a multiple of it, become one.
  static void add_product(std::vector<FormulaProduct>& products, const Polynomial& factor, const Polynomial& entry) {
    for (FormulaProduct& product : products) {
      if (product.factor.size() != entry.size()) continue;
      const Polynomial ratio(entry.terms()[0].coefficient / product.factor.terms()[0].coefficient);
      if (!(ratio * product.factor == entry)) continue;
      product.numerator += ratio * factor;
      return;
    }
    const bool is_negative = entry.terms()[0].coefficient.sign() < 0;
    products.push_back({is_negative ? -factor : factor, 1, is_negative ? -entry : entry});
  }

  Polynomial name_entry(const Polynomial& entry, std::initializer_list<std::size_t> indices) {
    const std::string text = index_text(indices, n_);
    const auto [known, is_new] = entries_.try_emplace(text, Polynomial());
    if (!is_new) return known->second;
    definitions_.push_back(define_formula(ring_, "D", text, entry));
    return known->second = Polynomial::of_symbol(ring_, definitions_.back().symbol);
  }

  void add_inertia(std::size_t i, std::size_t j) {
    SheetFormula formula = begin("Mhat", {i, j});
    const auto C = [&](std::size_t a, std::size_t u) -> const Polynomial& { return elimination_.rate(a, u); };
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = a; b < n_; ++b) {
        Polynomial factor = C(a, i) * C(b, j);
        if (b > a) factor += C(b, i) * C(a, j);
        add(formula, factor, e_.M[a][b], {a, b});
      }
    finish(std::move(formula));
  }

  void add_velocity(std::size_t i, std::size_t j, std::size_t k) {
    SheetFormula formula = begin("Dhat", {i, j, k});
    const auto C = [&](std::size_t a, std::size_t u) -> const Polynomial& { return elimination_.rate(a, u); };
    const auto c = [&](std::size_t a) -> const Polynomial& { return elimination_.acceleration(a, j, k); };
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = 0; b < n_; ++b)
        for (std::size_t m = b; m < n_; ++m) {
          if (C(a, i).is_zero() || e_.D[a][b][m].is_zero()) continue;
          Polynomial factor = C(b, j) * C(m, k);
          if (m > b) factor += C(m, j) * C(b, k);
          add(formula, C(a, i) * factor, e_.D[a][b][m], {a, b, m});
        }
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = a; b < n_; ++b) {
        if (e_.M[a][b].is_zero()) continue;
        Polynomial factor = C(a, i) * c(b);
        if (b > a) factor += C(b, i) * c(a);
        add(formula, factor, e_.M[a][b], {a, b});
      }
    finish(std::move(formula));
  }

  void finish(SheetFormula formula) {
    std::erase_if(formula.products, [](const FormulaProduct& product) { return product.numerator.is_zero(); });
    formulas_.push_back(std::move(formula));
  }

  SheetSection assemble() {
    for (const SheetFormula& step : elimination_.rate_steps()) {
      section_.terms += has_rates_ ? step.value.size() : 0;
      if (!has_rates_) section_.add(step);
    }
    for (const SheetFormula& step : elimination_.acceleration_steps()) section_.add(step);
    for (SheetFormula& definition : definitions_) section_.add(std::move(definition));
    for (SheetFormula& formula : formulas_) section_.add(std::move(formula));
    return std::move(section_);
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  ClosureElimination& elimination_;
  bool has_rates_;
  std::size_t n_, d_;
  std::map<std::string, Polynomial> entries_;  ///< symbols, by the indices of D
  std::vector<SheetFormula> definitions_, formulas_;
  SheetSection section_;
};

}  // namespace

SheetSection make_reduced_section(Ring& ring, const SymbolicEquations& equations, ClosureElimination& elimination,
                                  bool has_rates) {
  return ReducedSection(ring, equations, elimination, has_rates).make();
}

std::size_t estimate_reduced_terms(const SymbolicEquations& e, std::size_t independent) {
  const TermCount count = count_terms(e);
  const std::size_t pairs = independent * (independent + 1) / 2;
  std::size_t entries = 0;  // of M and D, each of which is in every formula
  for (std::size_t a = 0; a < e.M.size(); ++a)
    for (std::size_t b = 0; b < e.M.size(); ++b) {
      if (b >= a) entries += e.M[a][b].is_zero() ? 0 : 1;
      for (std::size_t c = b; c < e.M.size(); ++c) entries += e.D[a][b][c].is_zero() ? 0 : 1;
    }
  return count.A * pairs + entries * pairs * (1 + independent);
}

std::string independent_names(const SymbolicEquations& e, const std::vector<int>& independent) {
  std::vector<std::string> names;
  for (const int column : independent) names.push_back(e.tree.columns[static_cast<std::size_t>(column)]);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace balance::formulas
