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

constexpr double same_figure = 1e-5;  // of the least
constexpr unsigned seed = 20200517;   // of the starts: the same in every run
constexpr double start_size = 0.7;    // of the width

MotionOutcome followed() { return {MotionStatus::done, 0, "", {}}; }

bool same_kind(const Mechanism& mechanism, const std::vector<CoordinateValue>& joints) {
  return std::all_of(joints.begin(), joints.end(), [&](const CoordinateValue& joint) {
    const auto kind = [&](int c) { return mechanism.coordinates[static_cast<std::size_t>(c)].kind; };
    return kind(joint.coordinate) == kind(joints.front().coordinate);
  });
}

void check(const Mechanism& mechanism, const Trajectory& trajectory) {
  const Corridor& corridor = *trajectory.corridor;
  const auto require = [](bool right, const char* what) {
    if (!right) throw std::invalid_argument(what);
  };
  require(corridor.width > 0 && std::isfinite(corridor.width), "the width of a corridor must be positive");
  require(corridor.knots >= 1, "a corridor needs at least one knot");
  require(corridor.starts >= 1, "the search within a corridor needs at least one start");
  require(trajectory.law.kind != LawKind::steady_momentum,
          "the law 'steady-momentum' leaves nothing to be made least in a corridor");
  require(trajectory.start_speed == 0 && trajectory.end_speed == 0,
          "a motion within a corridor starts and ends at rest");
  require(trajectory.drive != DriveKind::joints || same_kind(mechanism, trajectory.from.joints),
          "turning and sliding joints have no distance in common that a corridor could limit");
  require(trajectory.law.kind == LawKind::fastest || !trajectory.gentlest_of.empty(),
          "a corridor needs a quantity whose peak is to be least");
  for (const Course& course : trajectory.courses) {
    const auto* spline = std::get_if<AddedSpline>(&course.kind);
    require(spline != nullptr && !spline->over_time,
            "no spline over time and no kept momentum go beside the way within a corridor");
  }
}

/// Random controls within the corridor; the first start is its middle.
VectorX start_of(const Tube& tube, int start) {
  VectorX controls = VectorX::Zero(tube.size());
  if (start == 0) return controls;
  std::mt19937_64 engine(seed + static_cast<unsigned>(start));
  for (double& control : controls) control = static_cast<double>(engine() >> 11) * 0x1p-52 - 1;
  return controls * (start_size / tube.reach(controls));
}

class CorridorSearch {
 public:
  CorridorSearch(const Mechanism& mechanism, const Trajectory& trajectory)
      : trajectory_(trajectory),
        width_(trajectory.corridor->width),
        figure_(mechanism, trajectory),
        tube_(trajectory.corridor->knots, figure_.directions()) {}

  MotionOutcome run(Trajectory& trajectory, FoundCorridor& found) {
    if (figure_.outcome().status != MotionStatus::done) return figure_.outcome();
    const VectorX middle = figure_.pieces(VectorX::Zero(tube_.size()));
    if (middle.size() == 0) return in_middle(figure_.refusal());
    std::vector<double> values;
    Minimax best{VectorX::Zero(tube_.size()), max_coefficient(middle)};
    found.on_path = best.value;
    for (int start = 0; start < trajectory_.corridor->starts; ++start) {
      const Minimax end = from(start);
      values.push_back(end.value);
      if (end.value < best.value) best = end;
    }
    found.figure = best.value;
    found.unit = figure_.unit();
    found.used = width_ * tube_.reach(best.x);
    found.starts = trajectory_.corridor->starts;
    found.agreeing = static_cast<int>(std::count_if(
        values.begin(), values.end(), [&](double value) { return value <= best.value * (1 + same_figure); }));
    const VectorX controls = width_ * best.x;
    trajectory.corridor->controls.assign(controls.begin(), controls.end());
    return followed();
  }

 private:
  static MotionOutcome in_middle(MotionOutcome outcome) {
    outcome.reason = "in the middle of the corridor: " + outcome.reason;
    return outcome;
  }

  /// A start that cannot be followed is drawn towards the middle.
  Minimax from(int start) {
    const MinimaxProblem problem{.values = [this](const VectorX& x) { return figure_.pieces(width_ * x); },
                                 .slopes = [this](const VectorX&) { return MatrixX(width_ * figure_.slopes()); },
                                 .reach = [this](const VectorX& x) { return tube_.reach(x); },
                                 .metric = tube_.metric(),
                                 .cuts = [this](const VectorX& x) { return tube_.cuts(x); }};
    VectorX controls = start_of(tube_, start);
    constexpr int most_tries = 8;
    for (int tries = 0; tries < most_tries && figure_.pieces(width_ * controls).size() == 0; ++tries) controls /= 2;
    return minimise_largest(problem, controls);
  }

  const Trajectory& trajectory_;
  double width_;
  CorridorFigure figure_;
  Tube tube_;
};

std::string width_unit(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (trajectory.drive != DriveKind::joints || trajectory.from.joints.empty()) return "m";
  const auto c = static_cast<std::size_t>(trajectory.from.joints.front().coordinate);
  return mechanism.coordinates[c].kind == CoordinateKind::angle ? "rad" : "m";
}

}  // namespace

MotionOutcome find_corridor(const Mechanism& mechanism, Trajectory& trajectory, std::optional<FoundCorridor>& found) {
  if (!trajectory.corridor || !trajectory.corridor->controls.empty()) return followed();
  check(mechanism, trajectory);
  FoundCorridor told;
  told.width = trajectory.corridor->width;
  told.width_unit = width_unit(mechanism, trajectory);
  told.of = trajectory.law.kind == LawKind::fastest ? "duration" : trajectory.gentlest_of;
  const Trajectory stated = trajectory;
  const MotionOutcome outcome = CorridorSearch(mechanism, stated).run(trajectory, told);
  if (outcome.status == MotionStatus::done) found = told;
  return outcome;
}

}  // namespace balance
