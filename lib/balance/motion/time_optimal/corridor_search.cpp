#include "balance/motion/time_optimal/corridor_search.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/minimax.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/mechanics/trajectory/motion_law.hpp"
#include "balance/mechanics/trajectory/path_offsets.hpp"
#include "balance/motion/time_optimal/path_model.hpp"
#include "balance/motion/time_optimal/time_optimal_law.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace balance::time_optimal {

// Sensitivity of the minimum duration.

/// Derivatives of a row's magnitude minus its bound with respect to arbitrary parameters, at a point of the motion.
using ConstraintGradient = std::function<VectorX(const PathPoint& point, const ConstraintValue& constraint)>;

/// Derivatives of the duration of a fastest law from rest to rest in one leg. Every profile keeps its row at the bound.
/// Changes by the parameters propagate along the profile from the point that determines its rate: the start, the end,
/// or a contact with the maximum velocity curve. Derivation: docs/motion.md.
/// @param parameters number of entries of the slopes
VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& constraint_gradient, Eigen::Index parameters);

namespace {

constexpr double objective_tolerance = 1e-5;  // relative to the minimum
constexpr unsigned start_seed = 20200517;     // for random starts: the same in every run
constexpr double start_width_fraction = 0.7;  // of the width

MotionOutcome make_done() { return {MotionStatus::done, 0, "", {}}; }

bool has_one_unit(const Mechanism& mechanism, const std::vector<CoordinateValue>& joints) {
  return std::all_of(joints.begin(), joints.end(), [&](const CoordinateValue& joint) {
    const auto kind = [&](int c) { return mechanism.coordinates[static_cast<std::size_t>(c)].kind; };
    return kind(joint.coordinate) == kind(joints.front().coordinate);
  });
}

void validate_corridor(const Mechanism& mechanism, const Trajectory& trajectory) {
  const trajectory::Corridor& corridor = *trajectory.corridor;
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(what);
  };
  require(corridor.width > 0 && std::isfinite(corridor.width), "the width of a corridor must be positive");
  require(corridor.inner_knots >= 1, "a corridor needs at least one knot");
  require(corridor.starts >= 1, "the search within a corridor needs at least one start");
  require(trajectory.law.kind != MotionLawKind::constant_momentum,
          "the law 'steady-momentum' leaves nothing to minimize in a corridor");
  require(trajectory.start_speed == 0 && trajectory.end_speed == 0,
          "a motion within a corridor starts and ends at rest");
  require(trajectory.drive != DriveKind::joints || has_one_unit(mechanism, trajectory.from.joints),
          "a corridor cannot limit turning and sliding joints together: their distances have different units");
  require(trajectory.law.kind == MotionLawKind::time_optimal || !trajectory.min_peak_quantity.empty(),
          "a corridor needs a quantity whose peak is minimized");
  for (const trajectory::SecondaryTask& task : trajectory.secondary_tasks) {
    const auto* spline = std::get_if<trajectory::SplineTask>(&task.kind);
    require(spline != nullptr && !spline->over_time,
            "a corridor cannot be combined with a spline over time or a kept momentum");
  }
}

/// Random controls within the corridor; the first start is the centreline.
VectorX draw_random_start(const CorridorSet& corridor_set, int start) {
  VectorX controls = VectorX::Zero(corridor_set.size());
  if (start == 0) return controls;
  controls = numerics::UniformRandom(start_seed + static_cast<unsigned>(start)).sample_point(corridor_set.size());
  return controls * (start_width_fraction / corridor_set.gauge(controls));
}

class CorridorSearch {
 public:
  CorridorSearch(const Mechanism& mechanism, const Trajectory& trajectory)
      : trajectory_(trajectory),
        width_(trajectory.corridor->width),
        objective_(mechanism, trajectory),
        corridor_set_(trajectory.corridor->inner_knots, objective_.directions()) {}

  MotionOutcome run(Trajectory& trajectory, trajectory::CorridorResult& result) {
    if (objective_.outcome().status != MotionStatus::done) return objective_.outcome();
    const VectorX centreline_terms = objective_.terms(VectorX::Zero(corridor_set_.size()));
    if (centreline_terms.size() == 0) return at_centreline(objective_.infeasibility_outcome());
    std::vector<double> values;
    numerics::MinimaxResult best{VectorX::Zero(corridor_set_.size()), numerics::max_coefficient(centreline_terms)};
    result.centreline_value = best.value;
    for (int start = 0; start < trajectory_.corridor->starts; ++start) {
      const numerics::MinimaxResult solution = solve_from(start);
      values.push_back(solution.value);
      if (solution.value < best.value) best = solution;
    }
    result.objective_value = best.value;
    result.unit = objective_.unit();
    result.max_offset = width_ * corridor_set_.gauge(best.x);
    result.starts = trajectory_.corridor->starts;
    result.agreeing_starts = static_cast<int>(std::count_if(
        values.begin(), values.end(), [&](double value) { return value <= best.value * (1 + objective_tolerance); }));
    const VectorX controls = width_ * best.x;
    trajectory.corridor->control_points.assign(controls.begin(), controls.end());
    return make_done();
  }

 private:
  static MotionOutcome at_centreline(MotionOutcome outcome) {
    outcome.reason = "in the middle of the corridor: " + outcome.reason;
    return outcome;
  }

  /// Moves a start that cannot be followed towards the centreline.
  numerics::MinimaxResult solve_from(int start) {
    const numerics::MinimaxProblem problem{
        .values = [this](const VectorX& x) { return objective_.terms(width_ * x); },
        .jacobian = [this](const VectorX&) { return MatrixX(width_ * objective_.jacobian()); },
        .gauge = [this](const VectorX& x) { return corridor_set_.gauge(x); },
        .metric = corridor_set_.metric(),
        .cutting_planes = [this](const VectorX& x) { return corridor_set_.cutting_planes(x); }};
    VectorX controls = draw_random_start(corridor_set_, start);
    constexpr int max_start_halvings = 8;
    for (int halving = 0; halving < max_start_halvings && objective_.terms(width_ * controls).size() == 0; ++halving)
      controls /= 2;
    return solve_minimax(problem, controls);
  }

  const Trajectory& trajectory_;
  double width_;
  CorridorObjective objective_;
  CorridorSet corridor_set_;
};

std::string width_unit(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (trajectory.drive != DriveKind::joints || trajectory.from.joints.empty()) return "m";
  const auto c = static_cast<std::size_t>(trajectory.from.joints.front().coordinate);
  return mechanism.coordinates[c].kind == CoordinateKind::angle ? "rad" : "m";
}

}  // namespace

MotionOutcome optimise_corridor_path(const Mechanism& mechanism, Trajectory& trajectory,
                                     std::optional<trajectory::CorridorResult>& corridor_result) {
  if (!trajectory.corridor || !trajectory.corridor->control_points.empty()) return make_done();
  validate_corridor(mechanism, trajectory);
  trajectory::CorridorResult result;
  result.width = trajectory.corridor->width;
  result.width_unit = width_unit(mechanism, trajectory);
  result.objective = trajectory.law.kind == MotionLawKind::time_optimal ? "duration" : trajectory.min_peak_quantity;
  const Trajectory original = trajectory;
  const MotionOutcome outcome = CorridorSearch(mechanism, original).run(trajectory, result);
  if (outcome.status == MotionStatus::done) corridor_result = result;
  return outcome;
}

namespace {

constexpr int overlapping_bsplines = 4;            // number of cubic B-splines that overlap
constexpr double difference_step_fraction = 3e-5;  // of the path's length
constexpr int law_sample_intervals = 1000;         // intervals at which the quantity is evaluated under a given law

MotionOutcome make_limits_infeasible_outcome(const std::string& reason) {
  return {MotionStatus::limits_not_held, 0, reason, {}};
}

/// For a given law, only the quantity whose peak is minimised, without limits.
PathLimits make_corridor_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  if (is_mechanism_dependent(trajectory.law.kind)) return make_law_limits(mechanism, trajectory);
  require_constant_loads(mechanism, "the path within a corridor");
  validate(trajectory.law);
  return {require_limited_quantities(mechanism, trajectory.min_peak_quantity), {}, {}};
}

}  // namespace

CorridorObjective::CorridorObjective(const Mechanism& mechanism, const Trajectory& trajectory)
    : mechanism_(mechanism),
      trajectory_(trajectory),
      limits_(make_corridor_limits(mechanism, trajectory)),
      control_points_per_direction_(trajectory.corridor->inner_knots + 2) {
  Trajectory centreline = trajectory_;
  centreline.corridor.reset();
  const auto sampler = make_path_dynamics_sampler(mechanism_, centreline, limits_.quantities);
  outcome_ = sampler->outcome();
  if (outcome_.status != MotionStatus::done) return;
  directions_ = sampler->corridor_components() - 1;
  step_ = difference_step_fraction * sampler->start_speed();
  if (trajectory_.law.kind != MotionLawKind::time_optimal) unit_ = limits_.quantities[limits_.half_widths.size()].unit;
  if (!is_mechanism_dependent(trajectory_.law.kind)) list_path_points();
}

void CorridorObjective::list_path_points() {
  const MotionLaw& law = trajectory_.law;
  const double duration = trajectory_.duration;
  const auto add = [&](double tau, trajectory::Side side) {
    const trajectory::MotionLawValue value = evaluate(law, tau, side);
    path_points_.push_back({value.s, value.ds / duration, value.dds / (duration * duration), 0});
  };
  for (int k = 0; k <= law_sample_intervals; ++k)
    add(static_cast<double>(k) / law_sample_intervals, k == 0 ? trajectory::Side::after : trajectory::Side::before);
  for (const double tau : find_acceleration_jumps(law))
    add(tau, trajectory::Side::before), add(tau, trajectory::Side::after);
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
      VectorX perturbation = VectorX::Zero(controls_.size());
      for (Eigen::Index k = 0; k < control_points_per_direction_; ++k)
        if ((k + 1) % overlapping_bsplines == colour) perturbation[m * control_points_per_direction_ + k] = step_;
      Neighbours neighbours{model_of(controls_ + perturbation), model_of(controls_ - perturbation), 2 * step_};
      for (PathModel* model : {&neighbours.above, &neighbours.below})
        if (model->outcome.status != MotionStatus::done) *model = model_, neighbours.step -= step_;
      neighbours_.push_back(std::move(neighbours));
    }
}

VectorX CorridorObjective::constraint_gradient(const PathPoint& point, const ConstraintValue& constraint) const {
  VectorX gradient = VectorX::Zero(controls_.size());
  if (!(constraint.magnitude > 0)) return gradient;
  const Eigen::Index last =
      control_points_per_direction_ - 1;  // four splines overlap between the knots first and first + 1
  const auto first =
      std::clamp<Eigen::Index>(static_cast<Eigen::Index>(point.s * static_cast<double>(last)), 0, last - 1);
  for (Eigen::Index m = 0; m < directions_; ++m)
    for (Eigen::Index spline = first; spline < first + overlapping_bsplines; ++spline) {
      if (spline == 0 || spline > control_points_per_direction_) continue;  // the ends are fixed
      const Neighbours& neighbours =
          neighbours_[static_cast<std::size_t>(m * overlapping_bsplines + spline % overlapping_bsplines)];
      if (neighbours.step == 0) continue;
      const VectorX change =
          evaluate_constraint(neighbours.above, point).value - evaluate_constraint(neighbours.below, point).value;
      gradient[m * control_points_per_direction_ + spline - 1] =
          constraint.value.dot(change) / (constraint.magnitude * neighbours.step);
    }
  return gradient;
}

VectorX CorridorObjective::stated_law_terms() const {
  VectorX magnitudes(static_cast<Eigen::Index>(path_points_.size() * model_.rows.size()));
  Eigen::Index i = 0;
  for (PathPoint point : path_points_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      point.row = static_cast<int>(row);
      magnitudes[i++] = evaluate_constraint(model_, point).magnitude;
    }
  return magnitudes;
}

MatrixX CorridorObjective::stated_law_jacobian() const {
  MatrixX derivatives(static_cast<Eigen::Index>(path_points_.size() * model_.rows.size()), controls_.size());
  Eigen::Index i = 0;
  for (PathPoint point : path_points_)
    for (std::size_t row = 0; row < model_.rows.size(); ++row) {
      point.row = static_cast<int>(row);
      derivatives.row(i++) = constraint_gradient(point, evaluate_constraint(model_, point)).transpose();
    }
  return derivatives;
}

/// The minimum peak f for a duration T is where the minimum duration T(f, x) equals T: df/dx = −(∂T/∂x) / (∂T/∂f).
VectorX CorridorObjective::optimal_law_gradient() const {
  const Eigen::Index n = controls_.size();
  const std::size_t limit_count = limits_.half_widths.size();
  const ConstraintGradient extended_gradient = [&](const PathPoint& point, const ConstraintValue& constraint) {
    VectorX gradient(n + 1);
    gradient << constraint_gradient(point, constraint), static_cast<std::size_t>(point.row) < limit_count ? 0.0 : -1.0;
    return gradient;
  };
  const VectorX gradient = differentiate_duration(model_, law_.bounds, law_.law, extended_gradient, n + 1);
  if (trajectory_.law.kind == MotionLawKind::time_optimal) return gradient.head(n);
  if (!(gradient[n] < 0)) return VectorX::Zero(n);  // the value at rest alone determines the peak
  return gradient.head(n) * (-law_.peak / law_.bounds[limit_count] / gradient[n]);
}

namespace {

enum class ProfileSection { accelerating, decelerating, sliding };

/// The law between two nodes.
struct SensitivitySection {
  ProfileSection kind = ProfileSection::sliding;
  PathPoint middle, before, after;  ///< with the active row
  double length = 0, time = 0;
  double ratio = 0;     ///< d_dx / d_du in the middle
  VectorX forcing;      ///< −2 slopes / d_du in the middle
  VectorX first, last;  ///< change of x at both ends
};

class DurationSensitivity {
 public:
  DurationSensitivity(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                      const ConstraintGradient& constraint_gradient, Eigen::Index parameters)
      : model_(model), bounds_(bounds), constraint_gradient_(constraint_gradient), parameters_(parameters) {
    for (std::size_t k = 0; k + 1 < law.nodes.size(); ++k)
      if (law.nodes[k + 1].s > law.nodes[k].s) add_section(law.nodes[k], law.nodes[k + 1]);
  }

  VectorX run() {
    for (std::size_t i = 0; i < sections_.size(); ++i)
      if (sections_[i].kind != ProfileSection::decelerating) propagate_forwards(i);
    for (std::size_t i = sections_.size(); i-- > 0;)
      if (sections_[i].kind == ProfileSection::decelerating) propagate_backwards(i);
    VectorX total = VectorX::Zero(parameters_);
    for (const SensitivitySection& section : sections_) {
      const double x0 = section.before.v * section.before.v, x1 = section.after.v * section.after.v;
      const VectorX late = x1 > 0 ? VectorX(section.last / x1) : VectorX(section.first / x0);
      const VectorX early = x0 > 0 ? VectorX(section.first / x0) : late;  // at rest both vanish, but not their ratio
      total -= section.time / 4 * (early + late);
    }
    return total;
  }

 private:
  void add_section(const TimeLawNode& from, const TimeLawNode& to) {
    const ProfilePoint a{from.t, from.s, from.v, from.u_after, -1}, b{to.t, to.s, to.v, to.u_before, -1};
    const ProfilePoint middle = interpolate_at_parameter(a, b, (a.s + b.s) / 2);
    SensitivitySection section;
    section.length = b.s - a.s;
    section.time = b.t - a.t;
    section.middle = {middle.s, middle.v, middle.u, from.row_after};
    if (section.middle.row < 0) section.middle.row = find_most_active_row(section.middle);
    section.before = {a.s, a.v, a.u, section.middle.row};
    section.after = {b.s, b.v, b.u, section.middle.row};
    const ConstraintValue constraint = evaluate_constraint(model_, section.middle);
    if (!constraint.is_velocity_limited) {
      section.kind = constraint.d_du > 0 ? ProfileSection::accelerating : ProfileSection::decelerating;
      section.ratio = constraint.d_dx / constraint.d_du;
      section.forcing = -2 / constraint.d_du * constraint_gradient_(section.middle, constraint);
    }
    sections_.push_back(std::move(section));
  }

  int find_most_active_row(PathPoint point) const {
    double max_limit_ratio = -1;
    int row = 0;
    for (std::size_t r = 0; r < bounds_.size(); ++r) {
      point.row = static_cast<int>(r);
      const double limit_ratio = evaluate_constraint(model_, point).magnitude / bounds_[r];
      if (limit_ratio > max_limit_ratio) max_limit_ratio = limit_ratio, row = static_cast<int>(r);
    }
    return row;
  }

  /// d_du δu + d_dx δx = −slopes, with the mean of both ends and δx' = 2 δu.
  void propagate_forwards(std::size_t i) {
    SensitivitySection& section = sections_[i];
    if (section.kind == ProfileSection::sliding) {
      section.first = sensitivity_on_velocity_bound(section.before);
      section.last = sensitivity_on_velocity_bound(section.after);
      return;
    }
    if (i == 0) {
      section.first = VectorX::Zero(parameters_);
    } else {
      const SensitivitySection& previous = sections_[i - 1];
      section.first = previous.kind == ProfileSection::decelerating
                          ? sensitivity_at_switch_point(previous.after, section.before)
                          : previous.last;
    }
    const double k = section.length * section.ratio;
    section.last = ((1 - k) * section.first + section.length * section.forcing) / (1 + k);
  }

  void propagate_backwards(std::size_t i) {
    SensitivitySection& section = sections_[i];
    const bool is_last = i + 1 == sections_.size();
    section.last = is_last ? VectorX(VectorX::Zero(parameters_)) : sections_[i + 1].first;
    const double k = section.length * section.ratio;
    section.first = ((1 + k) * section.last - section.length * section.forcing) / (1 - k);
  }

  /// If u does not change the magnitude of the row, x alone keeps it at its bound.
  VectorX sensitivity_on_velocity_bound(const PathPoint& point) const {
    const ConstraintValue constraint = evaluate_constraint(model_, point);
    if (!(std::abs(constraint.d_dx) > 0)) return VectorX::Zero(parameters_);
    return -constraint_gradient_(point, constraint) / constraint.d_dx;
  }

  /// Where deceleration ends and acceleration begins: on the maximum velocity curve, which depends on one row or two.
  VectorX sensitivity_at_switch_point(const PathPoint& before, const PathPoint& after) const {
    if (before.row == after.row) return sensitivity_on_velocity_bound(before);
    const ConstraintValue a = evaluate_constraint(model_, before), b = evaluate_constraint(model_, after);
    const double determinant = a.d_du * b.d_dx - b.d_du * a.d_dx;
    if (!(std::abs(determinant) > 0)) return VectorX::Zero(parameters_);
    return (b.d_du * constraint_gradient_(before, a) - a.d_du * constraint_gradient_(after, b)) / determinant;
  }

  const PathModel& model_;
  const std::vector<double>& bounds_;
  const ConstraintGradient& constraint_gradient_;
  Eigen::Index parameters_;
  std::vector<SensitivitySection> sections_;
};

}  // namespace

VectorX differentiate_duration(const PathModel& model, const std::vector<double>& bounds, const TimeOptimalLaw& law,
                               const ConstraintGradient& constraint_gradient, Eigen::Index parameters) {
  return DurationSensitivity(model, bounds, law, constraint_gradient, parameters).run();
}

namespace {

constexpr int intervals_per_panel = 24;  // within each, the distance of a cubic has at most one maximum
constexpr int max_ternary_steps = 40;
constexpr double gauge_tolerance = 1e-9;  // of the width

numerics::PiecewiseChebyshevSeries make_basis_series(int knots) {
  const auto count = static_cast<std::size_t>(knots) + 2;
  std::vector<double> controls(count * count, 0.0);
  for (std::size_t k = 0; k < count; ++k) controls[k * count + k] = 1;
  return trajectory::make_corridor_splines(controls, knots);
}

}  // namespace

CorridorSet::CorridorSet(int knots, Eigen::Index directions)
    : controls_per_direction_(knots + 2), directions_(directions), bases_(make_basis_series(knots)) {}

VectorX CorridorSet::basis_values(std::size_t panel, double s) const {
  VectorX values(controls_per_direction_);
  bases_.evaluate(panel, s, values.data());
  return values;
}

MatrixX CorridorSet::metric() const {
  const numerics::PiecewiseChebyshevSeries second_derivatives = bases_.derivative().derivative();
  MatrixX block = MatrixX::Zero(controls_per_direction_, controls_per_direction_);
  VectorX second_derivative(controls_per_direction_);
  for (std::size_t p = 0; p < bases_.panels().size(); ++p)
    for (const double gauss_point :
         {0.2113248654051871, 0.7886751345948129}) {  // Gauss points, exact for the product of two linear functions
      const numerics::Panel& panel = bases_.panels()[p];
      const double s = panel.begin + (panel.end - panel.begin) * gauss_point;
      second_derivatives.evaluate(p, s, second_derivative.data());
      const VectorX value = basis_values(p, s);
      block += (panel.end - panel.begin) / 2 *
               (second_derivative * second_derivative.transpose() + value * value.transpose());
    }
  MatrixX M = MatrixX::Zero(size(), size());
  for (Eigen::Index m = 0; m < directions_; ++m)
    M.block(m * controls_per_direction_, m * controls_per_direction_, controls_per_direction_,
            controls_per_direction_) = block;
  return M;
}

CorridorSet::OffsetMaximum CorridorSet::offset_at(const VectorX& controls, std::size_t panel, double s) const {
  const VectorX values = basis_values(panel, s);
  VectorX offset(directions_);
  for (Eigen::Index m = 0; m < directions_; ++m)
    offset[m] = values.dot(controls.segment(m * controls_per_direction_, controls_per_direction_));
  return {s, offset.norm(), offset};
}

std::vector<CorridorSet::OffsetMaximum> CorridorSet::offset_maxima(const VectorX& controls) const {
  std::vector<OffsetMaximum> maxima;
  for (std::size_t p = 0; p < bases_.panels().size(); ++p) {
    const double begin = bases_.panels()[p].begin, width = (bases_.panels()[p].end - begin) / intervals_per_panel;
    for (int k = 0; k < intervals_per_panel; ++k) {
      // The distance increases at the beginning of the part and decreases at its end: the maximum is inside.
      double low = begin + k * width, high = low + width;
      const double step = 1e-4 * width;
      const auto is_rising = [&](double s) {
        return offset_at(controls, p, s + step).distance > offset_at(controls, p, s).distance;
      };
      if (!is_rising(low) || is_rising(high - step)) continue;
      for (int halving = 0; halving < max_ternary_steps; ++halving) {
        const double left = low + (high - low) / 3, right = high - (high - low) / 3;
        const bool is_left_lower = offset_at(controls, p, left).distance < offset_at(controls, p, right).distance;
        (is_left_lower ? low : high) = is_left_lower ? left : right;
      }
      maxima.push_back(offset_at(controls, p, (low + high) / 2));
    }
    maxima.push_back(offset_at(controls, p, begin));
  }
  return maxima;
}

double CorridorSet::gauge(const VectorX& controls) const {
  double max_distance = 0;
  for (const OffsetMaximum& maximum : offset_maxima(controls)) max_distance = std::max(max_distance, maximum.distance);
  return max_distance;
}

std::vector<VectorX> CorridorSet::cutting_planes(const VectorX& controls) const {
  std::vector<VectorX> normals;
  for (const OffsetMaximum& maximum : offset_maxima(controls)) {
    if (!(maximum.distance > 1 + gauge_tolerance)) continue;
    const VectorX values = basis_values(panel_at(maximum.s), maximum.s);
    VectorX normal(size());
    for (Eigen::Index m = 0; m < directions_; ++m)
      normal.segment(m * controls_per_direction_, controls_per_direction_) =
          maximum.offset[m] / maximum.distance * values;
    normals.push_back(normal);
  }
  return normals;
}

}  // namespace balance::time_optimal
