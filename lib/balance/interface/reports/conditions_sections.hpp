#pragma once
/// Everything that is told about a mechanism's conditions, gathered for the writers.

#include "balance/interface/files/json.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/conditions/coefficient_names.hpp"
#include "balance/synthesis/design/unbalanced_remainder.hpp"

#include <functional>
#include <string>
#include <vector>

namespace balance {

struct ConditionsReportData {
  std::string title;     ///< the mechanism's name
  std::string strategy;  ///< "complete" or "modular"
  Conditions conditions;
  ConditionNames names;
  VectorX residuals;                                  ///< scaled, with the numbers that the study holds
  std::vector<bool> holds_by_definition;              ///< per condition: no disc can miss it, and it is met
  std::vector<FreeNumber> numbers;                    ///< the study's free ones
  std::vector<std::vector<int>> free_number_indices;  ///< per condition: into `numbers`

  std::vector<UnbalancedRemainder> unbalanced_remainder;  ///< what nothing balances
  std::vector<GeometricSymbol> known_terms;               ///< values of the known terms that occur

  bool is_met(int row) const;
  /// Conditions that hold a parameter; those behind them hold known terms alone and are told by `staying`.
  int parameter_rows() const { return static_cast<int>(conditions.parameter_rows()); }
};

/// Fills residuals, by_definition, known and staying from the rest.
/// @param mechanism whose numbers the residuals are for
/// @param trajectories along which efforts that stay are looked for
/// @param options as the conditions were derived
void evaluate_conditions(ConditionsReportData& view, const Mechanism& mechanism,
                         const std::vector<Trajectory>& trajectories, const ConditionOptions& options);

/// Which springs conditions describe by all products of stiffness and end points.
FreeSprings loose_springs_of(const Conditions& conditions, const Mechanism& mechanism);

// Balancing conditions as JSON for programs.

/// One object with everything of the view, conditions that hold by definition included.
std::string conditions_json(const ConditionsReportData& view, const std::vector<std::string>& warnings);

// Pieces of JSON that tell of goals and conditions.

/// One name, or a list if there are several.
Json goals_json(const std::vector<Goal>& goals);

/// Text, LaTeX, terms, residual, … of every condition.
Json conditions_list_json(const ConditionsReportData& view);

/// Rank, gap and singular values, the parameters' names, the symbols, the conditions and the notes, added to an object.
void add_conditions(Json& json, const ConditionsReportData& view);

// Balancing conditions as text for people.

/// Goal, rank and gap, then the conditions by number with what they miss now and which free numbers they depend on. What no disc can
/// miss is named in one line. Ends with a line feed.
std::string conditions_text(const ConditionsReportData& view);

/// One condition on lines of at most `width` characters, broken between terms; an over-long term has a line of its own.
std::vector<std::string> wrap_condition(const ConditionsReportData& view, int row, std::size_t width);

/// "l1 = 0.5 m, push.fy = -5 N": what the symbols and known terms stand for; "" if there are none.
std::string symbols_text(const ConditionsReportData& view);

/// What cannot be balanced, an element a line with the efforts that it leaves; "" if there is nothing.
std::string format_remainder(const ConditionsReportData& view);

/// "1–4, 7" of rows that are counted from one.
std::string format_ranges(const std::vector<int>& rows);

}  // namespace balance
