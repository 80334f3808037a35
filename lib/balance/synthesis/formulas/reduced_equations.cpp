#include "balance/synthesis/formulas/reduced_equations.hpp"

#include "balance/synthesis/formulas/formula_sheet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

namespace balance::formulas {

namespace {

/// Longer entries of the tree's equations are referred to by name.
constexpr std::size_t max_inline_terms = 4;

class ReducedDerivation {
 public:
  ReducedDerivation(Ring& ring, const SymbolicEquations& equations, ClosureElimination& elimination)
      : ring_(ring),
        e_(equations),
        elimination_(elimination),
        n_(equations.tree.columns.size()),
        d_(elimination.independent().size()) {}

  ReducedEquations derive() {
    copy_elimination();
    out_.M.assign(d_, Row(d_));
    out_.D.assign(d_, out_.M);
    for (std::size_t i = 0; i < d_; ++i)
      for (std::size_t j = i; j < d_; ++j) out_.M[i][j] = out_.M[j][i] = inertia(i, j);
    for (std::size_t i = 0; i < d_; ++i)
      for (std::size_t j = 0; j < d_; ++j)
        for (std::size_t k = j; k < d_; ++k) out_.D[i][j][k] = out_.D[i][k][j] = velocity(i, j, k);
    for (std::size_t i = 0; i < d_; ++i) {
      SheetFormula formula = begin("zhat", {i});
      for (std::size_t a = 0; a < n_; ++a) add(formula, out_.C[a][i], e_.z[a], {a});
      out_.z.push_back(finish(std::move(formula)));
    }
    return std::move(out_);
  }

 private:
  void copy_elimination() {
    elimination_.derive_accelerations();
    out_.independent = elimination_.independent();
    out_.poses = elimination_.poses();
    out_.rate_steps = elimination_.rate_steps();
    out_.acceleration_steps = elimination_.acceleration_steps();
    out_.C.assign(n_, Row(d_));
    out_.c.assign(n_, Matrix(d_, Row(d_)));
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t j = 0; j < d_; ++j) {
        out_.C[a][j] = elimination_.rate(a, j);
        for (std::size_t k = 0; k < d_; ++k) out_.c[a][j][k] = elimination_.acceleration(a, j, k);
      }
  }

  SheetFormula begin(const std::string& name, std::initializer_list<std::size_t> indices) const {
    return {name, index_text(indices, d_), {}};
  }

  /// Adds a multiple of an entry of the tree's equations.
  void add(SheetFormula& formula, const Polynomial& factor, const Polynomial& entry,
           std::initializer_list<std::size_t> indices) {
    if (factor.is_zero() || entry.is_zero()) return;
    add_multiple(formula, factor, entry.size() <= max_inline_terms ? entry : name_entry(entry, indices));
  }

  Polynomial name_entry(const Polynomial& entry, std::initializer_list<std::size_t> indices) {
    const std::string text = index_text(indices, n_);
    const auto [known, is_new] = entries_.try_emplace(text, Polynomial());
    if (!is_new) return known->second;
    out_.definitions.push_back(define_formula(ring_, "D", text, entry));
    return known->second = Polynomial::of_symbol(ring_, out_.definitions.back().symbol);
  }

  Polynomial inertia(std::size_t i, std::size_t j) {
    SheetFormula formula = begin("Mhat", {i, j});
    const Matrix& C = out_.C;
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = a; b < n_; ++b) {
        Polynomial factor = C[a][i] * C[b][j];
        if (b > a) factor += C[b][i] * C[a][j];
        add(formula, factor, e_.M[a][b], {a, b});
      }
    return finish(std::move(formula));
  }

  Polynomial velocity(std::size_t i, std::size_t j, std::size_t k) {
    SheetFormula formula = begin("Dhat", {i, j, k});
    const Matrix& C = out_.C;
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = 0; b < n_; ++b)
        for (std::size_t m = b; m < n_; ++m) {
          if (C[a][i].is_zero() || e_.D[a][b][m].is_zero()) continue;
          Polynomial factor = C[b][j] * C[m][k];
          if (m > b) factor += C[m][j] * C[b][k];
          add(formula, C[a][i] * factor, e_.D[a][b][m], {a, b, m});
        }
    for (std::size_t a = 0; a < n_; ++a)
      for (std::size_t b = a; b < n_; ++b) {
        if (e_.M[a][b].is_zero()) continue;
        Polynomial factor = C[a][i] * out_.c[b][j][k];
        if (b > a) factor += C[b][i] * out_.c[a][j][k];
        add(formula, factor, e_.M[a][b], {a, b});
      }
    return finish(std::move(formula));
  }

  Polynomial finish(SheetFormula formula) {
    const Polynomial value = name_sum(ring_, formula);
    out_.formulas.push_back(std::move(formula));
    return value;
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  ClosureElimination& elimination_;
  std::size_t n_, d_;
  std::map<std::string, Polynomial> entries_;  ///< symbols, by the indices of D
  ReducedEquations out_;
};

}  // namespace

ReducedEquations derive_reduced_equations(Ring& ring, const SymbolicEquations& equations,
                                          ClosureElimination& elimination) {
  return ReducedDerivation(ring, equations, elimination).derive();
}

SheetSection make_reduced_section(const SymbolicEquations& e, const ReducedEquations& reduced,
                                  std::optional<std::size_t> rates_section) {
  SheetSection section;
  section.section = SheetSectionKind::reduced;
  section.heading = "Torques of " + independent_names(e, reduced.independent) +
                    " that move the mechanism: that of the i-th has Mhat_ij times the acceleration of the j-th, "
                    "Dhat_ijk times the rates of the j-th and k-th, for both orders, and zhat_i";
  if (rates_section && !reduced.rate_steps.empty()) section.used_sections.push_back(*rates_section);
  for (const SheetFormula& step : reduced.rate_steps) {
    section.terms += rates_section ? step.value.size() : 0;
    if (!rates_section) section.add(step);
  }
  for (const auto* formulas : {&reduced.acceleration_steps, &reduced.definitions, &reduced.formulas})
    for (const SheetFormula& formula : *formulas) section.add(formula);
  return section;
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
