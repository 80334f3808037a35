#include "balance/synthesis/formulas/closure_solution.hpp"

#include "balance/synthesis/formulas/reduced_equations.hpp"
#include "balance/synthesis/formulas/symbolic_recursion.hpp"

#include <algorithm>

namespace balance::formulas {

namespace {

/// Angular velocity of a frame in its own axes for a unit rate of one column.
Vector frame_rotation(const SymbolicTree& tree, const std::vector<FrameOf<Polynomial>>& frames, int frame, int column) {
  std::vector<int> chain;
  for (int k = frame; k > 0; k = tree.frames[static_cast<std::size_t>(k)].parent) chain.push_back(k);
  Vector w;
  for (std::size_t k = chain.size(); k-- > 0;) {
    const SymbolicFrame& at = tree.frames[static_cast<std::size_t>(chain[k])];
    w = to_frame(frames[static_cast<std::size_t>(chain[k])], w);
    if (at.variable < 0 || at.angle < 0) continue;
    for (const auto& [follows, ratio] : tree.variables[static_cast<std::size_t>(at.variable)].follows)
      if (follows == column) w[static_cast<std::size_t>(at.axis)] += at.sign > 0 ? ratio : -ratio;
  }
  return w;
}

/// Rows of C below those of the tree.
void add_disc_rows(Ring& ring, const SymbolicEquations& e, const ClosureElimination& elimination, std::size_t labels,
                   SheetSection& section) {
  PolynomialFactory make{ring};
  const std::vector<FrameOf<Polynomial>> frames = make_frames<Polynomial>(e.tree, make);
  const std::size_t n = e.tree.columns.size();
  std::size_t row = n;
  for (const DiscFrame& disc : e.tree.discs) {
    Matrix w;
    for (std::size_t c = 0; c < n; ++c) {
      const Vector rotation = frame_rotation(e.tree, frames, disc.frame, static_cast<int>(c));
      w.push_back({rotation[0], rotation[1], rotation[2]});
    }
    for (std::size_t axis = e.tree.is_planar ? 2 : 0; axis < 3; ++axis, ++row)
      for (std::size_t u = 0; u < elimination.independent().size(); ++u) {
        SheetFormula formula{"C", index_text({row, u}, labels), {}};
        for (std::size_t c = 0; c < n; ++c) formula.value += w[c][axis] * elimination.rate(c, u);
        section.add(std::move(formula));
      }
  }
}

std::string solved_heading(const SymbolicEquations& e) {
  const std::string columns =
      e.closure.empty() ? "" : "the rate of coordinate i is the sum of C_ij times the rate of the j-th independent one";
  if (e.tree.discs.empty()) return "Closures solved: " + columns;
  std::string names;
  for (const DiscFrame& disc : e.tree.discs) names += (names.empty() ? "" : ", ") + disc.name;
  const std::string rows = "the rows from " + std::to_string(e.tree.columns.size() + 1) +
                           " on are the rotations of the discs " + names +
                           (e.tree.is_planar ? "" : ", each about the axes x, y, z that turn with it") + " (P1 eq. 24)";
  return e.closure.empty() ? "Discs: C_ij times the rates of the coordinates; " + rows
                           : "Closures solved: " + columns + "; " + rows;
}

}  // namespace

SheetSection make_solved_section(Ring& ring, const SymbolicEquations& e, const ClosureElimination& elimination) {
  SheetSection section{SheetSectionKind::solved, solved_heading(e), {}, {}, 0};
  const std::size_t n = e.tree.columns.size(), rows = n + e.tree.discs.size() * (e.tree.is_planar ? 1 : 3);
  const std::size_t labels = std::max(n, rows);
  const std::vector<SheetFormula>& steps = elimination.rate_steps();
  const auto is_rate = [&](const SheetFormula& step, std::size_t c, std::size_t u) {
    return step.symbol >= 0 && elimination.rate(c, u) == Polynomial::of_symbol(ring, step.symbol);
  };
  // in closed form, C does not depend on other entries of C, and is listed by rows
  for (const SheetFormula& step : steps)
    if (!elimination.is_closed_form() || step.name.starts_with("Delta")) section.add(step);
  for (std::size_t c = 0; c < n; ++c)
    for (std::size_t u = 0; u < elimination.independent().size(); ++u) {
      const Polynomial& rate = elimination.rate(c, u);
      const auto step =
          std::find_if(steps.begin(), steps.end(), [&](const SheetFormula& one) { return is_rate(one, c, u); });
      const bool is_independent = static_cast<int>(c) == elimination.independent()[u];
      if (step == steps.end() && !rate.is_zero() && !is_independent)
        section.add({"C", index_text({c, u}, n), rate});
      else if (step != steps.end() && elimination.is_closed_form())
        section.add(*step);
    }
  add_disc_rows(ring, e, elimination, labels, section);
  return section;
}

namespace {

class EffortSection {
 public:
  EffortSection(Ring& ring, const SymbolicEquations& equations, const ClosureElimination& elimination,
                const SolvedConditions* solved)
      : ring_(ring),
        e_(equations),
        elimination_(elimination),
        solved_(solved),
        n_(equations.tree.columns.size()),
        independent_(elimination.independent()) {}

  SheetSection make() {
    section_.section = SheetSectionKind::efforts;
    section_.heading = "Torques of " + independent_names(e_, independent_) +
                       " that move the mechanism: that of the i-th has U_ij times the acceleration of coordinate j, "
                       "U_ijk times the rates of j and k, for both orders, and U_i";
    if (!elimination_.is_closed_form())
      for (const SheetFormula& step : elimination_.rate_steps()) section_.add(step);
    for (std::size_t u = 0; u < independent_.size(); ++u) {
      for (std::size_t j = 0; j < n_; ++j) add(u, {j}, [&](std::size_t c) { return e_.M[c][j]; });
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t k = j; k < n_; ++k) add(u, {j, k}, [&](std::size_t c) { return e_.D[c][j][k]; });
      add(u, {}, [&](std::size_t c) { return e_.z[c]; });
    }
    return std::move(section_);
  }

 private:
  RationalFunction with_solution(const Polynomial& p) const {
    RationalFunction value(p);
    if (solved_ != nullptr)
      for (const SolvedUnknown& one : solved_->solution.solved) value = substitute(value, one.symbol, one.value);
    return value;
  }

  /// C of a dependent column: in closed form a numerator and a denominator, otherwise the symbol that the steps define.
  std::pair<Polynomial, Polynomial> rate(std::size_t c, std::size_t u) const {
    const Polynomial& symbol = elimination_.rate(c, u);
    if (elimination_.is_closed_form())
      for (const SheetFormula& step : elimination_.rate_steps())
        if (symbol == Polynomial::of_symbol(ring_, step.symbol)) return {step.value, step.denominator};
    return {symbol, 1};
  }

  /// @param entry of each column of the tree
  template <class Entry>
  void add(std::size_t u, const std::vector<std::size_t>& columns, const Entry& entry) {
    std::vector<std::size_t> indices{u};
    indices.insert(indices.end(), columns.begin(), columns.end());
    SheetFormula formula{"U", index_text(indices, n_), {}};
    const auto independent = static_cast<std::size_t>(independent_[u]);
    const RationalFunction own = with_solution(entry(independent));
    const auto polynomial = as_polynomial(own);
    formula.value = polynomial ? *polynomial : own.numerator;
    if (!polynomial) formula.denominator = own.denominator;
    for (std::size_t c = 0; c < n_; ++c) {
      if (c == independent || elimination_.rate(c, u).is_zero()) continue;
      const RationalFunction factor = with_solution(entry(c));
      if (factor.is_zero()) continue;
      const auto [numerator, denominator] = rate(c, u);
      const auto factor_polynomial = as_polynomial(factor);
      formula.products.push_back({numerator, factor_polynomial ? denominator : denominator * factor.denominator,
                                  factor_polynomial ? *factor_polynomial : factor.numerator});
    }
    section_.add(std::move(formula));
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  const ClosureElimination& elimination_;
  const SolvedConditions* solved_;
  std::size_t n_;
  const std::vector<int>& independent_;
  SheetSection section_;
};

}  // namespace

SheetSection make_effort_section(Ring& ring, const SymbolicEquations& equations, const ClosureElimination& elimination,
                                 const SolvedConditions* solved) {
  return EffortSection(ring, equations, elimination, solved).make();
}

}  // namespace balance::formulas
