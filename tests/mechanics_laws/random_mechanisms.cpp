#include "random_mechanisms.hpp"

#include "runs.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <algorithm>
#include <random>

namespace laws {

using namespace balance;
using namespace balance::model;

namespace {

class Maker {
 public:
  Maker(SpaceKind space, std::uint32_t seed) : random_(seed), belts_(seed + 1), planar_(space == SpaceKind::planar) {
    m_.name = "random " + std::to_string(seed);
    m_.space = space;
    m_.gravity = 9 * anywhere();
    m_.bodies.emplace_back();
    m_.bodies[0].name = "ground";
  }

  std::optional<Experiment> make() {
    const int bodies = 2 + pick(planar_ ? 3 : 2);
    for (int b = 1; b <= bodies; ++b) add_body(b);
    m_.coordinates = list_coordinates(m_.space, m_.joints);
    start_ = VectorX::Zero(static_cast<long>(m_.coordinates.size()));
    for (double& q : start_) q = number(-0.6, 0.6);
    freedoms_ = static_cast<int>(m_.coordinates.size());
    if (chance(0.7)) close_loop();
    if (chance(0.4)) couple();
    add_masses();
    add_forces();
    return drive();
  }

 private:
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool chance(double p) { return number(0, 1) < p; }
  Vector3 anywhere() { return {number(-1, 1), number(-1, 1), planar_ ? 0 : number(-1, 1)}; }
  Vector3 direction() { return anywhere().normalized(); }
  Matrix3 turn() {
    return planar_ ? rotation_about(Vector3::UnitZ(), number(-3, 3)) : rotation_from_rpy(3 * anywhere());
  }
  /// Of a body that could exist: principal second moments are positive.
  Matrix3 inertia(double size) {
    if (planar_) return Vector3(0, 0, size * number(0.1, 1)).asDiagonal();
    const Vector3 second(size * number(0.1, 1), size * number(0.1, 1), size * number(0.1, 1));
    const Matrix3 R = turn();
    return R * Matrix3((Vector3::Constant(second.sum()) - second).asDiagonal()) * R.transpose();
  }

  Joint joint(JointType type, int first, int second) {
    Joint out;
    out.name = "J" + std::to_string(m_.joints.size() + 1);
    out.type = type;
    out.first = first, out.second = second;
    const bool slides = type == JointType::prismatic || type == JointType::pin_slot;
    out.axis = planar_ && !slides ? Vector3(0, 0, 1) : direction();
    if (planar_ && type == JointType::planar) out.axis2 = direction();
    if (!planar_) out.axis2 = out.axis.cross(direction()).normalized();
    out.point_first = 0.5 * anywhere(), out.point_second = 0.5 * anywhere();
    out.rotation = turn();
    return out;
  }

  JointType type() {
    using enum JointType;
    static const JointType flat[] = {revolute, revolute, revolute, prismatic, pin_slot, JointType::planar, fixed};
    static const JointType space[] = {revolute,  revolute,          prismatic, cylindrical,    universal,
                                      spherical, JointType::planar, fixed,     JointType::free};
    return planar_ ? flat[pick(7)] : space[pick(9)];
  }

  void add_body(int b) {
    Body body;
    body.name = "body" + std::to_string(b);
    body.mass = number(0.5, 2);
    body.com = 0.3 * anywhere();
    body.inertia = inertia(0.1);
    m_.bodies.push_back(body);
    const int parent = chance(0.8) ? b - 1 : pick(b);
    const bool forward = chance(0.6);
    const JointType kind = b == 1 ? JointType::revolute : type();
    m_.joints.push_back(joint(kind, forward ? parent : b, forward ? b : parent));
  }

  /// A joint between two bodies as they lie at the start, at coordinates near zero there.
  void close_loop() {
    const BodyId last = static_cast<int>(m_.bodies.size()) - 1;
    const std::vector<Pose> world = poses(m_, start_);
    for (int attempt = 0; attempt < 20; ++attempt) {
      const JointType kind = type();
      const int lost = (planar_ ? 3 : 6) - joint_degrees_of_freedom(kind);
      if (kind == JointType::fixed || lost == 0 || freedoms_ - lost < 1) continue;
      const bool forward = chance(0.5);
      Joint closing = joint(kind, forward ? ground : last, forward ? last : ground);
      const Pose &a = world[closing.first], &b = world[closing.second];
      closing.rotation = a.R.transpose() * b.R;
      closing.point_second = b.R.transpose() * (a.p + a.R * closing.point_first - b.p);
      m_.joints.push_back(closing);
      m_.coordinates = list_coordinates(m_.space, m_.joints);
      start_.conservativeResize(static_cast<long>(m_.coordinates.size()));
      start_.tail(joint_degrees_of_freedom(kind)).setZero();
      freedoms_ -= lost;
      return;
    }
  }

  /// The coordinate, every other time with a second and a third one over which its belt runs.
  CoordinateCombination belt(int coordinate, int but) {
    CoordinateCombination out = coordinate;
    for (int k = 0; k < 2 && belts_() % 2 == 0; ++k) {
      const int other = static_cast<int>(belts_() % m_.coordinates.size());
      const bool known = std::any_of(out.terms.begin(), out.terms.end(),
                                     [&](const CoordinateTerm& term) { return term.coordinate == other; });
      if (!known && other != but) out.terms.push_back({other, -1.5 + 3 * static_cast<double>(belts_() % 1000) / 1000});
    }
    return out;
  }

  void couple() {
    if (freedoms_ < 2) return;
    const int n = static_cast<int>(m_.coordinates.size()), leader = pick(n), follower = (leader + 1 + pick(n - 1)) % n;
    const double ratio = chance(0.5) ? number(0.5, 2) : -number(0.5, 2);
    const CoordinateCombination led_by = belt(leader, follower);
    m_.couplings.push_back({follower, led_by, ratio, start_[follower] - ratio * led_by.evaluate(start_)});
    --freedoms_;
  }

  void add_masses() {
    const BodyId last = static_cast<int>(m_.bodies.size()) - 1;
    m_.attachments.push_back(
        {"weight", AttachmentKind::counterweight, 1 + pick(last), 0.4 * anywhere(), 0.7, inertia(0.02)});
    for (int k = 0; k < 2; ++k) {
      Disc disc;
      disc.name = "disc" + std::to_string(k);
      disc.body = k == 0 ? 1 + pick(last) : pick(last + 1);
      disc.position = 0.3 * anywhere();
      disc.axis = planar_ ? Vector3(0, 0, 1) : direction();
      disc.follows = belt(pick(static_cast<int>(m_.coordinates.size())), -1);
      disc.ratio = number(-3, 3);
      disc.mass = 0.4;
      disc.inertia = inertia(0.02);
      if (k == 0 || chance(0.5)) m_.discs.push_back(disc);
    }
  }

  void add_forces() {
    const int bodies = static_cast<int>(m_.bodies.size());
    const Vector3 moment = planar_ ? Vector3(0, 0, 1) : direction();
    m_.loads.push_back({"push", 1 + pick(bodies - 1), 0.3 * anywhere(), Frame::body, {}, {5 * anywhere()}, {moment}});
    m_.loads.push_back({"pull",
                        1 + pick(bodies - 1),
                        0.3 * anywhere(),
                        Frame::world,
                        {0.2, 0.5, 0.9},
                        {5 * anywhere(), 5 * anywhere(), 5 * anywhere()},
                        {moment, -moment, 2 * moment}});
    const int one = pick(bodies), other = (one + 1 + pick(bodies - 1)) % bodies;
    m_.springs.push_back({"s1", one, other, 0.5 * anywhere(), 0.5 * anywhere() + Vector3(2, 0, 0), 30, 0.2});
    m_.springs.push_back({"s2", other, one, 0.5 * anywhere(), 0.5 * anywhere(), 20, 0});
    const int coordinates = static_cast<int>(m_.coordinates.size());
    m_.springs.push_back({.name = "s3", .stiffness = 4, .preload = 1.5, .coordinate = (one + other) % coordinates});
    m_.loads.push_back({"wave",
                        1 + one % (bodies - 1),
                        Vector3(0.1, 0.2, 0),
                        Frame::body,
                        {-10, -4, 3, 10},
                        {Vector3(3, -2, 0), Vector3(-1, 2, 0), Vector3(0, -2, 0), Vector3(2, 1, 0)},
                        {moment, -moment, 2 * moment, moment},
                        (one + other) % coordinates,
                        false,
                        true});
    m_.friction.push_back({.coordinate = pick(coordinates), .viscous = 0.3, .coulomb = 0.5, .coulomb_backward = 0.8});
    const Vector3 near(0.1, -0.2, 0), far(1.5, 0.3, planar_ ? 0 : 0.4);
    m_.force_elements.push_back({"d1", one, other, near, far, -1, {}, 1.5});
    m_.force_elements.push_back({"t1",
                                 other,
                                 one,
                                 far,
                                 near,
                                 -1,
                                 {{0, 1, 2.5, 4, 40}, {-3, 0, 5, 4, 60}, balance::model::TableInterpolation::spline},
                                 0});
  }

  std::optional<Experiment> drive() {
    std::vector<int> all(m_.coordinates.size());
    for (std::size_t c = 0; c < all.size(); ++c) {
      all[c] = static_cast<int>(c);
      m_.assembly.push_back({all[c], start_[all[c]]});
    }
    std::erase_if(all, [&](int c) {
      return !m_.couplings.empty() && m_.couplings[0].follower == c && m_.couplings[0].leader.terms.size() == 1;
    });
    m_.tool = Tool{static_cast<int>(m_.bodies.size()) - 1, "H", 0.3 * anywhere()};
    for (int attempt = 0; attempt < 6; ++attempt) {
      std::shuffle(all.begin(), all.end(), random_);
      m_.actuators.assign(all.begin(), all.begin() + freedoms_);
      Experiment out{m_, {}};
      Trajectory& t = out.trajectory;
      t.name = "random";
      t.law.kind = MotionLawKind::polynomial_345;
      t.drive = DriveKind::joints;
      if (attempt < 2 && chance(0.6)) t.drive = chance(0.5) ? DriveKind::tool : DriveKind::com;
      t.samples = 21;
      t.about = anywhere();
      for (const int c : m_.actuators) {
        t.from.joints.push_back({c, start_[c]});
        t.to.joints.push_back({c, start_[c] + number(-0.4, 0.4)});
      }
      const RunResult result = simulate(out.mechanism, t);
      if (result.outcome.status != MotionStatus::done || result.mobility.minCoeff() < 0.02) continue;
      if (result.joint_velocity.cwiseAbs().maxCoeff() < 20) return out;
    }
    return {};
  }

  std::mt19937 random_, belts_;
  bool planar_;
  Mechanism m_;
  VectorX start_;
  int freedoms_ = 0;
};

}  // namespace

std::optional<Experiment> random_experiment(SpaceKind space, std::uint32_t seed) { return Maker(space, seed).make(); }

}  // namespace laws
