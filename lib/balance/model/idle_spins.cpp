#include "balance/model/incidence.hpp"
#include "balance/model/spanning_tree.hpp"

#include <algorithm>

namespace balance {

namespace {

Vector3 point_on(const Joint& joint, int body) { return joint.first == body ? joint.point_first : joint.point_second; }

/// Something acts on the body from elsewhere than its joints.
bool is_touched(const Mechanism& mechanism, int body) {
  const auto on = [body](const auto& part) { return part.body == body; };
  return std::any_of(mechanism.discs.begin(), mechanism.discs.end(), on) ||
         std::any_of(mechanism.loads.begin(), mechanism.loads.end(), on) ||
         std::any_of(mechanism.springs.begin(), mechanism.springs.end(),
                     [body](const Spring& spring) { return spring.first == body || spring.second == body; }) ||
         (mechanism.tool && mechanism.tool->body == body);
}

/// First moment of the body and what is fixed to it, divided by its mass.
Vector3 common_com(const Mechanism& mechanism, int body) {
  double mass = mechanism.bodies[body].mass;
  Vector3 moment = mass * mechanism.bodies[body].com;
  for (const Attachment& extra : mechanism.attachments) {
    if (extra.body != body) continue;
    mass += extra.mass;
    moment += extra.mass * extra.position;
  }
  return moment / mass;
}

}  // namespace

std::vector<IdleSpin> idle_spins(const Mechanism& mechanism, const std::vector<int>& needed) {
  constexpr double on_line = 1e-6;  // of the distance between the joints: what rounded coordinates leave
  const std::vector<bool> keep = joints_needed(mechanism, needed);
  const std::vector<std::vector<int>> joints = joints_of_bodies(mechanism);
  std::vector<IdleSpin> spins;
  for (int body = 1; body < static_cast<int>(mechanism.bodies.size()); ++body) {
    const std::vector<int>& at = joints[body];
    const bool balls = std::all_of(at.begin(), at.end(),
                                   [&](int j) { return mechanism.joints[j].type == JointType::spherical && !keep[j]; });
    if (at.size() != 2 || !balls || is_touched(mechanism, body)) continue;
    const Vector3 A = point_on(mechanism.joints[at[0]], body), B = point_on(mechanism.joints[at[1]], body);
    const double length = (B - A).norm();
    if (length == 0) continue;
    const Vector3 line = (B - A) / length;
    const Vector3 off = line.cross(common_com(mechanism, body) - A);
    if (off.norm() <= on_line * length) spins.push_back({body, line, {at[0], at[1]}});
  }
  return spins;
}

}  // namespace balance
