#include "balance/motion/time_optimal/path_model.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/sample_evaluator.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <utility>

namespace balance {
namespace {

using Kind = LimitableQuantity::Kind;

/// Coefficients of s'' below this part of those of s'² are round-off.
constexpr double zero_inertia_epsilon = 1e-9;

/// Round-off of a quantity's coefficients, as a part of the forces that go into it.
constexpr double coefficient_round_off_epsilon = 1e-12;

MotionOutcome make_unresolved_path_outcome() {
  return {MotionStatus::limits_not_held,
          0,
          "the efforts along the path change too abruptly for a law to be found: it may come too near to a singularity",
          {}};
}

void merge_breakpoints(std::vector<double>& stations, const std::vector<double>& more) {
  for (const double place : more) {
    const bool known = std::any_of(stations.begin(), stations.end(),
                                   [&](double station) { return std::abs(station - place) < breakpoint_tolerance; });
    if (!known) stations.push_back(place);
  }
  std::sort(stations.begin(), stations.end());
}

/// Where friction jumps, because a coordinate turns back.
FitStatus add_friction_jumps(PathDynamicsSampler& source, std::vector<double>& stations) {
  if (source.friction_count() == 0) return FitStatus::done;
  PiecewiseChebyshevSeries rates;
  const auto sample = [&](const std::vector<double>& places, Samples& rows) {
    return source.sample_friction(places, rows);
  };
  const FitStatus status =
      fit_chebyshev_series(stations, VectorX::Constant(source.friction_count(), 1e-12), sample, rates);
  if (status != FitStatus::done) return status;
  const std::vector<double> ends = stations;
  for (Eigen::Index r = 0; r < rates.function_count(); ++r) merge_breakpoints(stations, find_roots(rates, r));
  return FitStatus::done;
}

/// Per column: what is smaller is round-off, and what comes of it is not resolved.
VectorX estimate_round_off_floor(PathDynamicsSampler& source, const std::vector<double>& stations) {
  std::vector<double> places;
  for (std::size_t i = 0; i + 1 < stations.size(); ++i)
    for (int k = 0; k < 4; ++k) places.push_back(stations[i] + (stations[i + 1] - stations[i]) * (k + 0.5) / 4);
  VectorX floor = VectorX::Zero(source.columns());
  Samples rows;
  if (!source.sample(places, rows)) return floor;
  const PathDynamicsSampler::ReactionMagnitude sizes = source.max_reactions(places);
  for (const CoefficientColumns& limit : source.limits()) {
    const std::string& unit = limit.quantity.unit;
    const auto most = [&](int column) {
      return column < 0 ? 0.0 : max_abs(rows.middleCols(column, limit.quantity.count));
    };
    const double whole =
        std::max({most(limit.a), most(limit.b), unit == "N" ? sizes.force : 0.0, unit == "N m" ? sizes.moment : 0.0});
    for (const int column : {limit.a, limit.b, limit.c, limit.d})
      if (column >= 0)
        floor.segment(column, limit.quantity.count)
            .setConstant(coefficient_round_off_epsilon * whole + 10 * coefficient_round_off_epsilon * most(column));
  }
  return floor;
}

/// The series of `all` with those of p' and p'' of the tool's place appended where rows need them.
Samples append_tool_derivatives(const Panel& panel, const Panel& first, const Panel& second,
                                const std::vector<PathConstraintRow>& rows,
                                const std::vector<CoefficientColumns>& limits, Eigen::Index columns) {
  Samples terms = Samples::Zero(PiecewiseChebyshevSeries::coefficient_count, columns);
  terms.leftCols(panel.coefficients.cols()) = panel.coefficients;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Kind kind = limits[i].quantity.kind;
    const int from = limits[i].c, count = rows[i].count;
    if (kind == Kind::tool_velocity) terms.middleCols(rows[i].d, count) = first.coefficients.middleCols(from, count);
    if (kind != Kind::tool_acceleration) continue;
    terms.middleCols(rows[i].a, count) = first.coefficients.middleCols(from, count);
    terms.middleCols(rows[i].b, count) = second.coefficients.middleCols(from, count);
  }
  return terms;
}

/// Names the columns, those of the tool's rates behind all others.
void add_rows(const std::vector<CoefficientColumns>& limits, PathModel& model, Eigen::Index& columns) {
  for (const CoefficientColumns& limit : limits) {
    PathConstraintRow row{
        limit.quantity.name, limit.quantity.unit, limit.quantity.count, limit.a, limit.b, limit.c, limit.d};
    const auto take = [&](int& column) {
      column = static_cast<int>(columns);
      columns += row.count;
    };
    const Kind kind = limit.quantity.kind;
    if (kind == Kind::tool_velocity || kind == Kind::tool_acceleration) row.c = -1;
    if (kind == Kind::tool_velocity) take(row.d);
    if (kind == Kind::tool_acceleration) take(row.a), take(row.b);
    model.rows.push_back(std::move(row));
  }
}

void find_max_magnitudes(PathModel& model) {
  model.max_magnitude.setZero(model.value.function_count());
  VectorX values(model.value.function_count());
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 16; ++k) {
      model.value.evaluate(p, panel.begin + (panel.end - panel.begin) * k / 16, values.data());
      model.max_magnitude = model.max_magnitude.cwiseMax(values.cwiseAbs());
    }
  }
}

/// What is round-off all along is zero.
void drop_round_off_columns(const VectorX& floor, PathModel& model) {
  for (PathConstraintRow& row : model.rows)
    for (int* column : {&row.a, &row.b, &row.c, &row.d})
      if (*column >= 0 && *column < floor.size() &&
          max_abs(model.max_magnitude.segment(*column, row.count)) <= 10 * max_abs(floor.segment(*column, row.count)))
        *column = -1;
}

double largest(const PathModel& model, int column, int count) {
  return column < 0 ? 0 : max_abs(model.max_magnitude.segment(column, count));
}

/// Rows without inertia limit the speed alone; where the others have none, u is not theirs to limit.
void find_zero_inertia(PathModel& model) {
  for (PathConstraintRow& row : model.rows) {
    const double a = largest(model, row.a, row.count), b = largest(model, row.b, row.count);
    row.has_acceleration_term = a > zero_inertia_epsilon * b && a > 0;
    if (!row.has_acceleration_term) continue;
    for (int i = 0; i < row.count; ++i) {
      for (const double place : find_roots(model.value, row.a + i)) {
        VectorX values(model.value.function_count());
        model.value.evaluate(model.value.find_panel(place, 0, model.value.panels().size()), place, values.data());
        if (values.segment(row.a, row.count).norm() < 1e-7 * a) {
          merge_breakpoints(model.zero_inertia_points, {place});
          merge_breakpoints(model.breakpoints, {place});
        }
      }
    }
  }
}

void assemble_path_model(const PathDynamicsSampler& source, const PiecewiseChebyshevSeries& sampled,
                         const VectorX& floor, PathModel& model) {
  Eigen::Index columns = sampled.function_count();
  add_rows(source.limits(), model, columns);
  const PiecewiseChebyshevSeries first = sampled.derivative(), second = first.derivative();
  std::vector<Panel> panels = sampled.panels();
  for (std::size_t p = 0; p < panels.size(); ++p)
    panels[p].coefficients = append_tool_derivatives(sampled.panels()[p], first.panels()[p], second.panels()[p],
                                                     model.rows, source.limits(), columns);
  model.value = PiecewiseChebyshevSeries(std::move(panels));
  model.first = model.value.derivative();
  model.second = model.first.derivative();
  find_max_magnitudes(model);
  drop_round_off_columns(floor, model);
  find_zero_inertia(model);
}

}  // namespace

PathModel build_path_model(const Mechanism& mechanism, const Trajectory& trajectory,
                           const std::vector<LimitableQuantity>& quantities) {
  PathModel model;
  const auto source = make_path_dynamics_sampler(mechanism, trajectory, quantities);
  model.outcome = source->outcome();
  if (model.outcome.status != MotionStatus::done) return model;
  model.segment_ends = source->leg_ends();
  model.breakpoints = model.segment_ends;
  merge_breakpoints(model.breakpoints, source->knots());
  model.start_speed = source->start_speed();
  model.end_speed = source->end_speed();
  FitStatus status = add_friction_jumps(*source, model.breakpoints);
  PiecewiseChebyshevSeries sampled;
  VectorX floor;
  if (status == FitStatus::done) {
    const auto sample = [&](const std::vector<double>& places, Samples& rows) { return source->sample(places, rows); };
    floor = estimate_round_off_floor(*source, model.breakpoints);
    status = fit_chebyshev_series(model.breakpoints, floor, sample, sampled);
  }
  if (status == FitStatus::not_sampled) model.outcome = source->outcome();
  if (status == FitStatus::not_resolved) model.outcome = make_unresolved_path_outcome();
  if (status == FitStatus::done) assemble_path_model(*source, sampled, floor, model);
  return model;
}

/// Sign changes between the points of a fine grid, halved to the last digit.
std::vector<double> find_roots(const PiecewiseChebyshevSeries& series, Eigen::Index function) {
  constexpr int intervals_per_panel = 32;
  std::vector<double> places;
  VectorX values(series.function_count());
  for (std::size_t p = 0; p < series.panels().size(); ++p) {
    const Panel& panel = series.panels()[p];
    const auto at = [&](double place) {
      series.evaluate(p, place, values.data());
      return values[function];
    };
    double left = panel.begin, at_left = at(left);
    for (int k = 1; k <= intervals_per_panel; ++k) {
      const double right =
          k == intervals_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / intervals_per_panel;
      const double at_right = at(right);
      if (at_left == 0 || (at_left < 0) != (at_right < 0)) {
        double low = left, high = right;
        for (int halving = 0; halving < 60 && low < high; ++halving) {
          const double middle = (low + high) / 2;
          ((at(middle) < 0) == (at_left < 0) ? low : high) = middle;
        }
        places.push_back((low + high) / 2);
      }
      left = right;
      at_left = at_right;
    }
  }
  return places;
}

Trajectory reparametrise_by_path(Trajectory trajectory) {
  trajectory.law = {.kind = MotionLawKind::uniform};
  trajectory.duration = 1;
  if (auto* table = std::get_if<TablePath>(&trajectory.path); table != nullptr && table->time.size() > 1) {
    const double first = table->time.front(), duration = table->time.back() - first;
    if (duration > 0 && std::isfinite(duration))
      for (double& time : table->time) time = (time - first) / duration;
  }
  return trajectory;
}

namespace {

using Kind = LimitableQuantity::Kind;

constexpr int motion_check_points = 32;   // places, for whether anything moves
constexpr double motion_epsilon = 1e-12;  // of a radian, or of the mechanism's size

/// "at t = 0.3 s: …" of the run with one second: "at 30 % of the path: …".
MotionOutcome at_path_parameter(MotionOutcome outcome) {
  const std::string prefix = format_time_prefix(outcome.time);
  if (outcome.reason.starts_with(prefix)) {
    char text[64];
    std::snprintf(text, sizeof text, "at %.6g %% of the path: ", 100 * outcome.time);
    outcome.reason = text + outcome.reason.substr(prefix.size());
  }
  outcome.time = 0;
  return outcome;
}

bool needs_everything(const LimitableQuantity& quantity) {
  for (const char* name : {"com_velocity", "joint_force", "joint_moment", "kinetic_energy", "shaking_moment_com"})
    if (quantity.name.starts_with(name)) return true;
  return false;
}

template <class S>
class PathDynamicsSamplerOf : public PathDynamicsSampler {
 public:
  PathDynamicsSamplerOf(const Mechanism& mechanism, const Trajectory& trajectory,
                        const std::vector<LimitableQuantity>& quantities)
      : mechanism_(mechanism),
        trajectory_(reparametrise_by_path(trajectory)),
        tree_(compile_tree<S>(mechanism, prescribed_coordinates(trajectory_))),
        compiled_tree_(tree_),
        plan_(compile_trajectory(mechanism, tree_, trajectory_)) {
    outcome_ = plan_.outcome;
    if (outcome_.status != MotionStatus::done) return;
    observer_.emplace(mechanism_, tree_, plan_.freedoms, to_vector<S>(trajectory_.about));
    if (!observer_->actuation().mismatch().empty()) {
      outcome_ = {MotionStatus::mismatch, 0, observer_->actuation().mismatch(), {}};
      return;
    }
    if (!is_moving()) {
      outcome_ = {MotionStatus::limits_not_held, 0, "the path ends where it begins, and nothing moves on it", {}};
      return;
    }
    quantities_ = plan_.quantities;
    leg_ends_ = plan_.prescribed_motion->segment_end_times();
    knots_ = plan_.prescribed_motion->knot_times();
    leg_ends_.insert(leg_ends_.begin(), 0);
    leg_ends_.push_back(1);
    start_speed_ = speed(0, Side::after);
    end_speed_ = speed(1, Side::before);
    for (const Friction& friction : mechanism.friction)
      if (friction.dry_friction(1) != 0 || friction.dry_friction(-1) != 0) friction_.push_back(friction.coordinate);
    for (const LimitableQuantity& quantity : quantities) add(quantity);
    rate_.assign(static_cast<std::size_t>(tree_.columns), 0);
    second_ = rate_;
  }

  bool sample(const std::vector<double>& places, Samples& rows) override {
    rows.setZero(static_cast<Eigen::Index>(places.size()), columns_);
    return visit_path_points(places,
                             [&](MotionStepper<S>& stepper, Eigen::Index row) { fill(stepper, &rows(row, 0)); });
  }

  bool sample_friction(const std::vector<double>& places, Samples& rows) override {
    rows.setZero(static_cast<Eigen::Index>(places.size()), friction_count());
    return visit_path_points(places, [&](MotionStepper<S>& stepper, Eigen::Index row) {
      observer_->update_coordinates(
          {stepper.state(), stepper.y(), stepper.dy(), stepper.ddy(), stepper.time(), stepper.is_explicit()});
      for (std::size_t i = 0; i < friction_.size(); ++i)
        rows(row, static_cast<Eigen::Index>(i)) = observer_->sample().velocity[friction_[i]];
    });
  }

  ReactionMagnitude max_reactions(const std::vector<double>& places) override {
    ReactionMagnitude sizes;
    const bool usual = std::exchange(all_detail_, true);
    visit_path_points(places, [&](MotionStepper<S>& stepper, Eigen::Index) {
      for (const auto& [ds, dds] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
        const Sample& seen = observe(stepper, ds, dds);
        for (const Vector3& force : seen.joint_force) sizes.force = std::max(sizes.force, force.norm());
        for (const Vector3& moment : seen.joint_moment) sizes.moment = std::max(sizes.moment, moment.norm());
      }
    });
    sizes.moment = std::max(sizes.moment, sizes.force * tree_.characteristic_length);
    all_detail_ = usual;
    return sizes;
  }

  int friction_count() const override { return static_cast<int>(friction_.size()); }

 private:
  /// Whether what is driven changes by more than round-off.
  bool is_moving() const {
    DriveSample sample;
    for (int k = 0; k < motion_check_points; ++k) {
      plan_.prescribed_motion->at((k + 0.5) / motion_check_points, Side::after, sample);
      if (max_abs(sample.rate) > motion_epsilon * std::min(1.0, tree_.characteristic_length)) return true;
    }
    return false;
  }

  double speed(double time, Side side) const {
    DriveSample sample;
    plan_.prescribed_motion->at(time, side, sample);
    const std::size_t point = std::max(plan_.drive.point.size(), plan_.drive.com.size());
    return point > 0 ? sample.rate.head(static_cast<Eigen::Index>(point)).norm() : sample.rate.norm();
  }

  void add(const LimitableQuantity& quantity) {
    CoefficientColumns limit{quantity};
    const auto take = [&](int& column) {
      column = columns_;
      columns_ += quantity.count;
    };
    const bool tool = quantity.kind == Kind::tool_velocity || quantity.kind == Kind::tool_acceleration;
    if (quantity.kind == Kind::force) take(limit.a), take(limit.b), take(limit.c);
    if (quantity.kind == Kind::force && !mechanism_.friction.empty()) take(limit.d);
    if (quantity.kind == Kind::rate) take(limit.d);
    if (quantity.kind == Kind::energy) take(limit.b);
    if (tool) take(limit.c);  // the place itself, which is differentiated later
    all_detail_ = all_detail_ || needs_everything(quantity);
    limits_.push_back(limit);
  }

  template <class See>
  bool visit_path_points(const std::vector<double>& places, See see) {
    tree_ = compiled_tree_;  // a stepper turns the axes of spherical joints on its way
    MotionStepper<S> stepper(mechanism_, tree_, plan_);
    stepper.set_regularity_monitor(observer_->regularity_monitor());
    observer_->restart();
    std::size_t leg = 1;
    Eigen::Index row = 0;
    bool moves = stepper.begin();
    for (auto place = places.begin(); moves && place != places.end(); ++place) {
      for (; moves && leg_ends_[leg] < *place; ++leg) {
        moves = stepper.time() >= leg_ends_[leg] || stepper.advance(leg_ends_[leg]);
        if (moves) stepper.update_accelerations(Side::after);
      }
      moves = moves && (*place <= stepper.time() || stepper.advance(*place));
      if (moves) see(stepper, row++);
    }
    if (!moves) outcome_ = at_path_parameter(stepper.outcome());
    return moves;
  }

  /// Everything at rates s' and accelerations s'' of the path's parameter.
  const Sample& observe(MotionStepper<S>& stepper, double ds, double dds) {
    for (int c = 0; c < tree_.columns; ++c) {
      rate_[c] = ds * stepper.dy()[c];
      second_[c] = ds * ds * stepper.ddy()[c] + dds * stepper.dy()[c];
    }
    if (!stepper.is_explicit()) compute_angular_velocities(tree_, rate_.data(), stepper.state());
    observer_->evaluate(
        {stepper.state(), stepper.y(), rate_.data(), second_.data(), stepper.time(), stepper.is_explicit()},
        stepper.equations(), 1, all_detail_ ? Detail::all : Detail::forces);
    return observer_->sample();
  }

  /// At rest, with s'' = 1, and with s' = 1 the quantities are c, a + c and b + c (+ friction). Friction adds f + d s', f dry: from
  /// s' = 1, 2, 3 by differences, b = (v₃ − 2v₂ + v₁)/2, d = v₂ − v₁ − 3b, and what moves needs c + f instead of c.
  void fill(MotionStepper<S>& stepper, double* row) {
    const auto see = [&](double ds, double dds, auto put) {
      const Sample& seen = observe(stepper, ds, dds);
      for (const CoefficientColumns& limit : limits_) {
        const double* values = limit.quantity.values(seen) + limit.quantity.first;
        for (int i = 0; i < limit.quantity.count; ++i) put(limit, i, values[i]);
      }
    };
    const auto add = [row](int column, int i, double value) {
      if (column >= 0) row[column + i] += value;
    };
    const bool rubs = !mechanism_.friction.empty();
    see(0, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind == Kind::energy || l.quantity.kind == Kind::rate) return;
      add(l.c, i, v);
      add(l.a, i, -v);
      if (!rubs) add(l.b, i, -v);
    });
    see(0, 1, [&](const CoefficientColumns& l, int i, double v) { add(l.a, i, v); });
    see(1, 0, [&](const CoefficientColumns& l, int i, double v) {
      const bool simple = !rubs || l.quantity.kind != Kind::force;
      if (l.quantity.kind == Kind::rate) return add(l.d, i, v);
      if (simple) return add(l.b, i, v);
      add(l.b, i, v / 2);
      add(l.d, i, -2.5 * v);
      if (l.c >= 0) row[l.c + i] = 3 * v;
    });
    if (!rubs) return;
    see(2, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind != Kind::force) return;
      add(l.b, i, -v);
      add(l.d, i, 4 * v);
      add(l.c, i, -3 * v);
    });
    see(3, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind != Kind::force) return;
      add(l.b, i, v / 2);
      add(l.d, i, -1.5 * v);
      add(l.c, i, v);
    });
  }

  const Mechanism& mechanism_;
  Trajectory trajectory_;
  Tree<S> tree_;
  const Tree<S> compiled_tree_;
  CompiledTrajectory<S> plan_;
  std::optional<SampleEvaluator<S>> observer_;
  bool all_detail_ = false;
  std::vector<int> friction_;
  std::vector<double> rate_, second_;
};

}  // namespace

std::unique_ptr<PathDynamicsSampler> make_path_dynamics_sampler(const Mechanism& mechanism,
                                                                const Trajectory& trajectory,
                                                                const std::vector<LimitableQuantity>& quantities) {
  return dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<PathDynamicsSampler> {
    return std::make_unique<PathDynamicsSamplerOf<S>>(mechanism, trajectory, quantities);
  });
}

namespace {

constexpr double right_angle_tolerance = 1e-5;  // cosine

}  // namespace

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& moment) {
  const PathConstraintRow& row = model.rows[static_cast<std::size_t>(moment.row)];
  VectorX columns(model.value.function_count());
  model.value.evaluate(model.value.find_panel(moment.s, 0, model.value.panels().size()), moment.s, columns.data());
  const auto part = [&](int column) {
    return column < 0 ? VectorX(VectorX::Zero(row.count)) : VectorX(columns.segment(column, row.count));
  };
  const VectorX a = part(row.a), b = part(row.b), d = part(row.d);
  ConstraintValue here;
  here.value = a * moment.u + b * (moment.v * moment.v) + part(row.c) + d * moment.v;
  if (row.count == 1) here.value[0] -= row.centre;
  here.magnitude = here.value.norm();
  if (!(here.magnitude > 0)) return here;
  const VectorX along = here.value / here.magnitude;
  here.d_du = along.dot(a);
  here.d_dx = along.dot(b) + (moment.v > 0 ? along.dot(d) / (2 * moment.v) : 0);
  here.is_velocity_limited = !row.has_acceleration_term || !(std::abs(here.d_du) > right_angle_tolerance * a.norm());
  return here;
}

namespace {

void check_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  for (const MotionLimit& limit : trajectory.limits) {
    const double least = limit.lower_bound.value_or(-limit.upper_bound);
    if (!(least < limit.upper_bound) || !std::isfinite(least) || !std::isfinite(limit.upper_bound))
      throw std::invalid_argument(
          "the limit of " + limit.quantity +
          (limit.lower_bound ? " must have a least value below the largest one" : " must be positive"));
  }
  if (!trajectory.limits.empty()) require_constant_loads(mechanism, "what limits leave");
}

}  // namespace

std::vector<LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name) {
  std::vector<LimitableQuantity> found = find_limitable_quantities(mechanism, name);
  if (found.empty()) throw std::invalid_argument("no law of motion can limit '" + name + "' of this mechanism");
  return found;
}

void require_constant_loads(const Mechanism& mechanism, const std::string& what) {
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 1; k < load.force.size(); ++k)
      if (load.force[k] != load.force[0] || load.moment[k] != load.moment[0])
        throw std::invalid_argument(what + " cannot be found under the load " + load.name +
                                    ", which changes with time");
}

PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  check_limits(mechanism, trajectory);
  PathLimits all;
  for (const MotionLimit& limit : trajectory.limits)
    for (const LimitableQuantity& quantity : require_limited_quantities(mechanism, limit.quantity)) {
      if (limit.lower_bound && quantity.count > 1)
        throw std::invalid_argument("the magnitude of " + quantity.name + " has no least value: limit a component");
      const double least = limit.lower_bound.value_or(-limit.upper_bound);
      all.quantities.push_back(quantity);
      all.half_widths.push_back((limit.upper_bound - least) / 2);
      all.centres.push_back((limit.upper_bound + least) / 2);
    }
  return all;
}

PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits) {
  PathModel model = build_path_model(mechanism, trajectory, limits.quantities);
  for (std::size_t r = 0; r < std::min(model.rows.size(), limits.centres.size()); ++r)
    model.rows[r].centre = limits.centres[r];
  return model;
}

}  // namespace balance
