#pragma once
/// Everything that one spec asks for, complete and validated.

#include "balance/base/error.hpp"
#include "balance/model/mechanism.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/result/figure.hpp"
#include "balance/study/clearance.hpp"
#include "balance/study/controller.hpp"
#include "balance/study/element_choice.hpp"
#include "balance/study/goal.hpp"
#include "balance/study/load_cases.hpp"
#include "balance/study/search_options.hpp"
#include "balance/study/tolerances.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// A number that the designer left open: `{free: [lower, upper], start: …}`. The study holds its start value.
struct FreeNumber {
  /// Where its start is from.
  enum class StartSource {
    spec,                   ///< it says `start`
    zero_of_added_element,  ///< what is added to balance a mechanism is not there to begin with
    midpoint,               ///< of the bounds, or the size nearest to it: nobody has said it
  };
  std::string key_path;  ///< key path in the spec, `counterweights.cw2.mass`, or the parameter's: `parameters.x`
  double lower = 0, upper = 0, start = 0;  ///< SI, except free parameters: as written
  StartSource start_source = StartSource::spec;
  double unit = 1;                 ///< SI value of the spec's unit here; 1 for parameters
  std::size_t begin = 0, end = 0;  ///< bytes of spec_text that `{free: …}`, or the alias that stands for it, takes up
  std::vector<double> discrete_values =
      {};  ///< the only values that it may have, increasing [as the bounds]; empty: any between them
};

/// How a spec is written with numbers in place of its free ones, and with what `--set` said: bytes [begin, end) of its text are
/// replaced by `text` and then, if there is one, the value of a free number.
struct TextReplacement {
  std::size_t begin = 0, end = 0;
  std::string text;
  int free_number = -1;  ///< index of the free number; −1: none
};

/// One number that says how good a design is: its size, or something of a run along a trajectory.
struct ObjectiveTerm {
  enum class Size { none, added_mass, added_inertia, total_mass };
  /// What of a run. All but the first two are for limits.
  enum class RunMeasure {
    figure,     ///< `figure` of `quantity`
    duration,   ///< how long it takes [s]
    energy,     ///< Result::energy [J]
    mobility,   ///< the least there is: how near the motion comes to a singularity
    clearance,  ///< the least there is [m]
  };
  Size size = Size::none;
  RunMeasure run = RunMeasure::figure;  ///< unless there is a size
  Statistic figure = Statistic::rms;
  std::string quantity;    ///< as in Result::metrics: "shaking_force", "torque[A1]"
  std::string trajectory;  ///< name of one of the study's trajectories
  double weight = 1;       ///< not negative
  Clearance clearance = {};
  /// Of a figure alone: its mean plus so many deviations where the study's tolerances have the numbers off (analysis/robust_figure.hpp).
  std::optional<double> deviation_multiple = {};
};

/// What a weighted sum of terms must not exceed, or fall below.
struct FigureLimit {
  std::string text;  ///< as written
  std::vector<ObjectiveTerm> terms;
  bool is_lower = false;  ///< else at most
  double bound = 0;       ///< SI
  std::string unit;       ///< of the bound: "N m"; empty: none, or a sum
  CaseAggregation aggregation =
      CaseAggregation::worst;  ///< which of the load cases' values counts; at least: the worst is the least
};

/// Figures of which none can become smaller without another one growing: designs all along that trade-off.
struct ParetoRequest {
  std::vector<std::vector<ObjectiveTerm>> figures;  ///< weighted sums; none, two or three
  int max_points = 9;                               ///< designs wanted, at most

  explicit operator bool() const { return !figures.empty(); }
};

/// What `design:` asks for.
struct DesignRequest {
  std::vector<Goal> goals;
  std::vector<ObjectiveTerm> minimize;  ///< their weighted sum; empty: nothing in particular
  std::vector<FigureLimit> subject_to;  ///< all of them must hold
  ParetoRequest front;                  ///< in place of `minimize`
  SearchOptions search;
  LoadCases cases;
  std::vector<CardinalityRequest> cardinality;  ///< what may be left out; empty: nothing
};

/// A payload that is taken up or set down on the way (AttachmentOf::from, until), and where the spec says so.
struct TemporaryPayload {
  std::string name;
  SourceLocation place;
};

struct Study {
  Mechanism mechanism;
  std::vector<Trajectory>
      trajectories;  ///< declared ones and the built-in `cycloid` and `bang-bang`; empty without `motion`
  std::vector<Controller> controllers;    ///< declared ones, then the built-in ones that no declared one replaces
  std::vector<FreeNumber> free_numbers;   ///< in the document's order
  std::vector<TextReplacement> rewrites;  ///< in the text's order, disjoint
  DesignRequest design;
  Tolerances tolerances;  ///< parameters first, else in the order of reading; empty: nothing is said of them
  std::vector<TemporaryPayload> temporary_payloads;
  std::vector<GeneralisedSpeed> speeds;  ///< in which the equation of motion is wanted, too; empty: none
  std::string spec_file;                 ///< as named by the user
  std::string spec_text;                 ///< as read
  std::vector<std::string> warnings;     ///< legal but suspicious
};

}  // namespace balance
