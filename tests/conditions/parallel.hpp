#pragma once
/// Random parallel mechanisms: legs that carry a platform, in general position, with everything that bodies may carry.

#include "hand_made.hpp"

namespace hand_made {

class ParallelMaker {
 public:
  ParallelMaker(SpaceKind space, unsigned seed) : random_(seed), planar_(space == SpaceKind::planar) {
    m_.name = "random";
    m_.space = space;
    m_.gravity = 9 * place(1);
    m_.bodies.emplace_back();
    m_.bodies[0].name = "ground";
  }

  /// Legs of two links: planar RRR (or with a slide on the platform), spatial with universal, revolute and spherical joints.
  Mechanism make(int legs) {
    // The platform's frame is the world's at the start, every link's frame too, up to a shift.
    for (int leg = 0; leg < legs; ++leg) {
      const int lower = add_body("lower"), upper = add_body("upper");
      const Vector3 foot = 2 * place(1), knee = 2 * place(1), hip = place(0.7);
      hips_.push_back(hip);
      at_[static_cast<std::size_t>(lower)] = foot, at_[static_cast<std::size_t>(upper)] = knee;
      join(planar_ ? JointType::revolute : JointType::universal, model::ground, lower, foot);
      join(JointType::revolute, lower, upper, knee);
    }
    platform_ = add_body("platform");
    for (int leg = 0; leg < legs; ++leg) {
      const bool backwards = leg % 2 == 1;
      const JointType type = !planar_            ? JointType::spherical
                             : leg == slide_leg_ ? JointType::prismatic
                                                 : JointType::revolute;
      join(type, backwards ? platform_ : 2 + 2 * leg, backwards ? 2 + 2 * leg : platform_,
           hips_[static_cast<std::size_t>(leg)]);
    }
    m_.coordinates = list_coordinates(m_.space, m_.joints);
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c) m_.assembly.push_back({static_cast<int>(c), 0});
    reshape(m_, random_);
    return m_;
  }

  ParallelMaker& slide_on_platform(int leg) {
    slide_leg_ = leg;
    return *this;
  }

  /// To be called after make.
  Mechanism fitted() {
    attach("cargo", platform_), attach("weight", 1), attach("other weight", 2);
    // Legs' discs that follow joints of their own leg and of another, one on the platform, one on a lower link.
    add_disc("own", 1, 1), add_disc("across", 2, 3), add_disc("top", platform_, 0);
    m_.springs.push_back({"s1", model::ground, 1, place(1), place(1), 30, 0});
    m_.springs.push_back({"s2", 1, 2, place(1), place(1), 20, 0});
    m_.springs.push_back({"s3", 2, platform_, place(1), place(1), 10, 0});
    return m_;
  }

 private:
  Vector3 place(double size) {
    return planar_ ? random_.place(size).cwiseProduct(Vector3(1, 1, 0)) : random_.place(size);
  }

  int add_body(const std::string& name) {
    m_.bodies.emplace_back();
    at_.resize(m_.bodies.size(), Vector3::Zero());
    const int body = static_cast<int>(m_.bodies.size()) - 1;
    m_.bodies.back().name = name + std::to_string(body);
    return body;
  }

  void join(JointType type, int first, int second, const Vector3& at) {
    Joint joint;
    joint.name = "J" + std::to_string(m_.joints.size());
    joint.type = type;
    joint.first = first, joint.second = second;
    joint.point_first = at - at_[static_cast<std::size_t>(first)];
    joint.point_second = at - at_[static_cast<std::size_t>(second)];
    joint.axis = planar_ && type == JointType::revolute ? Vector3(0, 0, 1) : Vector3(place(1).normalized());
    if (!planar_) joint.axis2 = joint.axis.cross(place(1)).normalized();
    m_.joints.push_back(joint);
  }

  void attach(const std::string& name, int body) {
    const auto kind = body == platform_ ? AttachmentKind::payload : AttachmentKind::counterweight;
    const Matrix3 inertia = planar_ ? Matrix3(Vector3(0, 0, 0.02).asDiagonal()) : Matrix3(0.02 * Matrix3::Identity());
    m_.attachments.push_back({name, kind, body, place(0.5), 0.7, inertia});
  }

  void add_disc(const std::string& name, int body, int joint) {
    Disc disc;
    disc.name = name, disc.body = body;
    disc.position = place(0.5);
    disc.axis = planar_ ? Vector3(0, 0, 1) : Vector3(place(1).normalized());
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c)
      if (m_.coordinates[c].joint == joint) disc.follows = static_cast<int>(c);
    disc.ratio = -1.7, disc.mass = 0.4;
    disc.inertia.diagonal() = planar_ ? Vector3(0, 0, 0.03) : Vector3(0.02, 0.03, 0.025);
    m_.discs.push_back(disc);
  }

  RandomNumbers random_;
  bool planar_;
  int platform_ = 0, slide_leg_ = -1;
  Mechanism m_;
  std::vector<Vector3> at_{Vector3::Zero()};  ///< of the bodies' origins, at the start
  std::vector<Vector3> hips_;
};

}  // namespace hand_made
