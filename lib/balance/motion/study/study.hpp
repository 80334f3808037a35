#pragma once
/// Everything that one spec asks for, complete and validated.

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/balance_goal.hpp"
#include "balance/motion/study/controller_spec.hpp"
#include "balance/motion/study/search_options.hpp"

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace balance {

// Sizes beyond which a misprint is likelier than a wish.

/// A seed: what a number in a text surely holds.
inline constexpr long max_seed = 9'007'199'254'740'991;

// How near a point of one body comes to another point, or to the line between two.

/// A place that something in the mechanism marks.
struct Landmark {
  enum class Kind {
    origin,      ///< of a body's frame
    com,         ///< of a body alone, without what is attached
    point,       ///< a named one of a body
    attachment,  ///< the centre of mass of a counterweight or payload
    disc,        ///< its centre of mass
  };
  Kind kind = Kind::origin;
  BodyId body = 0;  ///< of origin, com and point
  int index = 0;    ///< of the body's point, of the attachment or of the disc
};

/// Distance between a point and `to`: another point, or the straight line from one to another [m].
struct Clearance {
  Landmark point;
  std::vector<Landmark> target;  ///< one or two
};

// Which of the elements that a spec offers a design may keep.

/// An element that a design may leave out.
struct OptionalElementText {
  std::string name;
  std::size_t begin = 0,
              end = 0;  ///< bytes of spec_text without which the spec is one without it; begin = end: there are none
};

/// Elements of one section, of which a design keeps only so many.
struct CardinalityRequest {
  std::string section;  ///< "counterweights", "discs" or "springs"
  std::vector<OptionalElementText> elements;
  bool is_whole_section = false;  ///< of the section, unless they cannot vanish; else those that the spec names
  int max_count = -1;             ///< that are kept; −1: as few as will do
};

// The loads that one design is made for: numbers of the spec that differ from case to case.

/// A number that the load changes: a parameter or any number of the mechanism.
struct LoadParameter {
  std::string name;    ///< as `design: for` says it: "cargo.mass"
  std::string path;    ///< "payloads.cargo.mass", "parameters.mp"
  double nominal = 0;  ///< as the spec has it [SI, parameters as written]
  double unit = 1;     ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;      ///< of the study's recording
};

/// What becomes of a figure that has a value in every case.
enum class CaseAggregation { worst, mean };

struct LoadCases {
  std::vector<LoadParameter> numbers;  ///< empty: there is one load, the spec's own
  MatrixX values;                      ///< cases × numbers [SI, parameters as written]
  CaseAggregation aggregation = CaseAggregation::worst;
  std::vector<int> adapted;  ///< free numbers that may differ from case to case, increasing

  Eigen::Index size() const { return values.rows(); }
};

// How far the numbers of a mechanism may be off when it is made.

/// How a number is spread about what the spec says: independently of all others.
enum class Distribution { normal, uniform };

/// A parameter or any number of the spec, and how far it may be off.
struct TolerancedParameter {
  std::string path;  ///< "counterweights.cw1.mass", "parameters.l1"
  double value = 0;  ///< what the spec says [SI, parameters as written]
  double width = 0;  ///< normal: the standard deviation; uniform: half of the interval [as the value]
  Distribution distribution = Distribution::normal;
  double unit = 1;            ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;             ///< of the spec's recording: changes the number by as much as itself
  bool is_positive = false;   ///< a value below zero makes no sense
  double relative_width = 0;  ///< the width is so large a part of the value's size, and follows it; 0: it is what it is
  int recording_index = -1;   ///< among the recording's toleranced numbers: what the value is of

  double deviation() const { return distribution == Distribution::normal ? width : width / std::sqrt(3.0); }
};

using Tolerances = std::vector<TolerancedParameter>;

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
    energy,     ///< RunResult::energy [J]
    mobility,   ///< the least there is: how near the motion comes to a singularity
    clearance,  ///< the least there is [m]
  };
  Size size = Size::none;
  RunMeasure run = RunMeasure::figure;  ///< unless there is a size
  Statistic figure = Statistic::rms;
  std::string quantity;    ///< as in RunResult::metrics: "shaking_force", "torque[A1]"
  std::string trajectory;  ///< name of one of the study's trajectories
  double weight = 1;       ///< not negative
  Clearance clearance = {};
  /// Of a figure alone: its mean plus so many deviations where the study's tolerances have the numbers off
  /// (synthesis/tolerance/robust_figure.hpp).
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
  std::vector<std::pair<std::string, std::string>>
      overrides;                      ///< parameters and their values in place of the text's: `--set`
  std::vector<std::string> warnings;  ///< legal but suspicious
};

// Who cannot say what payloads mean that are taken up and set down on the way.

/// @param what that needs payloads which are always there: "conditions", "a controlled run"
/// @param without names, or the section's, of what does not count there; null: it cannot be left out
/// @throws SpecError at the first that is not
void reject_temporary_payloads(const Study& study, const std::string& what,
                               const std::vector<std::string>* without = nullptr);

}  // namespace balance
