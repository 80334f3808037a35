#include "balance/motion/time_optimal/path_model.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace balance::time_optimal {

using numerics::FitStatus;
using results::LimitableQuantity;

namespace {

using Kind = LimitableQuantity::Kind;

/// Coefficients of s'' below this fraction of those of s'² are round-off.
constexpr double zero_inertia_epsilon = 1e-9;

/// Round-off of a quantity's coefficients, as a fraction of the forces that contribute to it.
constexpr double coefficient_round_off_epsilon = 1e-12;

MotionOutcome make_unresolved_path_outcome() {
  return {MotionStatus::limits_not_held,
          0,
          "the efforts along the path change too abruptly for a law to be found: it may come too near to a singularity",
          {}};
}

void merge_breakpoints(std::vector<double>& breakpoints, const std::vector<double>& additional) {
  for (const double s : additional) {
    const bool is_known = std::any_of(breakpoints.begin(), breakpoints.end(), [&](double breakpoint) {
      return std::abs(breakpoint - s) < breakpoint_tolerance;
    });
    if (!is_known) breakpoints.push_back(s);
  }
  std::sort(breakpoints.begin(), breakpoints.end());
}

/// Adds points where friction jumps, because a coordinate reverses.
FitStatus add_friction_jumps(PathDynamicsSampler& sampler, std::vector<double>& breakpoints) {
  if (sampler.friction_count() == 0) return FitStatus::done;
  numerics::PiecewiseChebyshevSeries rates;
  const auto sample = [&](const std::vector<double>& path_parameters, Samples& rows) {
    return sampler.sample_friction(path_parameters, rows);
  };
  const FitStatus status =
      fit_chebyshev_series(breakpoints, VectorX::Constant(sampler.friction_count(), 1e-12), sample, rates);
  if (status != FitStatus::done) return status;
  for (Eigen::Index r = 0; r < rates.function_count(); ++r) merge_breakpoints(breakpoints, find_roots(rates, r));
  return FitStatus::done;
}

/// Round-off of each column; smaller features are not resolved.
VectorX estimate_round_off_floor(PathDynamicsSampler& sampler, const std::vector<double>& breakpoints) {
  std::vector<double> path_parameters;
  for (std::size_t i = 0; i + 1 < breakpoints.size(); ++i)
    for (int k = 0; k < 4; ++k)
      path_parameters.push_back(breakpoints[i] + (breakpoints[i + 1] - breakpoints[i]) * (k + 0.5) / 4);
  VectorX floor = VectorX::Zero(sampler.columns());
  Samples rows;
  if (!sampler.sample(path_parameters, rows)) return floor;
  const PathDynamicsSampler::ReactionMagnitude reactions = sampler.max_reactions(path_parameters);
  for (const CoefficientColumns& limit : sampler.limits()) {
    const std::string& unit = limit.quantity.unit;
    const auto max_magnitude = [&](int column) {
      return column < 0 ? 0.0 : numerics::max_abs(rows.middleCols(column, limit.quantity.count));
    };
    const double scale = std::max({max_magnitude(limit.a), max_magnitude(limit.b), unit == "N" ? reactions.force : 0.0,
                                   unit == "N m" ? reactions.moment : 0.0});
    for (const int column : {limit.a, limit.b, limit.c, limit.d})
      if (column >= 0)
        floor.segment(column, limit.quantity.count)
            .setConstant(coefficient_round_off_epsilon * scale +
                         10 * coefficient_round_off_epsilon * max_magnitude(column));
  }
  return floor;
}

/// The series of `panel`, followed by p' and p'' of the tool's position for the rows that need them.
Samples append_tool_derivatives(const numerics::Panel& panel, const numerics::Panel& first,
                                const numerics::Panel& second, const std::vector<PathConstraintRow>& rows,
                                const std::vector<CoefficientColumns>& limits, Eigen::Index columns) {
  Samples terms = Samples::Zero(numerics::PiecewiseChebyshevSeries::coefficient_count, columns);
  terms.leftCols(panel.coefficients.cols()) = panel.coefficients;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Kind kind = limits[i].quantity.kind;
    const int position_column = limits[i].c, count = rows[i].count;
    if (kind == Kind::tool_velocity)
      terms.middleCols(rows[i].d, count) = first.coefficients.middleCols(position_column, count);
    if (kind != Kind::tool_acceleration) continue;
    terms.middleCols(rows[i].a, count) = first.coefficients.middleCols(position_column, count);
    terms.middleCols(rows[i].b, count) = second.coefficients.middleCols(position_column, count);
  }
  return terms;
}

/// Adds a row per limit. Columns of the tool's rates come after all others.
void add_rows(const std::vector<CoefficientColumns>& limits, PathModel& model, Eigen::Index& columns) {
  for (const CoefficientColumns& limit : limits) {
    PathConstraintRow row{
        limit.quantity.name, limit.quantity.unit, limit.quantity.count, limit.a, limit.b, limit.c, limit.d};
    const auto allocate = [&](int& column) {
      column = static_cast<int>(columns);
      columns += row.count;
    };
    const Kind kind = limit.quantity.kind;
    if (kind == Kind::tool_velocity || kind == Kind::tool_acceleration) row.c = -1;
    if (kind == Kind::tool_velocity) allocate(row.d);
    if (kind == Kind::tool_acceleration) allocate(row.a), allocate(row.b);
    model.rows.push_back(std::move(row));
  }
}

void find_max_magnitudes(PathModel& model) {
  model.max_magnitude.setZero(model.value.function_count());
  VectorX values(model.value.function_count());
  for (std::size_t p = 0; p < model.value.panels().size(); ++p) {
    const numerics::Panel& panel = model.value.panels()[p];
    for (int k = 0; k <= 16; ++k) {
      model.value.evaluate(p, panel.begin + (panel.end - panel.begin) * k / 16, values.data());
      model.max_magnitude = model.max_magnitude.cwiseMax(values.cwiseAbs());
    }
  }
}

/// Removes columns that are round-off everywhere.
void drop_round_off_columns(const VectorX& floor, PathModel& model) {
  for (PathConstraintRow& row : model.rows)
    for (int* column : {&row.a, &row.b, &row.c, &row.d})
      if (*column >= 0 && *column < floor.size() &&
          numerics::max_abs(model.max_magnitude.segment(*column, row.count)) <=
              10 * numerics::max_abs(floor.segment(*column, row.count)))
        *column = -1;
}

double max_column_magnitude(const PathModel& model, int column, int count) {
  return column < 0 ? 0 : numerics::max_abs(model.max_magnitude.segment(column, count));
}

/// Rows without inertia limit only the rate. So do the other rows where their a vanishes.
void find_zero_inertia(PathModel& model) {
  for (PathConstraintRow& row : model.rows) {
    const double a = max_column_magnitude(model, row.a, row.count), b = max_column_magnitude(model, row.b, row.count);
    row.has_acceleration_term = a > zero_inertia_epsilon * b && a > 0;
    if (!row.has_acceleration_term) continue;
    for (int i = 0; i < row.count; ++i) {
      for (const double s : find_roots(model.value, row.a + i)) {
        VectorX values(model.value.function_count());
        model.value.evaluate(model.value.find_panel(s, 0, model.value.panels().size()), s, values.data());
        if (values.segment(row.a, row.count).norm() < 1e-7 * a) {
          merge_breakpoints(model.zero_inertia_points, {s});
          merge_breakpoints(model.breakpoints, {s});
        }
      }
    }
  }
}

void assemble_path_model(const PathDynamicsSampler& sampler, const numerics::PiecewiseChebyshevSeries& sampled,
                         const VectorX& floor, PathModel& model) {
  Eigen::Index columns = sampled.function_count();
  add_rows(sampler.limits(), model, columns);
  const numerics::PiecewiseChebyshevSeries first = sampled.derivative(), second = first.derivative();
  std::vector<numerics::Panel> panels = sampled.panels();
  for (std::size_t p = 0; p < panels.size(); ++p)
    panels[p].coefficients = append_tool_derivatives(sampled.panels()[p], first.panels()[p], second.panels()[p],
                                                     model.rows, sampler.limits(), columns);
  model.value = numerics::PiecewiseChebyshevSeries(std::move(panels));
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
  const auto sampler = make_path_dynamics_sampler(mechanism, trajectory, quantities);
  model.outcome = sampler->outcome();
  if (model.outcome.status != MotionStatus::done) return model;
  model.segment_ends = sampler->leg_ends();
  model.breakpoints = model.segment_ends;
  merge_breakpoints(model.breakpoints, sampler->knots());
  model.start_speed = sampler->start_speed();
  model.end_speed = sampler->end_speed();
  FitStatus status = add_friction_jumps(*sampler, model.breakpoints);
  numerics::PiecewiseChebyshevSeries sampled;
  VectorX floor;
  if (status == FitStatus::done) {
    const auto sample = [&](const std::vector<double>& path_parameters, Samples& rows) {
      return sampler->sample(path_parameters, rows);
    };
    floor = estimate_round_off_floor(*sampler, model.breakpoints);
    status = fit_chebyshev_series(model.breakpoints, floor, sample, sampled);
  }
  if (status == FitStatus::not_sampled) model.outcome = sampler->outcome();
  if (status == FitStatus::not_resolved) model.outcome = make_unresolved_path_outcome();
  if (status == FitStatus::done) assemble_path_model(*sampler, sampled, floor, model);
  return model;
}

/// Bisects sign changes on a fine grid to full precision.
std::vector<double> find_roots(const numerics::PiecewiseChebyshevSeries& series, Eigen::Index function) {
  constexpr int intervals_per_panel = 32;
  std::vector<double> roots;
  VectorX values(series.function_count());
  for (std::size_t p = 0; p < series.panels().size(); ++p) {
    const numerics::Panel& panel = series.panels()[p];
    const auto evaluate_at = [&](double s) {
      series.evaluate(p, s, values.data());
      return values[function];
    };
    double left = panel.begin, left_value = evaluate_at(left);
    for (int k = 1; k <= intervals_per_panel; ++k) {
      const double right =
          k == intervals_per_panel ? panel.end : panel.begin + (panel.end - panel.begin) * k / intervals_per_panel;
      const double right_value = evaluate_at(right);
      if (left_value == 0 || (left_value < 0) != (right_value < 0)) {
        double low = left, high = right;
        for (int halving = 0; halving < 60 && low < high; ++halving) {
          const double middle = (low + high) / 2;
          ((evaluate_at(middle) < 0) == (left_value < 0) ? low : high) = middle;
        }
        roots.push_back((low + high) / 2);
      }
      left = right;
      left_value = right_value;
    }
  }
  return roots;
}

Trajectory reparametrise_by_path(Trajectory trajectory) {
  trajectory.law = {.kind = MotionLawKind::uniform};
  trajectory.duration = 1;
  if (auto* table = std::get_if<trajectory::TablePath>(&trajectory.path); table != nullptr && table->time.size() > 1) {
    const double first = table->time.front(), duration = table->time.back() - first;
    if (duration > 0 && std::isfinite(duration))
      for (double& time : table->time) time = (time - first) / duration;
  }
  return trajectory;
}

namespace {

using Kind = LimitableQuantity::Kind;

constexpr int motion_check_points = 32;   // to check whether anything moves
constexpr double motion_epsilon = 1e-12;  // of a radian, or of the characteristic length

/// "at t = 0.3 s: …" of the run in one second becomes "at 30 % of the path: …".
MotionOutcome replace_time_prefix(MotionOutcome outcome) {
  const std::string prefix = trajectory::format_time_prefix(outcome.time);
  if (outcome.reason.starts_with(prefix)) {
    char text[64];
    std::snprintf(text, sizeof text, "at %.6g %% of the path: ", 100 * outcome.time);
    outcome.reason = text + outcome.reason.substr(prefix.size());
  }
  outcome.time = 0;
  return outcome;
}

/// Whether it depends on how efforts are distributed over redundant actuators.
bool depends_on_distribution(const LimitableQuantity& quantity) {
  for (const char* name : {"torque", "total_torque", "joint_force", "joint_moment"})
    if (quantity.name.starts_with(name)) return true;
  return false;
}

std::string describe_unlimitable(const std::string& quantity) {
  return "torque_distribution: a law with a limit of '" + quantity +
         "' can only be found for the method least-norm without limits and preload, where the efforts are linear "
         "in the forces";
}

bool needs_all_details(const LimitableQuantity& quantity) {
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
        path_(mechanism, trajectory_),
        has_rate_terms_(!mechanism.friction.empty() ||
                        std::any_of(mechanism.force_elements.begin(), mechanism.force_elements.end(),
                                    [](const ForceElement& element) { return element.is_damper(); })) {
    dynamics::TreeMotionSource<S> source = make_source();
    outcome_ = source.outcome();
    if (outcome_.status != MotionStatus::done) return;
    const auto limited = std::find_if(quantities.begin(), quantities.end(), depends_on_distribution);
    if (limited != quantities.end() && !source.evaluator().actuation().has_linear_projection()) {
      outcome_ = {MotionStatus::mismatch, 0, describe_unlimitable(limited->name), {}};
      return;
    }
    if (!is_moving()) {
      outcome_ = {MotionStatus::limits_not_held, 0, "the path ends where it begins, and nothing moves on it", {}};
      return;
    }
    quantities_ = path_.plan.quantities;
    leg_ends_ = path_.plan.prescribed_motion->segment_end_times();
    knots_ = path_.plan.prescribed_motion->knot_times();
    leg_ends_.insert(leg_ends_.begin(), 0);
    leg_ends_.push_back(1);
    start_speed_ = speed(0, trajectory::Side::after);
    end_speed_ = speed(1, trajectory::Side::before);
    for (const Friction& friction : mechanism.friction)
      if (friction.dry_friction(1) != 0 || friction.dry_friction(-1) != 0) friction_.push_back(friction.coordinate);
    for (const LimitableQuantity& quantity : quantities) add_quantity(quantity);
    rate_.assign(static_cast<std::size_t>(path_.tree.columns), 0);
    acceleration_ = rate_;
  }

  bool sample(const std::vector<double>& path_parameters, Samples& rows) override {
    rows.setZero(static_cast<Eigen::Index>(path_parameters.size()), columns_);
    return visit_path_points(
        path_parameters, [&](dynamics::TreeMotionSource<S>& source, Eigen::Index row) { fill(source, &rows(row, 0)); });
  }

  bool sample_friction(const std::vector<double>& path_parameters, Samples& rows) override {
    rows.setZero(static_cast<Eigen::Index>(path_parameters.size()), friction_count());
    return visit_path_points(path_parameters, [&](dynamics::TreeMotionSource<S>& source, Eigen::Index row) {
      source.evaluator().evaluate(source.stepper(), dynamics::Detail::kinematics);
      for (std::size_t i = 0; i < friction_.size(); ++i)
        rows(row, static_cast<Eigen::Index>(i)) = source.sample().velocity[friction_[i]];
    });
  }

  ReactionMagnitude max_reactions(const std::vector<double>& path_parameters) override {
    ReactionMagnitude reactions;
    const bool previous_detail = std::exchange(all_detail_, true);
    visit_path_points(path_parameters, [&](dynamics::TreeMotionSource<S>& source, Eigen::Index) {
      for (const auto& [ds, dds] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
        const Sample& observed = observe(source, ds, dds);
        for (const Vector3& force : observed.joint_force) reactions.force = std::max(reactions.force, force.norm());
        for (const Vector3& moment : observed.joint_moment)
          reactions.moment = std::max(reactions.moment, moment.norm());
      }
    });
    reactions.moment = std::max(reactions.moment, reactions.force * path_.tree.characteristic_length);
    all_detail_ = previous_detail;
    return reactions;
  }

  int friction_count() const override { return static_cast<int>(friction_.size()); }

 private:
  /// Whether driven quantities change by more than round-off.
  bool is_moving() const {
    trajectory::DriveSample sample;
    for (int k = 0; k < motion_check_points; ++k) {
      path_.plan.prescribed_motion->at((k + 0.5) / motion_check_points, trajectory::Side::after, sample);
      if (numerics::max_abs(sample.rate) > motion_epsilon * std::min(1.0, path_.tree.characteristic_length))
        return true;
    }
    return false;
  }

  double speed(double time, trajectory::Side side) const {
    trajectory::DriveSample sample;
    path_.plan.prescribed_motion->at(time, side, sample);
    const std::size_t point = std::max(path_.plan.drive.point.size(), path_.plan.drive.com.size());
    return point > 0 ? sample.rate.head(static_cast<Eigen::Index>(point)).norm() : sample.rate.norm();
  }

  void add_quantity(const LimitableQuantity& quantity) {
    CoefficientColumns limit{quantity};
    const auto allocate = [&](int& column) {
      column = columns_;
      columns_ += quantity.count;
    };
    const bool is_tool_quantity = quantity.kind == Kind::tool_velocity || quantity.kind == Kind::tool_acceleration;
    if (quantity.kind == Kind::force) allocate(limit.a), allocate(limit.b), allocate(limit.c);
    if (quantity.kind == Kind::force && has_rate_terms_) allocate(limit.d);
    if (quantity.kind == Kind::rate) allocate(limit.d);
    if (quantity.kind == Kind::energy) allocate(limit.b);
    if (is_tool_quantity) allocate(limit.c);  // the position itself, which is differentiated later
    all_detail_ = all_detail_ || needs_all_details(quantity);
    limits_.push_back(limit);
  }

  dynamics::TreeMotionSource<S> make_source() const {
    return {mechanism_, path_, trajectory_.about, all_detail_ ? dynamics::Detail::all : dynamics::Detail::forces};
  }

  template <class Visit>
  bool visit_path_points(const std::vector<double>& path_parameters, Visit visit) {
    dynamics::TreeMotionSource<S> source = make_source();
    Eigen::Index row = 0;
    const bool is_feasible =
        visit_times(source, source.prescribed_motion().segment_end_times(), path_parameters, [&](bool is_leg_end) {
          is_leg_end ? source.update_accelerations(trajectory::Side::after) : visit(source, row++);
        });
    if (!is_feasible) outcome_ = replace_time_prefix(source.outcome());
    return is_feasible;
  }

  /// Evaluates the mechanism for the rate s' and the acceleration s'' of the path parameter.
  const Sample& observe(dynamics::TreeMotionSource<S>& source, double ds, double dds) {
    kinematics::MotionStepper<S>& stepper = source.stepper();
    for (int c = 0; c < path_.tree.columns; ++c) {
      rate_[c] = ds * stepper.dy()[c];
      acceleration_[c] = ds * ds * stepper.ddy()[c] + dds * stepper.dy()[c];
    }
    if (!stepper.is_explicit()) compute_angular_velocities(source.tree(), rate_.data(), stepper.state());
    source.evaluator().evaluate(
        {stepper.state(), stepper.y(), rate_.data(), acceleration_.data(), stepper.time(), stepper.is_explicit()},
        stepper.equations(), 1, source.detail());
    return source.sample();
  }

  /// At rest, with s'' = 1, and with s' = 1 the quantities are c, a + c and b + c (plus friction). Friction adds
  /// f + d s', where f is dry friction. The values v₁, v₂, v₃ at s' = 1, 2, 3 give b = (v₃ − 2v₂ + v₁)/2 and
  /// d = v₂ − v₁ − 3b. In motion, c + f replaces c.
  void fill(dynamics::TreeMotionSource<S>& source, double* row) {
    const auto visit = [&](double ds, double dds, auto accumulate) {
      const Sample& observed = observe(source, ds, dds);
      for (const CoefficientColumns& limit : limits_) {
        const double* values = limit.quantity.values(observed) + limit.quantity.first;
        for (int i = 0; i < limit.quantity.count; ++i) accumulate(limit, i, values[i]);
      }
    };
    const auto add = [row](int column, int i, double value) {
      if (column >= 0) row[column + i] += value;
    };
    visit(0, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind == Kind::energy || l.quantity.kind == Kind::rate) return;
      add(l.c, i, v);
      add(l.a, i, -v);
      if (!has_rate_terms_) add(l.b, i, -v);
    });
    visit(0, 1, [&](const CoefficientColumns& l, int i, double v) { add(l.a, i, v); });
    visit(1, 0, [&](const CoefficientColumns& l, int i, double v) {
      const bool is_quadratic = !has_rate_terms_ || l.quantity.kind != Kind::force;
      if (l.quantity.kind == Kind::rate) return add(l.d, i, v);
      if (is_quadratic) return add(l.b, i, v);
      add(l.b, i, v / 2);
      add(l.d, i, -2.5 * v);
      if (l.c >= 0) row[l.c + i] = 3 * v;
    });
    if (!has_rate_terms_) return;
    visit(2, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind != Kind::force) return;
      add(l.b, i, -v);
      add(l.d, i, 4 * v);
      add(l.c, i, -3 * v);
    });
    visit(3, 0, [&](const CoefficientColumns& l, int i, double v) {
      if (l.quantity.kind != Kind::force) return;
      add(l.b, i, v / 2);
      add(l.d, i, -1.5 * v);
      add(l.c, i, v);
    });
  }

  const Mechanism& mechanism_;
  Trajectory trajectory_;
  const kinematics::CompiledMotion<S> path_;
  bool all_detail_ = false;
  bool has_rate_terms_;  ///< friction, or dampers
  std::vector<int> friction_;
  std::vector<double> rate_, acceleration_;
};

}  // namespace

std::unique_ptr<PathDynamicsSampler> make_path_dynamics_sampler(const Mechanism& mechanism,
                                                                const Trajectory& trajectory,
                                                                const std::vector<LimitableQuantity>& quantities) {
  return kinematics::dispatch_space(mechanism.space, [&]<class S>(S) -> std::unique_ptr<PathDynamicsSampler> {
    return std::make_unique<PathDynamicsSamplerOf<S>>(mechanism, trajectory, quantities);
  });
}

namespace {

constexpr double right_angle_tolerance = 1e-5;  // cosine

}  // namespace

ConstraintValue evaluate_constraint(const PathModel& model, const PathPoint& point) {
  const PathConstraintRow& row = model.rows[static_cast<std::size_t>(point.row)];
  VectorX columns(model.value.function_count());
  model.value.evaluate(model.value.find_panel(point.s, 0, model.value.panels().size()), point.s, columns.data());
  const auto coefficient = [&](int column) {
    return column < 0 ? VectorX(VectorX::Zero(row.count)) : VectorX(columns.segment(column, row.count));
  };
  const VectorX a = coefficient(row.a), b = coefficient(row.b), d = coefficient(row.d);
  ConstraintValue constraint;
  constraint.value = a * point.u + b * (point.v * point.v) + coefficient(row.c) + d * point.v;
  if (row.count == 1) constraint.value[0] -= row.centre;
  constraint.magnitude = constraint.value.norm();
  if (!(constraint.magnitude > 0)) return constraint;
  const VectorX direction = constraint.value / constraint.magnitude;
  constraint.d_du = direction.dot(a);
  constraint.d_dx = direction.dot(b) + (point.v > 0 ? direction.dot(d) / (2 * point.v) : 0);
  constraint.is_velocity_limited =
      !row.has_acceleration_term || !(std::abs(constraint.d_du) > right_angle_tolerance * a.norm());
  return constraint;
}

namespace {

void check_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  for (const trajectory::MotionLimit& limit : trajectory.limits) {
    const double lower_bound = limit.lower_bound.value_or(-limit.upper_bound);
    if (!(lower_bound < limit.upper_bound) || !std::isfinite(lower_bound) || !std::isfinite(limit.upper_bound))
      throw std::invalid_argument(
          "the limit of " + limit.quantity +
          (limit.lower_bound ? " must have a lower bound below its upper bound" : " must be positive"));
  }
  if (!trajectory.limits.empty()) require_constant_loads(mechanism, "a motion within limits");
}

}  // namespace

std::vector<LimitableQuantity> require_limited_quantities(const Mechanism& mechanism, const std::string& name) {
  std::vector<LimitableQuantity> quantities = results::find_limitable_quantities(mechanism, name);
  if (quantities.empty()) throw std::invalid_argument("no law of motion can limit '" + name + "' of this mechanism");
  return quantities;
}

void require_constant_loads(const Mechanism& mechanism, const std::string& what) {
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 1; load.is_over_time() && k < load.force.size(); ++k)
      if (load.force[k] != load.force[0] || load.moment[k] != load.moment[0])
        throw std::invalid_argument(what + " cannot be found under the load " + load.name +
                                    ", which changes with time");
}

PathLimits collect_limits(const Mechanism& mechanism, const Trajectory& trajectory) {
  check_limits(mechanism, trajectory);
  PathLimits limits;
  for (const trajectory::MotionLimit& limit : trajectory.limits)
    for (const LimitableQuantity& quantity : require_limited_quantities(mechanism, limit.quantity)) {
      if (limit.lower_bound && quantity.count > 1)
        throw std::invalid_argument("the magnitude of " + quantity.name + " has no lower bound: limit a component");
      const double lower_bound = limit.lower_bound.value_or(-limit.upper_bound);
      limits.quantities.push_back(quantity);
      limits.half_widths.push_back((limit.upper_bound - lower_bound) / 2);
      limits.centres.push_back((limit.upper_bound + lower_bound) / 2);
    }
  return limits;
}

PathModel build_limited_path_model(const Mechanism& mechanism, const Trajectory& trajectory, const PathLimits& limits) {
  PathModel model = build_path_model(mechanism, trajectory, limits.quantities);
  for (std::size_t r = 0; r < std::min(model.rows.size(), limits.centres.size()); ++r)
    model.rows[r].centre = limits.centres[r];
  return model;
}

}  // namespace balance::time_optimal
