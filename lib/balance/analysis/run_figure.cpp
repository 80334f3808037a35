#include "balance/analysis/run_figure.hpp"

#include "balance/base/extrema.hpp"
#include "balance/result/body_poses.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/result/metrics.hpp"
#include "balance/result/round_off.hpp"
#include "balance/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance {

namespace {

/// A landmark's place in the axes of the body that carries it.
struct Placed {
  BodyId body = 0;
  Vector3 position = Vector3::Zero();
};

Placed placed(const Mechanism& mechanism, const Landmark& mark) {
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

Vector3 in_world(const BodyPoses& poses, long row, const Placed& mark) {
  const double* origin = &poses.position(row, 3 * mark.body);
  const double* q = &poses.orientation(row, 4 * mark.body);
  return Vector3(origin[0], origin[1], origin[2]) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * mark.position;
}

/// From a point to the straight line between two others, ends included.
double distance(const Vector3& point, const Vector3& begin, const Vector3& end) {
  const Vector3 along = end - begin;
  const double square = along.squaredNorm();
  const double part = square > 0 ? std::clamp((point - begin).dot(along) / square, 0.0, 1.0) : 0;
  return (point - begin - part * along).norm();
}

}  // namespace

const Trajectory& trajectory_of(const Trial& trial, const ObjectiveTerm& term) {
  for (const Trajectory& trajectory : trial.trajectories)
    if (trajectory.name == term.trajectory) return trajectory;
  throw std::invalid_argument("there is no trajectory '" + term.trajectory + "' to minimize along");
}

double least_clearance(const Mechanism& mechanism, const Result& run, const Clearance& clearance) {
  const BodyPoses poses = body_poses(mechanism, run);
  const Placed point = placed(mechanism, clearance.of);
  const Placed begin = placed(mechanism, clearance.to.front()), end = placed(mechanism, clearance.to.back());
  double least = std::numeric_limits<double>::infinity();
  for (long row = 0; row < run.time.size(); ++row)
    least =
        std::min(least, distance(in_world(poses, row, point), in_world(poses, row, begin), in_world(poses, row, end)));
  return least;
}

double run_figure(const Mechanism& mechanism, const Result& run, const ObjectiveTerm& term) {
  if (run.outcome.status != MotionStatus::done) return std::numeric_limits<double>::quiet_NaN();
  switch (term.run) {
    case ObjectiveTerm::Run::duration: return run.outcome.time;
    case ObjectiveTerm::Run::energy: return run.energy;
    case ObjectiveTerm::Run::clearance: return least_clearance(mechanism, run, term.clearance);
    case ObjectiveTerm::Run::mobility:
      if (run.mobility.size() == 0) break;
      return min_coefficient(run.mobility);
    case ObjectiveTerm::Run::figure:
      for (const Metric& metric : run.metrics)
        if (is_name_of(term.quantity, metric.quantity)) return above(metric.round_off, figure_of(metric, term.figure));
      break;
  }
  throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" +
                              (term.run == ObjectiveTerm::Run::figure ? term.quantity : "mobility") + "'");
}

double by_simulation(const Trial& trial, const ObjectiveTerm& term) {
  const Trajectory& trajectory = trajectory_of(trial, term);
  if (term.run == ObjectiveTerm::Run::duration && !depends_on_mechanism(trajectory)) return trajectory.duration;
  return run_figure(trial.mechanism, simulate(trial.mechanism, trajectory), term);
}

}  // namespace balance
