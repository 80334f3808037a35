#pragma once
/// Report data of a mechanism's conditions.

#include "balance/interface/files/report_fields.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/conditions/order_conditions.hpp"
#include "balance/synthesis/design/unbalanced_remainder.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance::reports {

struct ConditionsReportData {
  std::string title;     ///< the mechanism's name
  std::string strategy;  ///< "complete" or "modular"
  Conditions conditions;
  conditions::ConditionNames names;
  VectorX residuals;                                  ///< scaled, for the study's numbers
  std::vector<bool> holds_by_definition;              ///< per condition: met, and met by any symmetric disc
  std::vector<FreeNumber> numbers;                    ///< the study's free numbers
  std::vector<std::vector<int>> free_number_indices;  ///< per condition: indices into `numbers`

  /// Of goals that are orders: the rows one by one, with the names of their coefficients, and per row of
  /// Conditions::orders the amplitude for the study's numbers [SI], 0 for round-off (order_condition_sections.hpp).
  conditions::OrderConditions order_conditions;
  conditions::ConditionNames order_names;
  VectorX order_amplitudes;

  std::vector<design::UnbalancedRemainder> unbalanced_remainder;  ///< what cannot be balanced
  std::vector<conditions::GeometricSymbol> known_terms;           ///< values of the known terms that occur

  bool is_met(int row) const;
  /// Number of conditions with a parameter. The ones after them have only known terms; see unbalanced_remainder.
  int parameter_rows() const { return static_cast<int>(conditions.parameter_rows()); }
};

/// Computes residuals, holds_by_definition, known_terms, orders and unbalanced_remainder from the rest. Where payloads come and
/// go the residuals are the largest of all load states, and notes say which of these meet the conditions.
/// @param mechanism whose numbers the residuals are for
/// @param trajectories along which remaining efforts are computed
/// @param options those of the derivation
void evaluate_conditions(ConditionsReportData& view, const Mechanism& mechanism,
                         const std::vector<Trajectory>& trajectories, const ConditionOptions& options);

/// Springs that the conditions describe by all products of stiffness and end points.
dynamics::FreeSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism);

// Balancing conditions as JSON for programs.

/// One object with everything in the view, including conditions that hold by definition.
Json conditions_json(const ConditionsReportData& view, const std::vector<std::string>& warnings);

// Goals and conditions as parts of a JSON document.

/// One name, or a list if there are several.
Json goals_json(const std::vector<Goal>& goals);

/// Text, LaTeX, terms, residual, … of a condition.
files::ReportFields<int> condition_fields(const ConditionsReportData& view);

/// Adds rank, gap and singular values, parameter names, symbols, conditions and notes to an object.
/// @param fields of a condition
void add_conditions(Json& json, const ConditionsReportData& view, const files::ReportFields<int>& fields);

// Balancing conditions as text for people.

/// Goal, rank and gap, then the numbered conditions with their residuals and the free numbers that they depend on.
/// Conditions that any symmetric disc meets are listed in one line. Ends with a line feed.
std::string conditions_text(const ConditionsReportData& view, const files::TextOptions& options = {});

/// One condition on lines of at most `width` characters, broken between terms; an overlong term has its own line.
std::vector<std::string> wrap_condition(const ConditionsReportData& view, int row, std::size_t width);

/// The view for text in these units: coefficients without a formula are for parameters in them ("m" in g, "mx" in
/// g mm).
ConditionsReportData convert_coefficients(ConditionsReportData view, const specification::SpecUnits& units);

/// What the parameters' names mean, one example of each kind: "crank1.mx is mass times x of the centre of mass". Empty
/// without parameters.
std::string parameter_legend(const ConditionsReportData& view);

/// "l1 = 0.5 m, push.fy = -5 N": values of the symbols and known terms; "" if there are none.
std::string symbols_text(const ConditionsReportData& view, const specification::SpecUnits& units = {});

/// What cannot be balanced, one element per line with its remaining efforts; "" if there is none.
std::string format_remainder(const ConditionsReportData& view, const specification::SpecUnits& units = {});

/// "1-4, 7" for row numbers counted from one.
std::string format_ranges(const std::vector<int>& rows);

}  // namespace balance::reports
