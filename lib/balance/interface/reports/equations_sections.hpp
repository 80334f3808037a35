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

/// Writes datasets over time. @throws SystemError, Cancelled
void write_equations(const std::string& path, const formulas::EquationsAlongRun& run,
                     const std::vector<std::string>& actuators, const files::Provenance& description,
                     const files::WriteOptions& options);

}  // namespace balance::reports
