#include "balance/timing/path_source.hpp"

#include "balance/base/extrema.hpp"
#include "balance/dynamics/observer.hpp"
#include "balance/motion/wording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

namespace balance {

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

}  // namespace balance
