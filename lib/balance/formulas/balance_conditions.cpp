#include "balance/formulas/balance_conditions.hpp"

#include <algorithm>

namespace balance::formulas {

namespace {

/// Longer lists are not searched for combinations: it takes the square of their length.
constexpr std::size_t max_compared_rows = 300;

/// Conditions of equations with more terms are no reading for anybody.
constexpr std::size_t max_condition_terms = 6000;

/// The powers of lengths and gravity that all terms share, and coordinates along slides as functions of their own.
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

/// Coefficients of all functions of the pose: waves times powers of slides.
std::vector<Polynomial> coefficients(const Polynomial& p) {
  std::map<std::pair<TrigonometricId, Monomial>, std::vector<Term>> parts;
  for (const Term& term : p.terms()) {
    const auto is_pose = [&](int s) {
      const auto kind = p.ring()->symbol(s).kind;
      return kind == SymbolKind::slide || kind == SymbolKind::alias;
    };
    const Monomial pose = term.monomial.select([&](int s, int) { return is_pose(s); });
    parts[{term.wave, pose}].push_back({term.monomial / pose, 0, term.coefficient});
  }
  std::vector<Polynomial> found;
  for (auto& [key, terms] : parts) found.push_back(Polynomial::of_terms(p.ring(), std::move(terms)));
  return found;
}

/// The row less a multiple of a known one, if that makes it shorter.
bool reduce_by_row(Polynomial& row, const Polynomial& known) {
  const Term& lead = known.terms()[0];
  for (const Term& term : row.terms()) {
    const Monomial ratio = term.monomial / lead.monomial;
    bool whole = true;
    for (int k = 0; k < ratio.size(); ++k) whole = whole && ratio.exponent(k) > 0;
    if (!whole) continue;
    const Polynomial next =
        row - Polynomial::of_terms(row.ring(), {{ratio, 0, term.coefficient / lead.coefficient}}) * known;
    if (next.size() >= row.size()) continue;
    row = next;
    return true;
  }
  return false;
}

bool is_combination_of(Polynomial row, const std::vector<Polynomial>& kept) {
  for (bool again = true; again && !row.is_zero();) {
    again = false;
    for (const Polynomial& known : kept)
      if (!row.is_zero() && reduce_by_row(row, known)) again = true;
  }
  return row.is_zero();
}

}  // namespace

std::vector<Polynomial> extract_conditions(const std::vector<Polynomial>& entries) {
  std::vector<Polynomial> rows;
  for (const Polynomial& entry : entries)
    for (const Polynomial& p : coefficients(entry)) {
      const Monomial common = common_lengths(p);
      const Rational lead = p.terms()[0].coefficient;
      std::vector<Term> terms;
      for (const Term& term : p.terms()) terms.push_back({term.monomial / common, 0, term.coefficient / lead});
      Polynomial row = Polynomial::of_terms(p.ring(), std::move(terms));
      if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(std::move(row));
    }
  std::stable_sort(rows.begin(), rows.end(), [](auto& a, auto& b) { return a.size() < b.size(); });
  if (rows.size() > max_compared_rows) return rows;
  std::vector<Polynomial> kept;
  for (const Polynomial& row : rows)
    if (!is_combination_of(row, kept)) kept.push_back(row);
  return kept;
}

std::vector<SheetSection> make_condition_sections(const SymbolicEquations& e) {
  const std::size_t n = e.M.size();
  std::vector<Polynomial> force, moving = e.z, apart;
  for (const Polynomial& h : e.moment)
    for (std::size_t c = 0; c < n; ++c) force.push_back(column_derivative(e.tree, h, static_cast<int>(c)));
  for (const Matrix& rows : e.D)
    for (const Row& row : rows) moving.insert(moving.end(), row.begin(), row.end());
  apart = moving;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) apart.push_back(e.M[i][j]);
  std::vector<SheetSection> sections;
  const auto add = [&](const std::string& goal, const std::vector<Polynomial>& entries) {
    SheetSection section{SheetSectionKind::conditions, "Conditions for the goal " + goal, {}, {}, 0};
    for (const Polynomial& entry : entries) section.terms += entry.size();
    section.is_too_long = section.terms > max_condition_terms;
    if (!section.is_too_long) section.terms = 0;
    for (Polynomial& row : section.is_too_long ? std::vector<Polynomial>() : extract_conditions(entries)) {
      section.terms += row.size();
      section.formulas.push_back({"", "", std::move(row), Polynomial(1), ""});
    }
    sections.push_back(std::move(section));
  };
  add("static", e.z);
  add("force", force);
  add("gyroscopic", moving);
  add("decoupled", apart);
  return sections;
}

}  // namespace balance::formulas
