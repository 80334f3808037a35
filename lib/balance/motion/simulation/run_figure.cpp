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

/// Position of a landmark in the axes of its body.
struct BodyPoint {
  BodyId body = 0;
  Vector3 position = Vector3::Zero();
};

BodyPoint locate_landmark(const Mechanism& mechanism, const Landmark& landmark) {
  const auto index = static_cast<std::size_t>(landmark.index), body = static_cast<std::size_t>(landmark.body);
  switch (landmark.kind) {
    case Landmark::Kind::origin: break;
    case Landmark::Kind::com: return {landmark.body, mechanism.bodies[body].com};
    case Landmark::Kind::point: return {landmark.body, mechanism.bodies[body].points[index].position};
    case Landmark::Kind::attachment: return {mechanism.attachments[index].body, mechanism.attachments[index].position};
    case Landmark::Kind::disc: return {mechanism.discs[index].body, mechanism.discs[index].position};
  }
  return {landmark.body, Vector3::Zero()};
}

Vector3 in_world(const BodyPoses& poses, long row, const BodyPoint& point) {
  const double* origin = &poses.position(row, 3 * point.body);
  const double* q = &poses.orientation(row, 4 * point.body);
  return Vector3(origin[0], origin[1], origin[2]) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * point.position;
}

/// From a point to a line segment.
double distance_to_segment(const Vector3& point, const Vector3& begin, const Vector3& end) {
  const Vector3 direction = end - begin;
  const double squared_length = direction.squaredNorm();
  const double fraction =
      squared_length > 0 ? std::clamp((point - begin).dot(direction) / squared_length, 0.0, 1.0) : 0;
  return (point - begin - fraction * direction).norm();
}

}  // namespace

const Trajectory& find_trajectory(const DesignInstance& instance, const ObjectiveTerm& term) {
  if (const Trajectory* trajectory = find_by_name(instance.trajectories, term.trajectory)) return *trajectory;
  throw std::invalid_argument("there is no trajectory '" + term.trajectory + "' to minimize along");
}

double min_clearance(const Mechanism& mechanism, const RunResult& run, const Clearance& clearance) {
  const BodyPoses poses = body_poses(mechanism, run);
  const BodyPoint point = locate_landmark(mechanism, clearance.point);
  const BodyPoint begin = locate_landmark(mechanism, clearance.target.front()),
                  end = locate_landmark(mechanism, clearance.target.back());
  double min_distance = std::numeric_limits<double>::infinity();
  for (long row = 0; row < run.time.size(); ++row)
    min_distance = std::min(min_distance, distance_to_segment(in_world(poses, row, point), in_world(poses, row, begin),
                                                              in_world(poses, row, end)));
  return min_distance;
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

double simulate_figure(const DesignInstance& instance, const ObjectiveTerm& term) {
  const Trajectory& trajectory = find_trajectory(instance, term);
  if (term.run == ObjectiveTerm::RunMeasure::duration && !is_mechanism_dependent(trajectory))
    return trajectory.duration;
  return compute_run_figure(instance.mechanism, simulate(instance.mechanism, trajectory), term);
}

}  // namespace balance
