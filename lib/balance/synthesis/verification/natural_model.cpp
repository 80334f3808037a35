#include "balance/synthesis/verification/natural_model.hpp"

#include "balance/foundation/base/elementary.hpp"

#include <cmath>
#include <numbers>
#include <queue>
#include <stdexcept>

namespace balance::verification::natural {

NaturalInertia& NaturalInertia::operator+=(const NaturalInertia& other) {
  mass += other.mass;
  first_moment += other.first_moment;
  second_moment += other.second_moment;
  return *this;
}

Eigen::Matrix2cd two_point_mass(const NaturalInertia& inertia, Complex a, Complex b) {
  const Complex base = b - a;
  const Complex first = (inertia.first_moment - inertia.mass * a) / base;  // ∫ κ dm
  const double second =                                                    // ∫ |κ|² dm
      (inertia.second_moment - 2 * dot(a, inertia.first_moment) + inertia.mass * std::norm(a)) / std::norm(base);
  Eigen::Matrix2cd M;
  M(0, 0) = inertia.mass - 2 * first.real() + second;
  M(0, 1) = first - second;  // ∫ conj(1 − κ) κ dm
  M(1, 0) = std::conj(M(0, 1));
  M(1, 1) = second;
  return M;
}

Matrix3 isotropic_moments(const NaturalInertia& inertia) {
  const double m = inertia.mass, x = inertia.first_moment.real(), y = inertia.first_moment.imag();
  const double half =
      m > 0 ? (inertia.second_moment - std::norm(inertia.first_moment) / m) / 2 : inertia.second_moment / 2;
  Matrix3 S;
  S << m, x, y,                                                  //
      x, half + (m > 0 ? x * x / m : 0), m > 0 ? x * y / m : 0,  //
      y, m > 0 ? x * y / m : 0, half + (m > 0 ? y * y / m : 0);
  return S;
}

Matrix3 three_point_mass(const Matrix3& moments, Complex a, Complex b, Complex c) {
  Matrix3 corners;  // column k: 1, x, y of corner k
  corners << 1, 1, 1, a.real(), b.real(), c.real(), a.imag(), b.imag(), c.imag();
  const Matrix3 weights = corners.inverse();  // row k: λ_k = weights · [1 x y]ᵀ
  return weights * moments * weights.transpose();
}

namespace {

NaturalInertia inertia_at(double mass, const Vector3& position, double about_com, double length) {
  const Complex r = to_complex(position, length);
  return {mass, mass * r, about_com / (length * length) + mass * std::norm(r)};
}

/// Inertia of a body and everything rigidly fixed to it. A disc's CoM does not move on its carrier.
NaturalInertia sum_carried_inertia(const Mechanism& mechanism, int b, double length) {
  const Body& body = mechanism.bodies[static_cast<std::size_t>(b)];
  NaturalInertia sum = inertia_at(body.mass, body.com, body.inertia(2, 2), length);
  for (const Attachment& attachment : mechanism.attachments)
    if (attachment.body == b) sum += inertia_at(attachment.mass, attachment.position, attachment.inertia(2, 2), length);
  for (const Disc& disc : mechanism.discs)
    if (disc.body == b) sum += inertia_at(disc.mass, disc.position, 0, length);
  return sum;
}

}  // namespace

void add_masses(const Mechanism& mechanism, NaturalModel& model) {
  model.total_mass = model::total_mass(mechanism);
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b) {
    const NaturalInertia inertia = sum_carried_inertia(mechanism, static_cast<int>(b), model.length());
    const std::vector<BodyPoint>& points = model.basic.bodies[b].points;
    if (model.basic.bodies[b].has_mass_triangle) {
      const Matrix3 M =
          three_point_mass(isotropic_moments(inertia), points[0].position, points[1].position, points[2].position);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          model.mass.push_back(
              {points[static_cast<std::size_t>(i)].point, points[static_cast<std::size_t>(j)].point, M(i, j)});
      continue;
    }
    const Eigen::Matrix2cd M = two_point_mass(inertia, points[0].position, points[1].position);
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        model.mass.push_back(
            {points[static_cast<std::size_t>(i)].point, points[static_cast<std::size_t>(j)].point, M(i, j)});
  }
  for (const Disc& disc : mechanism.discs) {
    Rotor rotor{disc.inertia(2, 2) / (model.length() * model.length()), {}};
    if (disc.body == model::ground) model.ground_disc_moment += disc.mass * to_complex(disc.position, model.length());
    const BodyModel& carrier = model.bodies[static_cast<std::size_t>(disc.body)];
    if (carrier.angle >= 0) rotor.angle.terms.push_back({carrier.angle, 1});
    for (const auto& [coordinate, ratio] : disc.follows.terms) {
      const ScalarAffineForm& leader = model.coordinates[static_cast<std::size_t>(coordinate)].form;
      rotor.angle.constant += disc.ratio * ratio * leader.constant;
      for (const ScalarTerm& term : leader.terms)
        rotor.angle.terms.push_back({term.scalar, disc.ratio * ratio * term.coefficient});
    }
    model.rotors.push_back(rotor);
  }
}

double ScalarAffineForm::at(const std::vector<double>& scalars) const { return constant + rate(scalars); }

double ScalarAffineForm::rate(const std::vector<double>& rates) const {
  double sum = 0;
  for (const ScalarTerm& term : terms) sum += term.coefficient * rates[static_cast<std::size_t>(term.scalar)];
  return sum;
}

CoordinateId first_coordinate(const Mechanism& mechanism, JointId joint) {
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (mechanism.coordinates[c].joint == joint) return static_cast<int>(c);
  return -1;
}

double compute_zero_angle(const Joint& joint) { return elementary::atan2(joint.rotation(1, 0), joint.rotation(0, 0)); }

namespace {

/// Along which a coordinate that is a length moves the second body, in the first body's axes.
Complex slide_direction(const Mechanism& mechanism, CoordinateId c) {
  const Coordinate& coordinate = mechanism.coordinates[static_cast<std::size_t>(c)];
  const Joint& joint = mechanism.joints[static_cast<std::size_t>(coordinate.joint)];
  if (joint.type != JointType::planar) return to_complex(joint.axis, 1);
  const Complex x = to_complex(joint.axis2, 1);
  return coordinate.index == 0 ? x : imaginary * x;
}

}  // namespace

std::vector<BodyPose> compute_body_poses(const Mechanism& mechanism, const std::vector<double>& coordinates,
                                         double length) {
  std::vector<BodyPose> poses(mechanism.bodies.size());
  std::vector<bool> is_placed(mechanism.bodies.size(), false);
  std::queue<int> pending({model::ground});
  is_placed[model::ground] = true;
  while (!pending.empty()) {
    const BodyId body = pending.front();
    pending.pop();
    for (std::size_t j = 0; j < mechanism.joints.size(); ++j) {
      const Joint& joint = mechanism.joints[j];
      if (joint.first != body && joint.second != body) continue;
      const int other = joint.first == body ? joint.second : joint.first;
      if (is_placed[static_cast<std::size_t>(other)]) continue;
      double angle = compute_zero_angle(joint);
      Complex slide_point = to_complex(joint.point_first, length);
      for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c) {
        const Coordinate& coordinate = mechanism.coordinates[c];
        if (coordinate.joint != static_cast<int>(j)) continue;
        if (coordinate.kind == CoordinateKind::angle)
          angle += coordinates[c];
        else
          slide_point += coordinates[c] / length * slide_direction(mechanism, static_cast<int>(c));
      }
      const Complex Q = to_complex(joint.point_second, length);
      const BodyPose& known_pose = poses[static_cast<std::size_t>(body)];
      BodyPose& other_pose = poses[static_cast<std::size_t>(other)];
      if (joint.first == body) {
        other_pose.angle = known_pose.angle + angle;
        other_pose.origin = known_pose.origin + make_unit_complex(known_pose.angle) * slide_point -
                            make_unit_complex(other_pose.angle) * Q;
      } else {
        other_pose.angle = known_pose.angle - angle;
        other_pose.origin = known_pose.origin + make_unit_complex(known_pose.angle) * Q -
                            make_unit_complex(other_pose.angle) * slide_point;
      }
      is_placed[static_cast<std::size_t>(other)] = true;
      pending.push(other);
    }
  }
  return poses;
}

namespace {

constexpr double full_turn = 2 * std::numbers::pi;

double round_to_turns(double angle) { return full_turn * std::round(angle / full_turn); }

class ModelBuilder {
 public:
  ModelBuilder(const Mechanism& mechanism, const InitialCoordinates& start) : mechanism_(mechanism), start_(start) {
    if (start.coordinates.size() != mechanism.coordinates.size())
      throw std::invalid_argument("the start needs a value for every joint coordinate");
    model_.basic = choose_basic_points(mechanism);
  }

  NaturalModel build(const std::vector<CoordinateId>& needed, bool tool_angle) {
    compute_start_points();
    for (std::size_t b = 0; b < mechanism_.bodies.size(); ++b) add_body(b);
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) add_coordinate(static_cast<int>(c));
    const auto make_scalars = [&](const model::CoordinateCombination& followed) {
      for (const model::CoordinateTerm& term : followed.terms) make_scalar(term.coordinate);
    };
    for (const int c : needed) make_scalar(c);
    for (const int c : mechanism_.actuators) make_scalar(c);
    for (const Coupling& coupling : mechanism_.couplings) make_scalar(coupling.follower), make_scalars(coupling.leader);
    for (const Friction& friction : mechanism_.friction) make_scalar(friction.coordinate);
    for (const Spring& spring : mechanism_.springs)
      if (spring.is_joint_spring()) make_scalar(spring.coordinate);
    for (const Load& load : mechanism_.loads)
      if (load.is_over_coordinate()) make_scalar(load.coordinate);
    for (const ForceElement& element : mechanism_.force_elements)
      if (element.is_in_joint()) make_scalar(element.coordinate);
    for (const Disc& disc : mechanism_.discs) make_scalars(disc.follows), body_angle(disc.body);
    if (mechanism_.tool) {
      const BodyId body = mechanism_.tool->body;
      if (tool_angle) body_angle(body);
      model_.tool_angle_offset = round_to_turns(model_.body_angles[static_cast<std::size_t>(body)] - start_.tool_angle);
    }
    for (const Joint& joint : mechanism_.joints) add_joint(joint);
    for (const Coupling& coupling : mechanism_.couplings) add_coupling(coupling);
    add_masses(mechanism_, model_);
    return std::move(model_);
  }

 private:
  void compute_start_points() {
    body_poses_ = compute_body_poses(mechanism_, start_.coordinates, model_.length());
    for (const BodyPose& pose : body_poses_) model_.body_angles.push_back(pose.angle);
    model_.start.points.resize(static_cast<std::size_t>(model_.basic.count()));
    for (std::size_t b = mechanism_.bodies.size(); b-- > 1;)
      for (const BodyPoint& p : model_.basic.bodies[b].points)
        model_.start.points[static_cast<std::size_t>(p.point)] =
            body_poses_[b].origin + make_unit_complex(body_poses_[b].angle) * p.position;
    for (std::size_t k = 0; k < model_.basic.fixed.size(); ++k)
      model_.start.points[static_cast<std::size_t>(model_.basic.moving) + k] = model_.basic.fixed[k];
  }

  void add_distance(const BodyPoint& p, const BodyPoint& q) {
    const AffineForm direction = Complex(1 / std::abs(q.position - p.position)) * (point(q) - point(p));
    model_.constraints.push_back({.left = direction, .right = direction, .constant = 1});
  }

  static AffineForm point(const BodyPoint& p) { return {{}, {{p.point, 1}}}; }

  void add_body(std::size_t b) {
    BodyModel body;
    if (b == model::ground) {
      body.direction = make_constant_form(1);
      model_.bodies.push_back(body);
      return;
    }
    const BodyPoints& body_points = model_.basic.bodies[b];
    const BodyPoint &A = body_points.points[0], &B = body_points.points[1];
    body.direction = 1.0 / (B.position - A.position) * (point(B) - point(A));
    body.origin = point(A) - A.position * body.direction;
    model_.bodies.push_back(body);
    add_distance(A, B);
    for (std::size_t k = 2; k < body_points.points.size(); ++k) {
      const BodyPoint& C = body_points.points[k];
      if (k == 2 && body_points.has_mass_triangle) {
        add_distance(A, C);
        add_distance(B, C);
        continue;
      }
      const AffineForm gap = body.place(C.position) - point(C);
      model_.constraints.push_back({.left = make_constant_form(1), .right = gap});
      model_.constraints.push_back({.left = make_constant_form(imaginary), .right = gap});
    }
  }

  int add_scalar(double value) {
    model_.start.scalars.push_back(value);
    return model_.scalars++;
  }

  int body_angle(int b) {
    BodyModel& body = model_.bodies[static_cast<std::size_t>(b)];
    if (body.angle < 0 && b != model::ground) {
      body.angle = add_scalar(model_.body_angles[static_cast<std::size_t>(b)]);
      model_.constraints.push_back({.right = body.direction, .angle = body.angle});
    }
    return body.angle;
  }

  /// Adds a coordinate that is not counted yet.
  void add_coordinate(int c) {
    const Joint& joint =
        mechanism_.joints[static_cast<std::size_t>(mechanism_.coordinates[static_cast<std::size_t>(c)].joint)];
    JointCoordinate coordinate;
    coordinate.angle = mechanism_.coordinates[static_cast<std::size_t>(c)].kind == CoordinateKind::angle;
    coordinate.first = joint.first;
    coordinate.second = joint.second;
    const double start_value = start_.coordinates[static_cast<std::size_t>(c)];
    if (coordinate.angle) {
      const double relative_angle = model_.body_angles[static_cast<std::size_t>(joint.second)] -
                                    model_.body_angles[static_cast<std::size_t>(joint.first)] -
                                    compute_zero_angle(joint);
      coordinate.offset = compute_zero_angle(joint) + round_to_turns(relative_angle - start_value);
    } else {
      coordinate.slide = {
          .left = slide_direction(mechanism_, c) * model_.bodies[static_cast<std::size_t>(joint.first)].direction,
          .right = gap(joint)};
    }
    model_.coordinates.push_back(coordinate);
  }

  void make_scalar(int c) {
    JointCoordinate& coordinate = model_.coordinates[static_cast<std::size_t>(c)];
    if (coordinate.linear) return;
    coordinate.linear = true;
    if (coordinate.angle) {
      const int first = body_angle(coordinate.first), second = body_angle(coordinate.second);
      if (first >= 0) coordinate.form.terms.push_back({first, -1});
      if (second >= 0) coordinate.form.terms.push_back({second, 1});
      coordinate.form.constant = -coordinate.offset;
      return;
    }
    const int scalar = add_scalar(start_.coordinates[static_cast<std::size_t>(c)] / model_.length());
    ConstraintRow row = coordinate.slide;
    row.scalars.push_back({scalar, -1});
    model_.constraints.push_back(row);
    coordinate.form.terms.push_back({scalar, model_.length()});
  }

  AffineForm axis(const Joint& joint) const {
    return to_complex(joint.axis, 1) * model_.bodies[static_cast<std::size_t>(joint.first)].direction;
  }

  AffineForm gap(const Joint& joint) const {
    return model_.bodies[static_cast<std::size_t>(joint.second)].place(
               to_complex(joint.point_second, model_.length())) -
           model_.bodies[static_cast<std::size_t>(joint.first)].place(to_complex(joint.point_first, model_.length()));
  }

  void add_joint(const Joint& joint) {
    if (joint.type == JointType::prismatic || joint.type == JointType::pin_slot)  // no motion across the slide
      model_.constraints.push_back({.left = imaginary * axis(joint), .right = gap(joint)});
    if (joint.type == JointType::prismatic || joint.type == JointType::fixed)  // no rotation
      model_.constraints.push_back({.left = imaginary * make_unit_complex(compute_zero_angle(joint)) *
                                            model_.bodies[static_cast<std::size_t>(joint.first)].direction,
                                    .right = model_.bodies[static_cast<std::size_t>(joint.second)].direction});
  }

  void add_coupling(const Coupling& coupling) {
    const JointCoordinate& follower = model_.coordinates[static_cast<std::size_t>(coupling.follower)];
    const double unit = follower.angle ? 1 : model_.length();
    ConstraintRow row;
    const auto add = [&](const ScalarAffineForm& form, double factor) {
      for (const ScalarTerm& term : form.terms) row.scalars.push_back({term.scalar, factor * term.coefficient / unit});
      row.constant -= factor * form.constant / unit;
    };
    add(follower.form, 1);
    for (const model::CoordinateTerm& term : coupling.leader.terms)
      add(model_.coordinates[static_cast<std::size_t>(term.coordinate)].form, -coupling.ratio * term.ratio);
    row.constant += coupling.offset / unit;
    model_.constraints.push_back(row);
  }

  const Mechanism& mechanism_;
  const InitialCoordinates& start_;
  NaturalModel model_;
  std::vector<BodyPose> body_poses_;
};

}  // namespace

NaturalModel build_model(const Mechanism& mechanism, const std::vector<CoordinateId>& needed, bool tool_angle,
                         const InitialCoordinates& start) {
  return ModelBuilder(mechanism, start).build(needed, tool_angle);
}

}  // namespace balance::verification::natural
