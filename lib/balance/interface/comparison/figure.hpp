#pragma once
/// Figures: numbers that judge a run, a design, conditions or a state, such as `peak(torque[A1])` or
/// `value(joint_velocity[X], joint_position[A] = pi/3)`. docs/compare.md describes the language.

#include "balance/interface/comparison/sampled_curve.hpp"
#include "balance/mechanics/results/result.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>

namespace balance::comparison {

class FigureEvaluator;
struct FigureReference;

/// A figure's value, or why there is none.
struct EvaluatedFigure {
  std::string text;                                         ///< FigureReference::text()
  double value = std::numeric_limits<double>::quiet_NaN();  ///< SI
  std::string unit;                                         ///< of the value; empty: none, or unknown
  std::string word;    ///< of verdict(): all words that hold, separated by spaces: "balanced proved-best"
  std::string reason;  ///< why there is no value in this run: "joint_position[A] never is 1.2"
  /// What is wrong with the figure itself, for this run: "no run has a quantity 'tork[A]'; nearest is 'torque[A]'".
  std::string mistake;
  std::string mistaken_name;  ///< part of the text that the mistake is about; empty: the whole figure

  bool has_value() const { return mistake.empty() && reason.empty(); }
};

/// What a figure's parentheses hold, before the name of a run.
enum class FigureArguments { none, quantity, order_and_quantity, quantity_and_moment, moment, path };

/// A line of the table of figures.
struct FigureFunction {
  const char* name;
  FigureArguments arguments;
  const char* unit;                    ///< SI; "": that of the quantity, or none
  std::optional<Statistic> statistic;  ///< if it is one of RunResult::metrics
  EvaluatedFigure (*read)(FigureEvaluator&, const FigureReference&);
};

/// All figures, in the order of messages.
std::span<const FigureFunction> figure_functions();

/// The time at which a value is taken.
struct FigureMoment {
  enum class Kind { none, time, start, end, crossing, peak, minimum, maximum };
  Kind kind = Kind::none;
  double time = 0;           ///< [s]
  std::string quantity;      ///< that crosses a level or has an extremum
  std::size_t column = 1;    ///< of that quantity, as FigureReference::column
  double level = 0;          ///< SI
  std::string level_text;    ///< as written
  int crossing = 1;          ///< the first, the second, …
  std::string text() const;  ///< "joint_position[A] = 1.2 #2", "end", "0.3"; empty: none
  bool has_quantity() const { return !quantity.empty(); }
};

/// A figure as a requirement refers to it.
struct FigureReference {
  const FigureFunction* function = nullptr;
  std::string quantity;  ///< with component: "joint_force[B].x"; of `number`, the path; empty: none
  double order = 0;      ///< of order(2, …)
  FigureMoment moment;
  JumpSide side = JumpSide::any;
  std::string run;         ///< name of the run; empty: the run that the requirement is judged for
  std::string variable;    ///< its name in the arithmetic
  std::size_t column = 1;  ///< where it is written, from 1

  /// In one spelling, without the run: "value(joint_velocity[X], joint_position[A] = 1.0471975511965976, before)".
  std::string text() const;
};

}  // namespace balance::comparison
