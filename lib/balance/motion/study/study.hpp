#pragma once
/// Everything that one spec defines, complete and validated.

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/landmark.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/results/result.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"
#include "balance/motion/study/balance_goal.hpp"
#include "balance/motion/study/catalogue.hpp"
#include "balance/motion/study/controller_spec.hpp"
#include "balance/motion/study/search_options.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::study {

// Bounds beyond which a value is more likely a misprint than intended.

/// Maximum seed: exactly representable wherever numbers are read from text.
inline constexpr long max_seed = 9'007'199'254'740'991;

// Distance between a point of one body and another point, or a line segment.

/// Distance between a point and a target: another point, or the line segment between two [m].
struct Clearance {
  model::Landmark point;
  std::vector<model::Landmark> target;  ///< one or two landmarks
};

// Elements that a design may leave out.

/// An optional element of a design.
struct OptionalElementText {
  std::string name;
  std::size_t begin = 0,
              end = 0;  ///< bytes of spec_text whose removal gives the spec without it; begin = end: none
};

/// Elements of one section, of which a design keeps a limited number.
struct CardinalityRequest {
  std::string section;  ///< "counterweights", "discs" or "springs"
  std::vector<OptionalElementText> elements;
  bool is_whole_section = false;  ///< all of the section that can vanish; false: those that the spec names
  int max_count = -1;             ///< maximum number kept; −1: as few as possible
};

// Load cases of a design: numbers of the spec that differ from case to case.

/// A number that differs between load cases: a parameter or any number of the mechanism.
struct LoadParameter {
  std::string name;    ///< as in `design: for`: "cargo.mass"
  std::string path;    ///< "payloads.cargo.mass", "parameters.mp"
  double nominal = 0;  ///< as in the spec [SI, parameters as written]
  double unit = 1;     ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;      ///< in the study's recording
};

/// How the values of a figure in all cases are combined.
enum class CaseAggregation { worst, mean };

struct LoadCases {
  std::vector<LoadParameter> numbers;  ///< empty: one load case, that of the spec
  MatrixX values;                      ///< cases × numbers [SI, parameters as written]
  CaseAggregation aggregation = CaseAggregation::worst;
  std::vector<int> adapted;  ///< free numbers that may differ from case to case, increasing

  Eigen::Index size() const { return values.rows(); }
};

// Tolerances of a mechanism's numbers.

/// Distribution of a number about its value in the spec, independent of all others.
enum class Distribution { normal, uniform };

/// A parameter or any number of the spec, with its tolerance.
struct TolerancedParameter {
  std::string path;  ///< "counterweights.cw1.mass", "parameters.l1"
  double value = 0;  ///< as in the spec [SI, parameters as written]
  double width = 0;  ///< normal: the standard deviation; uniform: half of the interval [as the value]
  Distribution distribution = Distribution::normal;
  double unit = 1;            ///< SI value of the spec's unit here; 1 for parameters
  int input = -1;             ///< input of the spec's recording that is added to the number
  bool is_positive = false;   ///< negative values are meaningless
  double relative_width = 0;  ///< as a fraction of the value's magnitude, which the width follows; 0: constant width
  int recording_index = -1;   ///< index into the recording's toleranced numbers

  double deviation() const { return distribution == Distribution::normal ? width : width / std::sqrt(3.0); }
};

using Tolerances = std::vector<TolerancedParameter>;

/// A number that the designer left open: `{free: [lower, upper], start: …}`. The study holds its start value.
struct FreeNumber {
  /// Origin of the start value.
  enum class StartSource {
    spec,                   ///< given as `start`
    zero_of_added_element,  ///< elements added for balancing are absent at the start
    midpoint,               ///< of the bounds, or the size nearest to it: not given in the spec
  };
  std::string key_path;  ///< in the spec, `counterweights.cw2.mass`, or of the parameter: `parameters.x`
  double lower = 0, upper = 0, start = 0;  ///< SI, except free parameters: as written
  StartSource start_source = StartSource::spec;
  double unit = 1;                 ///< SI value of the spec's unit here; 1 for parameters
  std::size_t begin = 0, end = 0;  ///< bytes of spec_text for `{free: …}`, or for the alias in its place
  std::vector<double> discrete_values =
      {};  ///< the only admissible values, increasing [as the bounds]; empty: any between the bounds
};

/// Change of a spec's text that inserts values of free numbers and of `--set`: bytes [begin, end) are replaced by
/// `text` and then, if there is one, the value of a free number.
struct TextReplacement {
  std::size_t begin = 0, end = 0;
  std::string text;
  int free_number = -1;  ///< index of the free number; −1: none
};

/// A figure of a design: its size, or a property of a run along a trajectory.
struct ObjectiveTerm {
  /// The last two are sums over the parts that the spec takes from catalogues.
  enum class Size { none, added_mass, added_inertia, total_mass, part_mass, price };
  /// Property of a run. Mobility and clearance are for limits only.
  enum class RunMeasure {
    figure,     ///< `figure` of `quantity`
    duration,   ///< [s]
    energy,     ///< RunResult::energy [J]
    mobility,   ///< minimum along the motion: how near it comes to a singularity
    clearance,  ///< minimum along the motion [m]
    order,      ///< an order of `quantity` along a periodic motion (results::compute_order_peak)
    // for limits and objectives by simulation
    fluctuation,  ///< coefficient of fluctuation of the speed (results::SpeedFluctuation)
    quality,      ///< balance quality G of the rotor `quantity` (simulation::RotorQuality) [mm/s]
  };
  Size size = Size::none;
  RunMeasure run = RunMeasure::figure;  ///< if `size` is none
  Statistic figure = Statistic::rms;
  std::string quantity;    ///< as in RunResult::metrics: "shaking_force", "torque[A1]"; of `quality` the rotor's body
  std::string trajectory;  ///< name of one of the study's trajectories
  double weight = 1;       ///< non-negative
  Clearance clearance = {};
  /// Only for figures: mean plus this multiple of the standard deviation under the study's tolerances
  /// (synthesis/tolerance/robust_figure.hpp).
  std::optional<double> deviation_multiple = {};
  double order = 0;                                     ///< times per turn, of the measure `order`
  results::OrderPart part = results::OrderPart::whole;  ///< of the same
};

/// Whether it is a sum over parts of catalogues, which does not depend on the mechanism.
inline bool is_size_of_parts(ObjectiveTerm::Size size) {
  return size == ObjectiveTerm::Size::part_mass || size == ObjectiveTerm::Size::price;
}

/// Such a sum for the rows that are chosen.
inline double sum_of_parts(ObjectiveTerm::Size size, const std::vector<CatalogueChoice>& choices) {
  double sum = 0;
  for (const CatalogueChoice& choice : choices)
    sum += size == ObjectiveTerm::Size::price ? choice.price_of(choice.row) : choice.mass_of(choice.row);
  return sum;
}

/// Upper or lower bound on a weighted sum of terms.
struct FigureLimit {
  std::string text;  ///< as written
  std::vector<ObjectiveTerm> terms;
  bool is_lower = false;  ///< lower bound; false: upper bound
  double bound = 0;       ///< SI
  std::string unit;       ///< of the bound: "N m"; empty: none, or a sum
  CaseAggregation aggregation =
      CaseAggregation::worst;  ///< over load cases; for a lower bound, the worst value is the smallest
};

/// Pareto front: designs at which no figure can be reduced without an increase of another one.
struct ParetoRequest {
  std::vector<std::vector<ObjectiveTerm>> figures;  ///< weighted sums; zero, two or three
  int max_points = 9;                               ///< maximum number of designs

  explicit operator bool() const { return !figures.empty(); }
};

/// Free numbers with sizes, no two of which may have the same size, such as the angles of cranks.
struct DifferentNumbers {
  std::vector<int> numbers;   ///< indices of the free numbers, in the order of the request
  std::vector<double> taken;  ///< values of fixed numbers, from which they must differ as well [as their bounds]
};

/// Contents of `design:`.
struct DesignRequest {
  std::vector<Goal> goals;
  std::vector<model::GeneralisedSpeed> speeds;  ///< in whose derivatives the goals are stated; empty: none are chosen
  std::vector<ObjectiveTerm> minimize;          ///< weighted sum; empty: no objective
  std::vector<FigureLimit> subject_to;          ///< all of them must hold
  ParetoRequest front;                          ///< instead of `minimize`
  SearchOptions search;
  LoadCases cases;
  std::vector<CardinalityRequest> cardinality;  ///< elements that may be left out; empty: none
  std::vector<DifferentNumbers> all_different;  ///< disjoint
  /// Whether every design must be in the assembly mode of the start values; empty: if a figure along a motion is asked
  /// for, which depends on the mode.
  std::optional<bool> keeps_assembly_mode;
};

/// A payload that is taken up or set down during the motion (AttachmentOf::from, until), and its location in the spec.
struct TemporaryPayload {
  std::string name;
  SourceLocation place;
};

/// What a record of the machine has along a trajectory that follows it, low-passed.
struct MeasuredEfforts {
  std::string trajectory;          ///< its name
  double step = 0;                 ///< of the rows, the first of which is at the trajectory's start [s]
  double cutoff = 0;               ///< of the low-pass filter [Hz]
  Samples effort;                  ///< rows × actuators [N m or N]; empty: only positions were measured
  std::vector<std::string> notes;  ///< what was done with the record
};

struct Study {
  Mechanism mechanism;
  std::vector<Trajectory>
      trajectories;  ///< declared ones and the built-in `cycloid` and `bang-bang`; empty without `motion`
  std::vector<Controller> controllers;             ///< declared ones, then the built-in ones that are not redeclared
  std::vector<FreeNumber> free_numbers;            ///< in the document's order
  std::vector<CatalogueChoice> catalogue_choices;  ///< elements that are parts of catalogues, in the order of reading
  std::vector<TextReplacement> rewrites;           ///< in the text's order, disjoint
  DesignRequest design;
  Tolerances tolerances;  ///< parameters first, then in the order of reading; empty: none
  std::vector<TemporaryPayload> temporary_payloads;
  std::vector<MeasuredEfforts> measured;  ///< of the trajectories that follow records
  /// Effort per current of the actuators' motors, those that are stated [N m/A or N/A].
  std::vector<std::pair<CoordinateId, double>> current_gains;
  std::vector<model::GeneralisedSpeed> speeds;  ///< generalised speeds for a further equation of motion; empty: none
  std::string spec_file;                        ///< as named by the user
  std::string spec_text;                        ///< as read
  std::vector<std::pair<std::string, std::string>>
      overrides;                      ///< parameters and their values from `--set`, which replace those in the text
  std::vector<std::string> warnings;  ///< legal but suspicious
};

// Names, as specs, options and suites state them.

/// A name that a study does not have: "arm.yaml has no trajectory 'cyclod', only cycloid, bang-bang; nearest is
/// 'cycloid'".
class UnknownNameError : public std::invalid_argument {
 public:
  /// @param kind "trajectory" @param known the names that there are
  UnknownNameError(const std::string& spec_file, const std::string& kind, std::string name,
                   std::vector<std::string> known);

  const std::string& name() const { return name_; }
  const std::vector<std::string>& known() const { return known_; }

 private:
  std::string name_;
  std::vector<std::string> known_;
};

/// The first element of that name; null if there is none.
template <class T>
const T* find_by_name(const std::vector<T>& items, const std::string& name) {
  const auto match = std::find_if(items.begin(), items.end(), [&](const T& item) { return item.name == name; });
  return match == items.end() ? nullptr : &*match;
}

/// The position of the trajectory of that name. @throws UnknownNameError
std::size_t trajectory_index(const Study& study, const std::string& name);

/// The trajectory of that name; the spec's first if the name is empty.
/// @throws UnknownNameError; SpecError if the spec states no motion
const Trajectory& choose_trajectory(const Study& study, const std::string& name);

/// The mechanism of runs along the trajectory of that name: with the slides of the counterweights that it moves
/// (mechanics/trajectory/adaptation.hpp). Without any, or without such a trajectory, the study's.
/// @throws std::invalid_argument if the moves are impossible
Mechanism mechanism_along(const Study& study, const std::string& trajectory);

/// The study's mechanism with the slides of all counterweights that any of its trajectories moves.
/// @throws std::invalid_argument if moves are impossible, or if two trajectories move one along different lines
Mechanism mechanism_with_slides(const Study& study);

/// The controller of that name; if the name is empty the spec's first or, if it declares none, computed torque.
/// @throws UnknownNameError
const Controller& choose_controller(const Study& study, const std::string& name);

// Analyses that do not support payloads taken up or set down during the motion.

/// @param what the analysis that needs permanent payloads: "conditions", "a controlled run"
/// @param without names of elements or sections that are left out; null: they cannot be left out
/// @throws SpecError at the first temporary payload that is not left out
void reject_temporary_payloads(const Study& study, const std::string& what,
                               const std::vector<std::string>* without = nullptr);

}  // namespace balance::study

namespace balance {

using study::FreeNumber;
using study::ObjectiveTerm;
using study::Study;
using study::Tolerances;

}  // namespace balance
