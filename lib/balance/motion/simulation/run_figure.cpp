#include "balance/motion/simulation/run_figure.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/metrics.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance {

namespace {

/// A landmark's place in the axes of the body that carries it.
struct BodyPoint {
  BodyId body = 0;
  Vector3 position = Vector3::Zero();
};

BodyPoint locate_landmark(const Mechanism& mechanism, const Landmark& mark) {
  const auto index = static_cast<std::size_t>(mark.index), body = static_cast<std::size_t>(mark.body);
  switch (mark.kind) {
    case Landmark::Kind::origin: break;
    case Landmark::Kind::com: return {mark.body, mechanism.bodies[body].com};
    case Landmark::Kind::point: return {mark.body, mechanism.bodies[body].points[index].position};
    case Landmark::Kind::attachment: return {mechanism.attachments[index].body, mechanism.attachments[index].position};
    case Landmark::Kind::disc: return {mechanism.discs[index].body, mechanism.discs[index].position};
  }
  return {mark.body, Vector3::Zero()};
}

Vector3 in_world(const BodyPoses& poses, long row, const BodyPoint& mark) {
  const double* origin = &poses.position(row, 3 * mark.body);
  const double* q = &poses.orientation(row, 4 * mark.body);
  return Vector3(origin[0], origin[1], origin[2]) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * mark.position;
}

/// From a point to the straight line between two others, ends included.
double distance_to_segment(const Vector3& point, const Vector3& begin, const Vector3& end) {
  const Vector3 along = end - begin;
  const double square = along.squaredNorm();
  const double part = square > 0 ? std::clamp((point - begin).dot(along) / square, 0.0, 1.0) : 0;
  return (point - begin - part * along).norm();
}

}  // namespace

const Trajectory& find_trajectory(const DesignInstance& trial, const ObjectiveTerm& term) {
  for (const Trajectory& trajectory : trial.trajectories)
    if (trajectory.name == term.trajectory) return trajectory;
  throw std::invalid_argument("there is no trajectory '" + term.trajectory + "' to minimize along");
}

double min_clearance(const Mechanism& mechanism, const RunResult& run, const Clearance& clearance) {
  const BodyPoses poses = body_poses(mechanism, run);
  const BodyPoint point = locate_landmark(mechanism, clearance.point);
  const BodyPoint begin = locate_landmark(mechanism, clearance.target.front()),
                  end = locate_landmark(mechanism, clearance.target.back());
  double least = std::numeric_limits<double>::infinity();
  for (long row = 0; row < run.time.size(); ++row)
    least = std::min(least, distance_to_segment(in_world(poses, row, point), in_world(poses, row, begin),
                                                in_world(poses, row, end)));
  return least;
}

double compute_run_figure(const Mechanism& mechanism, const RunResult& run, const ObjectiveTerm& term) {
  if (run.outcome.status != MotionStatus::done) return std::numeric_limits<double>::quiet_NaN();
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::duration: return run.outcome.time;
    case ObjectiveTerm::RunMeasure::energy: return run.energy;
    case ObjectiveTerm::RunMeasure::clearance: return min_clearance(mechanism, run, term.clearance);
    case ObjectiveTerm::RunMeasure::mobility:
      if (run.mobility.size() == 0) break;
      return min_coefficient(run.mobility);
    case ObjectiveTerm::RunMeasure::figure:
      for (const Metric& metric : run.metrics)
        if (is_quantity_name(term.quantity, metric.quantity))
          return suppress_round_off(metric.round_off, statistic_of(metric, term.figure));
      break;
  }
  throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" +
                              (term.run == ObjectiveTerm::RunMeasure::figure ? term.quantity : "mobility") + "'");
}

double simulate_figure(const DesignInstance& trial, const ObjectiveTerm& term) {
  const Trajectory& trajectory = find_trajectory(trial, term);
  if (term.run == ObjectiveTerm::RunMeasure::duration && !is_mechanism_dependent(trajectory))
    return trajectory.duration;
  return compute_run_figure(trial.mechanism, simulate(trial.mechanism, trajectory), term);
}

}  // namespace balance
