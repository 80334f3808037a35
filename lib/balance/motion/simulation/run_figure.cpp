#include "balance/motion/simulation/run_figure.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/body_poses.hpp"
#include "balance/mechanics/results/orders.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/mechanics/results/solid_distance.hpp"
#include "balance/motion/simulation/rotor_unbalance.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace balance::simulation {

namespace {

Vector3 in_world(const results::BodyPoses& poses, long row, const model::BodyPoint& point) {
  const double* origin = &poses.position(row, 3 * point.body);
  const double* q = &poses.orientation(row, 4 * point.body);
  return Vector3(origin[0], origin[1], origin[2]) + Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * point.position;
}

}  // namespace

const Trajectory& find_trajectory(const study::DesignInstance& instance, const ObjectiveTerm& term) {
  if (const Trajectory* trajectory = study::find_by_name(instance.trajectories, term.trajectory)) return *trajectory;
  throw std::invalid_argument("there is no trajectory '" + term.trajectory + "' to minimize along");
}

namespace {

/// The solid of a counterweight or payload; null if the landmark is another, or has none.
const model::Shape* shape_of(const Mechanism& mechanism, const model::Landmark& landmark) {
  if (landmark.kind != model::Landmark::Kind::attachment) return nullptr;
  const Attachment& attachment = mechanism.attachments[static_cast<std::size_t>(landmark.index)];
  return attachment.shape ? &*attachment.shape : nullptr;
}

/// With solids in the place of points.
double min_solid_clearance(const Mechanism& mechanism, const results::BodyPoses& poses, long rows,
                           const study::Clearance& clearance) {
  const auto set_at = [&](const model::Landmark& first, const model::Landmark& last, long row) {
    results::ConvexSet set;
    set.is_planar = mechanism.space == SpaceKind::planar;
    set.shape = shape_of(mechanism, first);
    const model::BodyPoint begin = locate_landmark(mechanism, first), end = locate_landmark(mechanism, last);
    set.begin = set.centre = in_world(poses, row, begin);
    set.end = in_world(poses, row, end);
    if (set.shape != nullptr) {
      const double* q = &poses.orientation(row, 4 * begin.body);
      set.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix() * set.shape->rotation;
    }
    return set;
  };
  double min_distance = std::numeric_limits<double>::infinity();
  for (long row = 0; row < rows; ++row)
    min_distance =
        std::min(min_distance, results::distance_of(set_at(clearance.point, clearance.point, row),
                                                    set_at(clearance.target.front(), clearance.target.back(), row)));
  return min_distance;
}

}  // namespace

double min_clearance(const Mechanism& mechanism, const RunResult& run, const study::Clearance& clearance) {
  const results::BodyPoses poses = body_poses(mechanism, run);
  if (shape_of(mechanism, clearance.point) != nullptr || shape_of(mechanism, clearance.target.front()) != nullptr)
    return min_solid_clearance(mechanism, poses, run.time.size(), clearance);
  const model::BodyPoint point = locate_landmark(mechanism, clearance.point);
  const model::BodyPoint begin = locate_landmark(mechanism, clearance.target.front()),
                         end = locate_landmark(mechanism, clearance.target.back());
  double min_distance = std::numeric_limits<double>::infinity();
  for (long row = 0; row < run.time.size(); ++row)
    min_distance =
        std::min(min_distance, results::distance_to_segment(in_world(poses, row, point), in_world(poses, row, begin),
                                                            in_world(poses, row, end)));
  return min_distance;
}

double compute_run_figure(const Mechanism& mechanism, const RunResult& run, const ObjectiveTerm& term) {
  if (run.outcome.status != MotionStatus::done) return std::numeric_limits<double>::quiet_NaN();
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::duration: return run.outcome.time;
    case ObjectiveTerm::RunMeasure::energy: return run.energy;
    case ObjectiveTerm::RunMeasure::clearance: return min_clearance(mechanism, run, term.clearance);
    case ObjectiveTerm::RunMeasure::order: {
      const std::optional<results::MetricSeries> series = results::find_series(run, term.quantity);
      if (!series) break;
      return results::compute_order_peak(run, *series, term.order, term.part);
    }
    case ObjectiveTerm::RunMeasure::fluctuation: {
      const results::UniformTurning turning = results::find_uniform_turning(run);
      constexpr double attainable = 2;  // of every machine: it refuses those whose speed does not fluctuate on its own
      const double coefficient = results::analyse_speed_fluctuation(run, turning, attainable)->coefficient;
      return std::isfinite(coefficient) ? coefficient : std::numeric_limits<double>::quiet_NaN();
    }
    case ObjectiveTerm::RunMeasure::quality:
      throw std::invalid_argument("the balance quality of a rotor is not a figure of a run");
    case ObjectiveTerm::RunMeasure::mobility:
      if (run.mobility.size() == 0) break;
      return numerics::min_coefficient(run.mobility);
    case ObjectiveTerm::RunMeasure::figure: {
      const double value = compute_statistic(run, &mechanism, term.figure, term.quantity);
      if (std::isnan(value)) break;
      return value;
    }
  }
  throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" +
                              (term.run == ObjectiveTerm::RunMeasure::mobility ? "mobility" : term.quantity) + "'");
}

std::string unit_of_term(const Mechanism& mechanism, const ObjectiveTerm& term) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_inertia: return "kg m^2";
    case ObjectiveTerm::Size::added_mass:
    case ObjectiveTerm::Size::part_mass:
    case ObjectiveTerm::Size::total_mass: return "kg";
    case ObjectiveTerm::Size::price: return "";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::duration: return "s";
    case ObjectiveTerm::RunMeasure::energy: return "J";
    case ObjectiveTerm::RunMeasure::mobility: return "1";
    case ObjectiveTerm::RunMeasure::clearance: return "m";
    case ObjectiveTerm::RunMeasure::fluctuation:
    case ObjectiveTerm::RunMeasure::quality: return "1";
    case ObjectiveTerm::RunMeasure::order:
    case ObjectiveTerm::RunMeasure::figure: break;
  }
  std::string mistake;
  const auto described = results::describe_quantity(mechanism, term.quantity, mistake);
  return described ? described->unit : "";
}

std::string objective_unit(const std::vector<ObjectiveTerm>& terms, const Mechanism& mechanism) {
  return terms.size() == 1 && terms.front().weight == 1 ? unit_of_term(mechanism, terms.front()) : "";
}

double simulate_figure(const study::DesignInstance& instance, const ObjectiveTerm& term) {
  const Trajectory& trajectory = find_trajectory(instance, term);
  if (term.run == ObjectiveTerm::RunMeasure::duration && !is_mechanism_dependent(trajectory))
    return trajectory.duration;
  if (term.run == ObjectiveTerm::RunMeasure::quality)
    return compute_rotor_quality(instance.mechanism, trajectory, term.quantity);
  return compute_run_figure(instance.mechanism, simulate(instance.mechanism, trajectory), term);
}

}  // namespace balance::simulation
