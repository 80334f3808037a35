#include "balance/motion/time_optimal/corridor_search.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/minimax.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>

namespace balance {

// How the least duration changes with what limits it.

/// Derivatives of a row's magnitude less its bound with respect to any parameters, at a moment of the motion.
using ConstraintGradient = std::function<VectorX(const PathPoint& moment, const ConstraintValue& here)>;

/// Derivatives of the duration of a fastest law from rest to rest in one leg. Every arc keeps its row at the bound; what the
/// parameters change there is carried along it from the place that decides its speed: the start, the end, or where a ceiling is
/// touched. Derivation: docs/motion.md.
/// @param parameters how many entries the slopes have
VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& slopes, Eigen::Index parameters);

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
  CorridorResult result;
  result.width = trajectory.corridor->width;
  result.width_unit = width_unit(mechanism, trajectory);
  result.objective = trajectory.law.kind == MotionLawKind::time_optimal ? "duration" : trajectory.min_peak_quantity;
  const Trajectory stated = trajectory;
  const MotionOutcome outcome = CorridorSearch(mechanism, stated).run(trajectory, result);
  if (outcome.status == MotionStatus::done) found = result;
  return outcome;
}

namespace {

constexpr int overlapping_bsplines = 4;            // cubic B-splines that overlap
constexpr double difference_step_fraction = 3e-5;  // of the path's length
constexpr int law_sample_intervals = 1000;         // of a stated law at which its quantity is looked at

MotionOutcome make_limits_infeasible_outcome(const std::string& reason) {
  return {MotionStatus::limits_not_held, 0, reason, {}};
}

/// Of a stated law the quantity whose peak counts, nothing of limits.
PathLimits make_corridor_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (is_mechanism_dependent(trajectory.law.kind)) return make_law_limits(mechanism, trajectory);
  require_constant_loads(mechanism, "the way within a corridor");
  validate(trajectory.law);
  return {require_limited_quantities(mechanism, trajectory.min_peak_quantity), {}, {}};
}

}  // namespace

CorridorObjective::CorridorObjective(const Mechanism& mechanism, const Trajectory& trajectory)
    : mechanism_(mechanism),
      trajectory_(trajectory),
      limits_(make_corridor_limits(mechanism, trajectory)),
      control_points_per_direction_(trajectory.corridor->inner_knots + 2) {
  Trajectory middle = trajectory_;
  middle.corridor.reset();
  const auto source = make_path_dynamics_sampler(mechanism_, middle, limits_.quantities);
  outcome_ = source->outcome();
  if (outcome_.status != MotionStatus::done) return;
  directions_ = source->corridor_components() - 1;
  step_ = difference_step_fraction * source->start_speed();
  if (trajectory_.law.kind != MotionLawKind::time_optimal) unit_ = limits_.quantities[limits_.half_widths.size()].unit;
  if (!is_mechanism_dependent(trajectory_.law.kind)) list_path_points();
}

void CorridorObjective::list_path_points() {
  const MotionLaw& law = trajectory_.law;
  const double duration = trajectory_.duration;
  const auto add = [&](double tau, Side side) {
    const MotionLawValue here = evaluate(law, tau, side);
    moments_.push_back({here.s, here.ds / duration, here.dds / (duration * duration), 0});
  };
  for (int k = 0; k <= law_sample_intervals; ++k)
    add(static_cast<double>(k) / law_sample_intervals, k == 0 ? Side::after : Side::before);
  for (const double tau : find_acceleration_jumps(law)) add(tau, Side::before), add(tau, Side::after);
}

Trajectory CorridorObjective::with_control_points(const VectorX& controls) const {
  Trajectory trajectory = trajectory_;
  trajectory.corridor->control_points.assign(controls.begin(), controls.end());
  return trajectory;
}

PathModel CorridorObjective::model_of(const VectorX& controls) const {
  return build_limited_path_model(mechanism_, with_control_points(controls), limits_);
}

VectorX CorridorObjective::terms(const VectorX& controls) {
  controls_ = controls;
  neighbours_.clear();
  model_ = model_of(controls);
  refusal_ = model_.outcome;
  if (model_.outcome.status != MotionStatus::done) return {};
  if (!is_mechanism_dependent(trajectory_.law.kind)) return stated_law_terms();
  law_ = find_motion_law(model_, limits_, trajectory_);
  if (!law_.law.infeasibility_reason.empty()) {
    refusal_ = make_limits_infeasible_outcome(law_.law.infeasibility_reason);
    return {};
  }
  return VectorX::Constant(1, trajectory_.law.kind == MotionLawKind::time_optimal ? law_.law.duration() : law_.peak);
}

MatrixX CorridorObjective::jacobian() {
  build_neighbours();
  if (!is_mechanism_dependent(trajectory_.law.kind)) return stated_law_jacobian();
  return optimal_law_gradient().transpose();
}

void CorridorObjective::build_neighbours() {
  neighbours_.clear();
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (int colour = 0; colour < overlapping_bsplines; ++colour) {
      VectorX way = VectorX::Zero(controls_.size());
      for (Eigen::Index k = 0; k < control_points_per_direction_; ++k)
        if ((k + 1) % overlapping_bsplines == colour) way[m * control_points_per_direction_ + k] = step_;
      Neighbours next{model_of(controls_ + way), model_of(controls_ - way), 2 * step_};
      for (PathModel* model : {&next.above, &next.below})
        if (model->outcome.status != MotionStatus::done) *model = model_, next.step -= step_;
      neighbours_.push_back(std::move(next));
    }
}

VectorX CorridorObjective::constraint_gradient(const PathPoint& moment, const ConstraintValue& here) const {
  VectorX slopes = VectorX::Zero(controls_.size());
  if (!(here.magnitude > 0)) return slopes;
  const Eigen::Index last =
      control_points_per_direction_ - 1;  // between the knots first and first + 1 four splines overlap
  const auto first =
      std::clamp<Eigen::Index>(static_cast<Eigen::Index>(moment.s * static_cast<double>(last)), 0, last - 1);
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (Eigen::Index spline = first; spline < first + overlapping_bsplines; ++spline) {
      if (spline == 0 || spline > control_points_per_direction_) continue;  // the ends stay
      const Neighbours& next =
          neighbours_[static_cast<std::size_t>(m * overlapping_bsplines + spline % overlapping_bsplines)];
      if (next.step == 0) continue;
      const VectorX change =
          evaluate_constraint(next.above, moment).value - evaluate_constraint(next.below, moment).value;
      slopes[m * control_points_per_direction_ + spline - 1] = here.value.dot(change) / (here.magnitude * next.step);
    }
  return slopes;
}

VectorX CorridorObjective::stated_law_terms() const {
  VectorX pieces(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()));
  Eigen::Index i = 0;
  for (PathPoint moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      pieces[i++] = evaluate_constraint(model_, moment).magnitude;
    }
  return pieces;
}

MatrixX CorridorObjective::stated_law_jacobian() const {
  MatrixX slopes(static_cast<Eigen::Index>(moments_.size() * model_.rows.size()), controls_.size());
  Eigen::Index i = 0;
  for (PathPoint moment : moments_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      moment.row = static_cast<int>(row);
      slopes.row(i++) = constraint_gradient(moment, evaluate_constraint(model_, moment)).transpose();
    }
  return slopes;
}

/// The least peak f in a duration is where the least duration T(f, x) is that: df/dx = −(∂T/∂x) / (∂T/∂f).
VectorX CorridorObjective::optimal_law_gradient() const {
  const Eigen::Index n = controls_.size();
  const std::size_t limits = limits_.half_widths.size();
  const ConstraintGradient slopes = [&](const PathPoint& moment, const ConstraintValue& here) {
    VectorX all(n + 1);
    all << constraint_gradient(moment, here), static_cast<std::size_t>(moment.row) < limits ? 0.0 : -1.0;
    return all;
  };
  const VectorX all = differentiate_duration(model_, law_.bounds, law_.law, slopes, n + 1);
  if (trajectory_.law.kind == MotionLawKind::time_optimal) return all.head(n);
  if (!(all[n] < 0)) return VectorX::Zero(n);  // rest alone decides
  return all.head(n) * (-law_.peak / law_.bounds[limits] / all[n]);
}

namespace {

enum class ProfileSection { speeding_up, braking, sliding };

/// From one node to the next.
struct SensitivitySection {
  ProfileSection kind = ProfileSection::sliding;
  PathPoint middle, before, after;  ///< of its row
  double length = 0, time = 0;
  double ratio = 0;     ///< of d_dx to d_du in the middle
  VectorX forcing;      ///< −2 (slopes) / d_du there
  VectorX first, last;  ///< change of x at both ends
};

class DurationSensitivity {
 public:
  DurationSensitivity(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                      const ConstraintGradient& slopes, Eigen::Index parameters)
      : model_(model), bounds_(bounds), slopes_(slopes), parameters_(parameters) {
    for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
      if (law.nodes[k + 1].s > law.nodes[k].s) add(law.nodes[k], law.nodes[k + 1]);
  }

  VectorX run() {
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (pieces_[i].kind != ProfileSection::braking) forwards(i);
    for (std::size_t i = pieces_.size(); i-- > 0;)
      if (pieces_[i].kind == ProfileSection::braking) backwards(i);
    VectorX total = VectorX::Zero(parameters_);
    for (const SensitivitySection& piece : pieces_) {
      const double x0 = piece.before.v * piece.before.v, x1 = piece.after.v * piece.after.v;
      const VectorX late = x1 > 0 ? VectorX(piece.last / x1) : VectorX(piece.first / x0);
      const VectorX early = x0 > 0 ? VectorX(piece.first / x0) : late;  // at rest both vanish, not their ratio
      total -= piece.time / 4 * (early + late);
    }
    return total;
  }

 private:
  void add(const TimeLawNode& from, const TimeLawNode& to) {
    const ProfilePoint a{from.t, from.s, from.v, from.u_after, -1}, b{to.t, to.s, to.v, to.u_before, -1};
    const ProfilePoint middle = interpolate_at_parameter(a, b, (a.s + b.s) / 2);
    SensitivitySection piece;
    piece.length = b.s - a.s;
    piece.time = b.t - a.t;
    piece.middle = {middle.s, middle.v, middle.u, from.row_after};
    if (piece.middle.row < 0) piece.middle.row = find_most_active_row(piece.middle);
    piece.before = {a.s, a.v, a.u, piece.middle.row};
    piece.after = {b.s, b.v, b.u, piece.middle.row};
    const ConstraintValue here = evaluate_constraint(model_, piece.middle);
    if (!here.is_velocity_limited) {
      piece.kind = here.d_du > 0 ? ProfileSection::speeding_up : ProfileSection::braking;
      piece.ratio = here.d_dx / here.d_du;
      piece.forcing = -2 / here.d_du * slopes_(piece.middle, here);
    }
    pieces_.push_back(std::move(piece));
  }

  int find_most_active_row(PathPoint moment) const {
    double most = -1;
    int row = 0;
    for (std::size_t r = 0; r < bounds_.size(); ++r) {
      moment.row = static_cast<int>(r);
      const double load = evaluate_constraint(model_, moment).magnitude / bounds_[r];
      if (load > most) most = load, row = static_cast<int>(r);
    }
    return row;
  }

  /// d_du δu + d_dx δx = −slopes, in the mean of both ends: δx' = 2 δu.
  void forwards(std::size_t i) {
    SensitivitySection& piece = pieces_[i];
    if (piece.kind == ProfileSection::sliding) {
      piece.first = sensitivity_on_velocity_bound(piece.before);
      piece.last = sensitivity_on_velocity_bound(piece.after);
      return;
    }
    if (i == 0) {
      piece.first = VectorX::Zero(parameters_);
    } else {
      const SensitivitySection& previous = pieces_[i - 1];
      piece.first = previous.kind == ProfileSection::braking ? sensitivity_at_switch_point(previous.after, piece.before)
                                                             : previous.last;
    }
    const double k = piece.length * piece.ratio;
    piece.last = ((1 - k) * piece.first + piece.length * piece.forcing) / (1 + k);
  }

  void backwards(std::size_t i) {
    SensitivitySection& piece = pieces_[i];
    const bool ends = i + 1 == pieces_.size();
    piece.last = ends ? VectorX(VectorX::Zero(parameters_)) : pieces_[i + 1].first;
    const double k = piece.length * piece.ratio;
    piece.first = ((1 + k) * piece.last - piece.length * piece.forcing) / (1 - k);
  }

  /// Where u does not change a row's magnitude, x alone keeps it.
  VectorX sensitivity_on_velocity_bound(const PathPoint& moment) const {
    const ConstraintValue here = evaluate_constraint(model_, moment);
    if (!(std::abs(here.d_dx) > 0)) return VectorX::Zero(parameters_);
    return -slopes_(moment, here) / here.d_dx;
  }

  /// Where braking ends and speeding up begins: on the ceiling, which one row or two make.
  VectorX sensitivity_at_switch_point(const PathPoint& before, const PathPoint& after) const {
    if (before.row == after.row) return sensitivity_on_velocity_bound(before);
    const ConstraintValue a = evaluate_constraint(model_, before), b = evaluate_constraint(model_, after);
    const double determinant = a.d_du * b.d_dx - b.d_du * a.d_dx;
    if (!(std::abs(determinant) > 0)) return VectorX::Zero(parameters_);
    return (b.d_du * slopes_(before, a) - a.d_du * slopes_(after, b)) / determinant;
  }

  const PathModel& model_;
  const std::vector<double>& bounds_;
  const ConstraintGradient& slopes_;
  Eigen::Index parameters_;
  std::vector<SensitivitySection> pieces_;
};

}  // namespace

VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& slopes, Eigen::Index parameters) {
  return DurationSensitivity(model, bounds, law, slopes, parameters).run();
}

namespace {

constexpr int intervals_per_panel = 24;  // between them a cubic's distance has at most one maximum
constexpr int max_ternary_steps = 40;
constexpr double gauge_tolerance = 1e-9;  // of the width

PiecewiseChebyshevSeries make_basis_series(int knots) {
  const auto each = static_cast<std::size_t>(knots) + 2;
  std::vector<double> controls(each * each, 0.0);
  for (std::size_t k = 0; k < each; ++k) controls[k * each + k] = 1;
  return make_corridor_splines(controls, knots);
}

}  // namespace

CorridorSet::CorridorSet(int knots, Eigen::Index directions)
    : each_(knots + 2), directions_(directions), bases_(make_basis_series(knots)) {}

VectorX CorridorSet::basis_values(std::size_t panel, double place) const {
  VectorX values(each_);
  bases_.evaluate(panel, place, values.data());
  return values;
}

MatrixX CorridorSet::metric() const {
  const PiecewiseChebyshevSeries bends = bases_.derivative().derivative();
  MatrixX one = MatrixX::Zero(each_, each_);
  VectorX bend(each_);
  for (std::size_t p = 0; p < bases_.panels().size(); ++p)
    for (const double place :
         {0.2113248654051871, 0.7886751345948129}) {  // Gauss's, exact for the product of two lines
      const Panel& panel = bases_.panels()[p];
      const double s = panel.begin + (panel.end - panel.begin) * place;
      bends.evaluate(p, s, bend.data());
      const VectorX value = basis_values(p, s);
      one += (panel.end - panel.begin) / 2 * (bend * bend.transpose() + value * value.transpose());
    }
  MatrixX whole = MatrixX::Zero(size(), size());
  for (Eigen::Index m = 0; m < directions_; ++m) whole.block(m * each_, m * each_, each_, each_) = one;
  return whole;
}

CorridorSet::OffsetMaximum CorridorSet::offset_at(const VectorX& controls, std::size_t panel, double place) const {
  const VectorX here = basis_values(panel, place);
  VectorX offset(directions_);
  for (Eigen::Index m = 0; m < directions_; ++m) offset[m] = here.dot(controls.segment(m * each_, each_));
  return {place, offset.norm(), offset};
}

std::vector<CorridorSet::OffsetMaximum> CorridorSet::offset_maxima(const VectorX& controls) const {
  std::vector<OffsetMaximum> found;
  for (std::size_t p = 0; p < bases_.panels().size(); ++p) {
    const double begin = bases_.panels()[p].begin, part = (bases_.panels()[p].end - begin) / intervals_per_panel;
    for (int k = 0; k < intervals_per_panel; ++k) {
      // The distance rises into the part and falls out of it: its maximum is inside.
      double low = begin + k * part, high = low + part;
      const double step = 1e-4 * part;
      const auto rises = [&](double place) {
        return offset_at(controls, p, place + step).distance > offset_at(controls, p, place).distance;
      };
      if (!rises(low) || rises(high - step)) continue;
      for (int halving = 0; halving < max_ternary_steps; ++halving) {
        const double left = low + (high - low) / 3, right = high - (high - low) / 3;
        const bool up = offset_at(controls, p, left).distance < offset_at(controls, p, right).distance;
        (up ? low : high) = up ? left : right;
      }
      found.push_back(offset_at(controls, p, (low + high) / 2));
    }
    found.push_back(offset_at(controls, p, begin));
  }
  return found;
}

double CorridorSet::gauge(const VectorX& controls) const {
  double most = 0;
  for (const OffsetMaximum& summit : offset_maxima(controls)) most = std::max(most, summit.distance);
  return most;
}

std::vector<VectorX> CorridorSet::cutting_planes(const VectorX& controls) const {
  std::vector<VectorX> normals;
  for (const OffsetMaximum& summit : offset_maxima(controls)) {
    if (!(summit.distance > 1 + gauge_tolerance)) continue;
    const VectorX here = basis_values(panel_at(summit.place), summit.place);
    VectorX normal(size());
    for (Eigen::Index m = 0; m < directions_; ++m)
      normal.segment(m * each_, each_) = summit.offset[m] / summit.distance * here;
    normals.push_back(normal);
  }
  return normals;
}

}  // namespace balance
