#include "balance/motion/control/task_speeds.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/mechanics/model/speed_units.hpp"
#include "balance/motion/control/controller_error.hpp"
#include "balance/motion/study/controller_spec.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace balance::control {

namespace {

using results::BodyMotion;
using Kind = model::GeneralisedSpeedTerm::Kind;

/// Position, velocity or acceleration of a point.
Vector3 point_derivative(const BodyMotion& motion, const Vector3& r, int derivative) {
  return derivative == 0   ? motion.point_position(r)
         : derivative == 1 ? motion.point_velocity(r)
                           : motion.point_acceleration(r);
}

/// Of the centre of mass of everything that moves.
Vector3 com_derivative(const Mechanism& mechanism, const std::vector<BodyMotion>& motions, int derivative) {
  Vector3 moment = Vector3::Zero();
  double mass = 0;
  const auto add = [&](BodyId body, double m, const Vector3& r) {
    if (body == model::ground) return;
    moment += m * point_derivative(motions[static_cast<std::size_t>(body)], r, derivative);
    mass += m;
  };
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    add(static_cast<int>(b), mechanism.bodies[b].mass, mechanism.bodies[b].com);
  for (const Attachment& attachment : mechanism.attachments) add(attachment.body, attachment.mass, attachment.position);
  for (const Disc& disc : mechanism.discs) add(disc.body, disc.mass, disc.position);
  return moment / mass;
}

double angle_of(const BodyMotion& motion) { return elementary::atan2(motion.rotation(1, 0), motion.rotation(0, 0)); }

}  // namespace

TaskSpeeds::TaskSpeeds(const Mechanism& mechanism, std::vector<model::GeneralisedSpeed> speeds)
    : mechanism_(&mechanism), speeds_(std::move(speeds)) {
  for (const model::GeneralisedSpeed& speed : speeds_)
    if (const std::string reason = study::why_not_a_rate(speed, mechanism.space); !reason.empty())
      throw ControllerError("speeds." + speed.name,
                            "the controller's speed " + speed.name + " is not the rate of a quantity: " + reason);
}

Vector3 TaskSpeeds::point_of(const model::GeneralisedSpeedTerm& term, const std::vector<BodyMotion>& motions,
                             int derivative) const {
  if (term.kind == Kind::com_velocity) return com_derivative(*mechanism_, motions, derivative);
  return point_derivative(motions[static_cast<std::size_t>(term.body)], term.position, derivative);
}

bool TaskSpeeds::is_length(Eigen::Index i) const {
  return model::is_length_speed(*mechanism_, speeds_[static_cast<std::size_t>(i)]);
}

MatrixX TaskSpeeds::directions(const VectorX& position, const MatrixX& motions) const {
  MatrixX W(size(), motions.cols());
  for (Eigen::Index k = 0; k < W.cols(); ++k) W.col(k) = rates(position, motions.col(k));
  return W;
}

/// Every coordinate may move every point, angles at a lever arm of the characteristic length.
VectorX TaskSpeeds::bound_changes(const VectorX& changes) const {
  const double length = characteristic_length(*mechanism_);
  VectorX bounds = VectorX::Zero(size());
  for (std::size_t i = 0; i < speeds_.size(); ++i)
    for (const model::GeneralisedSpeedTerm& term : speeds_[i].terms)
      for (Eigen::Index c = 0; c < changes.size(); ++c) {
        if (term.kind == Kind::coordinate && term.index != c) continue;
        const bool from_length = is_length_coordinate(*mechanism_, CoordinateId(static_cast<int>(c))),
                   to_length = model::is_length_term(*mechanism_, term);
        const double lever = from_length == to_length ? 1 : to_length ? length : 1 / length;
        bounds[static_cast<Eigen::Index>(i)] += std::abs(term.factor) * lever * changes[c];
      }
  return bounds;
}

VectorX TaskSpeeds::rates(const VectorX& position, const VectorX& velocity) const {
  const VectorX zero = VectorX::Zero(position.size());
  return sum_terms(results::body_motions_at(*mechanism_, position, velocity, zero), velocity, 1);
}

VectorX TaskSpeeds::accelerations(const VectorX& position, const VectorX& velocity, const VectorX& acceleration) const {
  return sum_terms(results::body_motions_at(*mechanism_, position, velocity, acceleration), acceleration, 2);
}

VectorX TaskSpeeds::sum_terms(const std::vector<BodyMotion>& motions, const VectorX& coordinate_derivatives,
                              int derivative) const {
  VectorX values = VectorX::Zero(size());
  for (std::size_t i = 0; i < speeds_.size(); ++i)
    for (const model::GeneralisedSpeedTerm& term : speeds_[i].terms) {
      double& value = values[static_cast<Eigen::Index>(i)];
      if (term.kind == Kind::coordinate) {
        value += term.factor * coordinate_derivatives[term.index];
      } else if (term.kind == Kind::angular_velocity) {
        const BodyMotion& body = motions[static_cast<std::size_t>(term.body)];
        value += term.factor * (derivative == 1 ? body.angular_velocity : body.angular_acceleration)[term.index];
      } else {
        value += term.factor * point_of(term, motions, derivative)[term.index];
      }
    }
  return values;
}

VectorX TaskSpeeds::errors(const VectorX& desired_position, const VectorX& position) const {
  const VectorX zero = VectorX::Zero(position.size());
  const std::vector<BodyMotion> desired = results::body_motions_at(*mechanism_, desired_position, zero, zero),
                                actual = results::body_motions_at(*mechanism_, position, zero, zero);
  VectorX values = VectorX::Zero(size());
  for (std::size_t i = 0; i < speeds_.size(); ++i)
    for (const model::GeneralisedSpeedTerm& term : speeds_[i].terms) {
      const auto body = static_cast<std::size_t>(term.body);
      double& value = values[static_cast<Eigen::Index>(i)];
      if (term.kind == Kind::coordinate)
        value += term.factor * (desired_position[term.index] - position[term.index]);
      else if (term.kind == Kind::angular_velocity)
        value += term.factor * std::remainder(angle_of(desired[body]) - angle_of(actual[body]), 2 * std::numbers::pi);
      else
        value += term.factor * (point_of(term, desired, 0) - point_of(term, actual, 0))[term.index];
    }
  return values;
}

}  // namespace balance::control
