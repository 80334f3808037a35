#pragma once
/// Report data of a mechanism's equations at one configuration.

#include "balance/interface/files/result_file.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/synthesis/formulas/equations_report.hpp"

#include <string>
#include <vector>

namespace balance::reports {

struct EquationsReportData {
  std::string title;                     ///< the mechanism's name
  std::vector<std::string> coordinates;  ///< names of all coordinates of the mechanism
  formulas::EquationsAtConfiguration at;
  std::set<formulas::EquationSection> sections;  ///< to be shown
  std::vector<bool> is_length;                   ///< per coordinate of the mechanism

  bool shows(formulas::EquationSection section) const { return sections.count(section) > 0; }
};

/// Sections as tables with six significant digits; ends with a line feed. Matrices are for angles in radians. The
/// regressor and the base parameters, whose units differ from row to row, are SI.
std::string equations_text(const EquationsReportData& view, const files::TextOptions& options = {});

/// Everything in the view, as numbers with all their digits.
std::string equations_json(const EquationsReportData& view, const std::vector<std::string>& warnings);

/// Matrices for amsmath, one align* environment; ends with a line feed.
std::string equations_latex(const EquationsReportData& view);

/// One base parameter: "link1.J + l1^2 link2.m".
std::string base_parameter_text(const Conditions& parameters, int row, const conditions::ConditionNames& names);

/// Unit of the generalised inertia of two coordinates, "kg m^2", and of a generalised force, "N m".
std::string inertia_unit(bool first_length, bool second_length);
std::string force_unit(bool length);

/// Writes datasets over time. @throws SystemError, Cancelled
void write_equations(const std::string& path, const formulas::EquationsAlongRun& run,
                     const std::vector<std::string>& actuators, const files::Provenance& description,
                     const files::WriteOptions& options);

// Matrices of equations as text.

/// Six significant digits; 0 for round-off relative to `size`.
std::string format_entry(double value, double size);
std::string matrix_text(const MatrixX& matrix, const std::vector<std::string>& rows,
                        const std::vector<std::string>& columns, std::size_t width = files::default_text_width);
/// "A1: 0.3 A1'^2 - 2 0.1 A1' A2'": the nonzero terms. @param factors of the quadratic forms, "A1'"
std::string velocity_table(const dynamics::IndependentTerms& terms, const std::vector<std::string>& rows,
                           const std::vector<std::string>& factors);
/// The view's sections in its speeds.
std::string speeds_text(const EquationsReportData& view, const files::TextOptions& options = {});

}  // namespace balance::reports
