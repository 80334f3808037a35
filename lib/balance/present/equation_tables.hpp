#pragma once
/// Matrices of equations as text. Private to present.

#include "balance/present/equations_view.hpp"

#include <string>
#include <vector>

namespace balance {

/// Six significant digits; 0 for what is round-off of a size.
std::string format_entry(double value, double size);
std::string matrix_text(const MatrixX& matrix, const std::vector<std::string>& rows,
                        const std::vector<std::string>& columns);
/// "A1: 0.3 A1'^2 - 2 0.1 A1' A2'": the terms that are there. @param factors what the forms are of, "A1'"
std::string velocity_table(const IndependentTerms& terms, const std::vector<std::string>& rows,
                           const std::vector<std::string>& factors);
/// What the view's sections are in the speeds that it has.
std::string speeds_text(const EquationsReportData& view);

}  // namespace balance
