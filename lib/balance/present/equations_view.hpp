#pragma once
/// The equations of a mechanism at one configuration, gathered for the writers.

#include "balance/analysis/equations.hpp"
#include "balance/write/write_options.hpp"

#include <string>
#include <vector>

namespace balance {

struct EquationsReportData {
  std::string title;                     ///< the mechanism's name
  std::vector<std::string> coordinates;  ///< names of all of the mechanism's
  EquationsAtConfiguration at;
  std::set<EquationSection> sections;  ///< that are shown

  bool shows(EquationSection section) const { return sections.count(section) > 0; }
};

/// Sections as tables, six significant digits; ends with a line feed.
std::string equations_text(const EquationsReportData& view);

/// All that the view has, as numbers with all their digits.
std::string equations_json(const EquationsReportData& view, const std::vector<std::string>& warnings);

/// Matrices for amsmath, one align* environment; ends with a line feed.
std::string equations_latex(const EquationsReportData& view);

/// One base parameter: "link1.J + l1^2 link2.m".
std::string base_parameter_text(const Conditions& parameters, int row, const ConditionNames& names);

/// The unit of a product of two coordinates' generalised inertia, "kg m^2", and of a generalised force, "N m".
std::string inertia_unit(bool first_length, bool second_length);
std::string force_unit(bool length);

/// Datasets over time. @throws SystemError, Cancelled
void write_equations(const std::string& path, const EquationsAlongRun& along, const std::vector<std::string>& actuators,
                     const Provenance& description, const WriteOptions& options);

}  // namespace balance
