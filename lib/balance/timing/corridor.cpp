#include "balance/timing/corridor.hpp"

#include "balance/base/extrema.hpp"
#include "balance/timing/corridor_figure.hpp"
#include "balance/timing/minimax.hpp"
#include "balance/timing/tube.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace balance {
namespace {

constexpr double objective_tolerance = 1e-5;  // of the least
constexpr unsigned start_seed = 20200517;     // of the starts: the same in every run
constexpr double start_width_fraction = 0.7;  // of the width

MotionOutcome make_done() { return {MotionStatus::done, 0, "", {}}; }

bool has_one_unit(const Mechanism& mechanism, const std::vector<CoordinateValue>& joints) {
  return std::all_of(joints.begin(), joints.end(), [&](const CoordinateValue& joint) {
    const auto kind = [&](int c) { return mechanism.coordinates[static_cast<std::size_t>(c)].kind; };
    return kind(joint.coordinate) == kind(joints.front().coordinate);
  });
}

void validate_corridor(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Corridor& corridor = *trajectory.corridor;
  const auto require = [](bool right, const char* what) {
    if (!right) throw std::invalid_argument(what);
  };
  require(corridor.width > 0 && std::isfinite(corridor.width), "the width of a corridor must be positive");
  require(corridor.inner_knots >= 1, "a corridor needs at least one knot");
  require(corridor.starts >= 1, "the search within a corridor needs at least one start");
  require(trajectory.law.kind != MotionLawKind::constant_momentum,
          "the law 'steady-momentum' leaves nothing to be made least in a corridor");
  require(trajectory.start_speed == 0 && trajectory.end_speed == 0,
          "a motion within a corridor starts and ends at rest");
  require(trajectory.drive != DriveKind::joints || has_one_unit(mechanism, trajectory.from.joints),
          "turning and sliding joints have no distance in common that a corridor could limit");
  require(trajectory.law.kind == MotionLawKind::time_optimal || !trajectory.min_peak_quantity.empty(),
          "a corridor needs a quantity whose peak is to be least");
  for (const SecondaryTask& course : trajectory.secondary_tasks) {
    const auto* spline = std::get_if<SplineTask>(&course.kind);
    require(spline != nullptr && !spline->over_time,
            "no spline over time and no kept momentum go beside the way within a corridor");
  }
}

/// Random controls within the corridor; the first start is its middle.
VectorX draw_random_start(const CorridorSet& tube, int start) {
  VectorX controls = VectorX::Zero(tube.size());
  if (start == 0) return controls;
  std::mt19937_64 engine(start_seed + static_cast<unsigned>(start));
  for (double& control : controls) control = static_cast<double>(engine() >> 11) * 0x1p-52 - 1;
  return controls * (start_width_fraction / tube.gauge(controls));
}

class CorridorSearch {
 public:
  CorridorSearch(const Mechanism& mechanism, const Trajectory& trajectory)
      : trajectory_(trajectory),
        width_(trajectory.corridor->width),
        figure_(mechanism, trajectory),
        tube_(trajectory.corridor->inner_knots, figure_.directions()) {}

  MotionOutcome run(Trajectory& trajectory, CorridorResult& found) {
    if (figure_.outcome().status != MotionStatus::done) return figure_.outcome();
    const VectorX middle = figure_.terms(VectorX::Zero(tube_.size()));
    if (middle.size() == 0) return in_middle(figure_.infeasibility_outcome());
    std::vector<double> values;
    MinimaxResult best{VectorX::Zero(tube_.size()), max_coefficient(middle)};
    found.centreline_value = best.value;
    for (int start = 0; start < trajectory_.corridor->starts; ++start) {
      const MinimaxResult end = from(start);
      values.push_back(end.value);
      if (end.value < best.value) best = end;
    }
    found.objective_value = best.value;
    found.unit = figure_.unit();
    found.max_offset = width_ * tube_.gauge(best.x);
    found.starts = trajectory_.corridor->starts;
    found.agreeing_starts = static_cast<int>(std::count_if(
        values.begin(), values.end(), [&](double value) { return value <= best.value * (1 + objective_tolerance); }));
    const VectorX controls = width_ * best.x;
    trajectory.corridor->control_points.assign(controls.begin(), controls.end());
    return make_done();
  }

 private:
  static MotionOutcome in_middle(MotionOutcome outcome) {
    outcome.reason = "in the middle of the corridor: " + outcome.reason;
    return outcome;
  }

  /// A start that cannot be followed is drawn towards the middle.
  MinimaxResult from(int start) {
    const MinimaxProblem problem{.values = [this](const VectorX& x) { return figure_.terms(width_ * x); },
                                 .jacobian = [this](const VectorX&) { return MatrixX(width_ * figure_.jacobian()); },
                                 .gauge = [this](const VectorX& x) { return tube_.gauge(x); },
                                 .metric = tube_.metric(),
                                 .cutting_planes = [this](const VectorX& x) { return tube_.cutting_planes(x); }};
    VectorX controls = draw_random_start(tube_, start);
    constexpr int max_start_halvings = 8;
    for (int tries = 0; tries < max_start_halvings && figure_.terms(width_ * controls).size() == 0; ++tries)
      controls /= 2;
    return solve_minimax(problem, controls);
  }

  const Trajectory& trajectory_;
  double width_;
  CorridorObjective figure_;
  CorridorSet tube_;
};

std::string width_unit(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (trajectory.drive != DriveKind::joints || trajectory.from.joints.empty()) return "m";
  const auto c = static_cast<std::size_t>(trajectory.from.joints.front().coordinate);
  return mechanism.coordinates[c].kind == CoordinateKind::angle ? "rad" : "m";
}

}  // namespace

MotionOutcome optimise_corridor_path(const Mechanism& mechanism, Trajectory& trajectory,
                                     std::optional<CorridorResult>& found) {
  if (!trajectory.corridor || !trajectory.corridor->control_points.empty()) return make_done();
  validate_corridor(mechanism, trajectory);
  CorridorResult told;
  told.width = trajectory.corridor->width;
  told.width_unit = width_unit(mechanism, trajectory);
  told.objective = trajectory.law.kind == MotionLawKind::time_optimal ? "duration" : trajectory.min_peak_quantity;
  const Trajectory stated = trajectory;
  const MotionOutcome outcome = CorridorSearch(mechanism, stated).run(trajectory, told);
  if (outcome.status == MotionStatus::done) found = told;
  return outcome;
}

}  // namespace balance
