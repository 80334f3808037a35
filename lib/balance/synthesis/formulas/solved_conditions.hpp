#pragma once
/// The balancing conditions solved for named numbers of the spec, as sections of a sheet, and their check.

#include "balance/synthesis/formulas/formula_check.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"
#include "balance/synthesis/formulas/solve_request.hpp"

#include <map>
#include <string>

namespace balance::formulas {

/// @throws FormulaError if the conditions have no symbolic form or become too long
SolvedConditions solve_balance_conditions(Ring& ring, const Mechanism& mechanism, const SymbolicEquations& equations,
                                          const SolveRequest& request);

/// One formula per solved number, then the conditions that remain.
SheetSection make_solution_section(const Ring& ring, const SolvedConditions& solved);

/// The equations of motion of an open chain with the solved numbers: `k1`, … if nothing but constant inertias is left,
/// otherwise D_ij, D_ijk and D_i.
SheetSection make_balanced_section(const SymbolicEquations& equations, const SolvedConditions& solved);

/// Sets the solved numbers to the values of their printed formulas, at random values of all others that meet the
/// conditions that remain, and adds what the engine's conditions leave then to `check`.
void check_solution(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                    const Mechanism& mechanism, std::uint64_t seed, FormulaCheck& check);

}  // namespace balance::formulas
