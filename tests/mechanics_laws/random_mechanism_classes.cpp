#include "random_mechanism_classes.hpp"

#include "runs.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace laws {

using namespace balance;

namespace {

class ClassMaker {
 public:
  ClassMaker(Kind kind, std::uint32_t seed)
      : random_(seed * 8 + static_cast<std::uint32_t>(kind)), belts_(seed + 1), kind_(kind) {
    planar_ = kind <= Kind::planar_loops;
    m_.name = name_of(kind) + " " + std::to_string(seed);
    m_.space = planar_ ? SpaceKind::planar : SpaceKind::spatial;
    if (!chance(0.1)) m_.gravity = 9 * anywhere();
    m_.bodies.emplace_back();
    m_.bodies[0].name = "ground";
  }

  Member make(double reach) {
    const int bodies = 2 + pick(planar_ ? 6 : 4);
    for (int b = 1; b <= bodies; ++b) add_body(b);
    null_space_ = allowed();
    const int loops = kind_ == Kind::planar_tree || kind_ == Kind::spatial_tree   ? 0
                      : kind_ == Kind::planar_loop || kind_ == Kind::spatial_loop ? 1
                                                                                  : 2 + pick(3);
    for (int loop = 0; loop < loops; ++loop) close_loop();
    for (int k = 0; k < 2; ++k)
      if (chance(0.25)) couple();
    add_masses();
    add_forces();
    drive(reach);
    return {{m_, t_}, start_, static_cast<int>(null_space_.cols())};
  }

 private:
  // written out: the standard's distributions differ between libraries
  double number(double low, double high) { return low + (high - low) * (random_() * 0x1p-32); }
  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool chance(double p) { return number(0, 1) < p; }
  Vector3 anywhere() {
    const double x = number(-1, 1), y = number(-1, 1);
    return {x, y, planar_ ? 0 : number(-1, 1)};
  }
  Vector3 direction() {
    Vector3 v = anywhere();
    while (v.norm() < 0.1) v = anywhere();
    return v.normalized();
  }
  bool flat() const { return planar_ || kind_ == Kind::flat_in_space; }
  Matrix3 turn() {
    return flat() ? rotation_about(Vector3::UnitZ(), number(-3, 3)) : rotation_from_rpy(3 * anywhere());
  }
  Matrix3 inertia(double size) {
    if (planar_) return Vector3(0, 0, size * number(0.1, 1)).asDiagonal();
    const double x = size * number(0.1, 1), y = size * number(0.1, 1), z = size * number(0.1, 1);
    const Vector3 second(x, y, z);
    const Matrix3 R = rotation_from_rpy(3 * anywhere());
    return R * Matrix3((Vector3::Constant(second.sum()) - second).asDiagonal()) * R.transpose();
  }
  int coordinates() const { return static_cast<int>(m_.coordinates.size()); }

  JointType type() {
    using enum JointType;
    static const JointType flat_[] = {revolute,  revolute, revolute,          revolute,
                                      prismatic, pin_slot, JointType::planar, fixed};
    static const JointType space[] = {revolute,  revolute,  revolute,          prismatic, cylindrical,
                                      universal, spherical, JointType::planar, fixed};
    static const JointType layered[] = {revolute, revolute, revolute, prismatic, JointType::planar};
    return planar_ ? flat_[pick(8)] : flat() ? layered[pick(5)] : space[pick(9)];
  }

  Joint joint(JointType type, int first, int second) {
    Joint out;
    out.name = "J" + std::to_string(m_.joints.size() + 1);
    out.type = type, out.first = first, out.second = second;
    const bool slides = type == JointType::prismatic || type == JointType::pin_slot;
    out.axis = flat() && !slides ? Vector3(0, 0, 1) : direction();
    if (kind_ == Kind::flat_in_space && slides) out.axis = rotation_about(Vector3::UnitZ(), number(-3, 3)).col(0);
    if (planar_ && type == JointType::planar) out.axis2 = direction();
    if (!planar_) {
      out.axis2 = flat() ? Vector3(rotation_about(Vector3::UnitZ(), number(-3, 3)).col(0)) : direction();
      while (out.axis.cross(out.axis2).norm() < 0.1) out.axis2 = direction();
      out.axis2 = (out.axis2 - out.axis2.dot(out.axis) * out.axis).normalized();
    }
    out.point_first = 0.6 * anywhere(), out.point_second = 0.6 * anywhere();
    out.rotation = turn();
    return out;
  }

  /// With its coordinates' values at the start.
  void add(const Joint& joint) {
    m_.joints.push_back(joint);
    m_.coordinates = list_coordinates(m_.space, m_.joints);
    const auto before = start_.size();
    start_.conservativeResize(coordinates());
    for (auto c = before; c < start_.size(); ++c) start_[c] = number(-0.6, 0.6);
  }

  void add_body(int b) {
    Body body;
    body.name = "body" + std::to_string(b);
    body.mass = number(0.5, 2);
    body.com = 0.3 * anywhere();
    body.inertia = inertia(0.1);
    m_.bodies.push_back(body);
    const int parent = chance(0.7) ? b - 1 : pick(b);
    const bool forward = chance(0.6);
    JointType kind = type();
    while (b == 1 && kind == JointType::fixed) kind = type();
    add(joint(kind, forward ? parent : b, forward ? b : parent));
  }

  /// Velocities that joints and couplings allow at the start.
  MatrixX allowed() const {
    const VectorX here = disagreement(m_, start_);
    MatrixX jacobian(here.size(), start_.size());
    constexpr double h = 1e-5;
    for (Eigen::Index c = 0; c < start_.size(); ++c) {
      const VectorX unit = h * VectorX::Unit(start_.size(), c);
      jacobian.col(c) = (disagreement(m_, start_ + unit) - disagreement(m_, start_ - unit)) / (2 * h);
    }
    const Eigen::JacobiSVD<MatrixX> svd(jacobian, Eigen::ComputeFullV);
    Eigen::Index rank = 0;
    while (rank < svd.singularValues().size() && svd.singularValues()[rank] > 1e-6) ++rank;
    return svd.matrixV().rightCols(start_.size() - rank);
  }

  void close_loop() {
    const Mechanism open = m_;
    const VectorX before = start_;
    const std::vector<Pose> world = poses(m_, start_);
    for (int attempt = 0; attempt < 20; ++attempt) {
      const int bodies = static_cast<int>(m_.bodies.size()), one = pick(bodies),
                other = (one + 1 + pick(bodies - 1)) % bodies;
      const JointType kind = type();
      if (kind == JointType::fixed) continue;
      Joint closing = joint(kind, one, other);
      add(closing);
      closing.rotation = Matrix3::Identity();
      const Pose d = displacement(closing, planar_, start_.data() + before.size()), &a = world[one], &b = world[other];
      Joint& last = m_.joints.back();
      last.rotation = d.R.transpose() * a.R.transpose() * b.R;
      last.point_second = b.R.transpose() * (a.p + a.R * (closing.point_first + d.p) - b.p);
      const MatrixX space = allowed();
      if (space.cols() >= 1 && last.point_second.norm() < 3) {
        null_space_ = space;
        return;
      }
      m_ = open, start_ = before;
    }
  }

  static bool leads(const Coupling& coupling, int coordinate) {
    return std::any_of(coupling.leader.terms.begin(), coupling.leader.terms.end(),
                       [&](const model::CoordinateTerm& term) { return term.coordinate == coordinate; });
  }

  /// The coordinate, every other time with a second one over which its belt runs.
  model::CoordinateCombination belt(int coordinate, int but) {
    model::CoordinateCombination out = coordinate;
    const int other = static_cast<int>(belts_() % static_cast<unsigned>(coordinates()));
    const bool follows = std::any_of(m_.couplings.begin(), m_.couplings.end(),
                                     [&](const Coupling& coupling) { return coupling.follower == other; });
    if (belts_() % 2 == 0 && other != coordinate && other != but && !follows)
      out.terms.push_back({other, -1.5 + 3 * static_cast<double>(belts_() % 1000) / 1000});
    return out;
  }

  void couple() {
    if (null_space_.cols() < 2) return;
    const int n = coordinates(), leader = pick(n), follower = (leader + 1 + pick(n - 1)) % n;
    for (const Coupling& other : m_.couplings)
      if (other.follower == follower || leads(other, follower) || other.follower == leader) return;
    const double ratio = chance(0.5) ? number(0.5, 2) : -number(0.5, 2);
    const model::CoordinateCombination led_by = belt(leader, follower);
    m_.couplings.push_back({follower, led_by, ratio, start_[follower] - ratio * led_by.evaluate(start_)});
    const MatrixX space = allowed();
    if (space.cols() == null_space_.cols() - 1)
      null_space_ = space;
    else
      m_.couplings.pop_back();
  }

  void add_masses() {
    const int last = static_cast<int>(m_.bodies.size()) - 1;
    m_.attachments.push_back({"weight", AttachmentKind::counterweight, 1 + pick(last), 0.4 * anywhere(), 0.7,
                              chance(0.5) ? inertia(0.02) : Matrix3(Matrix3::Zero())});
    if (chance(0.5))
      m_.attachments.push_back(
          {"cargo", AttachmentKind::payload, 1 + pick(last), 0.4 * anywhere(), 0.3, Matrix3::Zero()});
    for (int k = 0; k < 2 && coordinates() > 0; ++k) {
      Disc disc;
      disc.name = "disc" + std::to_string(k);
      disc.body = k == 0 ? 1 + pick(last) : pick(last + 1);
      disc.position = 0.3 * anywhere();
      disc.axis = planar_ ? Vector3(0, 0, 1) : direction();
      disc.follows = belt(pick(coordinates()), -1);
      disc.ratio = number(-3, 3), disc.mass = 0.4, disc.inertia = inertia(0.02);
      if (chance(0.6)) m_.discs.push_back(disc);
    }
  }

  void add_forces() {
    const int bodies = static_cast<int>(m_.bodies.size());
    const Vector3 moment = planar_ ? Vector3(0, 0, 1) : direction();
    if (chance(0.7))
      m_.loads.push_back(
          {"push", 1 + pick(bodies - 1), 0.3 * anywhere(), model::Frame::body, {}, {5 * anywhere()}, {moment}});
    if (chance(0.5))
      m_.loads.push_back({"pull",
                          1 + pick(bodies - 1),
                          0.3 * anywhere(),
                          model::Frame::world,
                          {0.2, 0.5},
                          {5 * anywhere(), 5 * anywhere()},
                          {moment, -moment}});
    const int one = pick(bodies), other = (one + 1 + pick(bodies - 1)) % bodies;
    const Vector3 end = 0.5 * anywhere(), far = 0.5 * anywhere() + Vector3(2, 0, 0);
    if (chance(0.5)) m_.springs.push_back({"s1", one, other, end, far, 30, 0.2});
    if (chance(0.5)) m_.springs.push_back({"s2", other, one, far, end, 20, 0});
    if (!m_.springs.empty())  // without a die, so that every seed makes the mechanism that it always made
      m_.springs.push_back({.name = "s3", .stiffness = 4, .preload = 1.5, .coordinate = (one + other) % coordinates()});
    if (!m_.loads.empty())
      m_.loads.push_back({"wave",
                          1 + one % (bodies - 1),
                          Vector3(0.1, 0.2, 0),
                          model::Frame::world,
                          {-10, -4, 3, 10},
                          {Vector3(3, -2, 0), Vector3(-1, 2, 0), Vector3(0, -2, 0), Vector3(2, 1, 0)},
                          {moment, -moment, 2 * moment, moment},
                          (one + other) % coordinates(),
                          false,
                          true});
    add_force_elements(one, other, end, far);
    if (chance(0.7)) {
      const int coordinate = pick(coordinates());
      const double dry = chance(0.5) ? 0.5 : 0;
      m_.friction.push_back({.coordinate = coordinate, .viscous = 0.3, .coulomb = dry, .coulomb_backward = dry / 2});
    }
  }

  /// Where there is a spring there are dampers and springs with tables, too; without a die, as above. The tables reach
  /// beyond all motions.
  void add_force_elements(int one, int other, const Vector3& end, const Vector3& far) {
    if (m_.springs.empty()) return;
    m_.force_elements.push_back({"d1", one, other, end, far, -1, {}, 1.5});
    m_.force_elements.push_back({"d2", other, one, end, far, -1, {}, 0.4});
    const model::ForceTableOf<double> over_length{
        {0, 1, 2.5, 4, 40}, {-3, 0, 5, 4, 60}, model::TableInterpolation::spline};
    const model::ForceTableOf<double> over_coordinate{
        {-90, -4, -1, 1, 5, 90}, {7, 3, 0.5, -0.5, -2, -9}, model::TableInterpolation::spline};
    m_.force_elements.push_back({"t1", one, other, far, end, -1, over_length, 0});
    m_.force_elements.push_back({"t2", 0, 0, {}, {}, one % coordinates(), over_coordinate, 0});
  }

  /// Coordinates that move as freely of each other as any.
  std::vector<CoordinateId> well_conditioned() {
    std::vector<CoordinateId> order(static_cast<std::size_t>(coordinates())), chosen;
    for (std::size_t c = 0; c < order.size(); ++c) order[c] = static_cast<int>(c);
    for (std::size_t c = order.size(); c > 1; --c) std::swap(order[c - 1], order[pick(static_cast<int>(c))]);
    MatrixX rest = null_space_;
    for (double least = 0.4; static_cast<Eigen::Index>(chosen.size()) < null_space_.cols(); least /= 2)
      for (const int c : order) {
        const double size = rest.row(c).norm();
        if (size < least || static_cast<Eigen::Index>(chosen.size()) == null_space_.cols()) continue;
        chosen.push_back(c);
        const VectorX along = rest.row(c).transpose() / size;
        rest -= (rest * along) * along.transpose();
      }
    return chosen;
  }

  void drive(double reach) {
    for (int c = 0; c < coordinates(); ++c) m_.assembly.push_back({c, start_[c]});
    m_.tool = Tool{static_cast<int>(m_.bodies.size()) - 1, "H", 0.3 * anywhere()};
    m_.actuators = well_conditioned();
    static const MotionLawKind laws[] = {MotionLawKind::polynomial_345, MotionLawKind::polynomial_4567,
                                         MotionLawKind::cycloidal, MotionLawKind::bang_bang,
                                         MotionLawKind::modified_trapezoidal};
    t_.name = "random";
    t_.law.kind = laws[pick(5)];
    if (chance(0.3) && null_space_.cols() <= (planar_ ? 3 : 6))
      t_.drive = chance(0.5) ? DriveKind::tool : DriveKind::com;
    else
      t_.drive = DriveKind::joints;
    t_.duration = number(0.5, 1);
    t_.about = anywhere();
    for (const int c : m_.actuators) {
      t_.from.joints.push_back({c, start_[c]});
      t_.to.joints.push_back({c, start_[c] + reach * number(-1, 1)});
    }
    if (!chance(0.05) || static_cast<int>(m_.actuators.size()) == coordinates()) return;
    for (int c = 0; c < coordinates(); ++c)  // one motor more than needed
      if (std::find(m_.actuators.begin(), m_.actuators.end(), c) == m_.actuators.end()) {
        m_.actuators.push_back(c);
        break;
      }
  }

  std::mt19937 random_, belts_;
  Kind kind_;
  bool planar_;
  Mechanism m_;
  Trajectory t_;
  VectorX start_;
  MatrixX null_space_;
};

}  // namespace

std::string name_of(Kind kind) {
  static const char* const names[] = {"planar tree",  "planar loop",   "planar loops", "spatial tree",
                                      "spatial loop", "spatial loops", "flat in space"};
  return names[static_cast<int>(kind)];
}

VectorX disagreement(const Mechanism& m, const VectorX& q) {
  const bool planar = m.space == SpaceKind::planar;
  const std::vector<Pose> world = poses(m, q);
  VectorX out(static_cast<Eigen::Index>(12 * m.joints.size() + m.couplings.size()));
  Eigen::Index at = 0, c = 0;
  for (const Joint& joint : m.joints) {
    const Pose d = displacement(joint, planar, q.data() + c), &a = world[joint.first], &b = world[joint.second];
    c += joint_degrees_of_freedom(joint.type);
    out.segment<3>(at) = a.p + a.R * (joint.point_first + d.p) - b.p - b.R * joint.point_second;
    out.segment<9>(at + 3) = (a.R * d.R - b.R).reshaped();
    at += 12;
  }
  for (const Coupling& coupling : m.couplings)
    out[at++] = q[coupling.follower] - coupling.ratio * coupling.leader.evaluate(q) - coupling.offset;
  return out;
}

Member member(Kind kind, std::uint32_t seed, double reach) { return ClassMaker(kind, seed).make(reach); }

}  // namespace laws
