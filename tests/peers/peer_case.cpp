#include "peer_case.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <filesystem>

namespace balance::peers {

PeerCase read_peer_case(const std::string& path) {
  const Study study = read_spec_file(path);
  if (study.trajectories.empty()) throw NotComparable("has no motion");
  if (!study.temporary_payloads.empty()) throw NotComparable("has payloads that come and go");
  PeerCase out;
  out.name = std::filesystem::path(path).stem().string();
  out.motion = study.trajectories.front();
  out.mechanism = study.mechanism;
  out.tree = read_rigid_tree(study.mechanism);
  if (out.tree.motion_count() == 0) throw NotComparable("has nothing that moves");
  out.run = simulate(out.mechanism, out.motion);
  if (out.run.outcome.status != MotionStatus::done) throw NotComparable(out.run.outcome.reason);
  const MatrixX motions = out.tree.motions_of_coordinates.transpose();
  out.x = out.run.joint_position * motions;
  out.dx = out.run.joint_velocity * motions;
  out.ddx = out.run.joint_acceleration * motions;
  return out;
}

}  // namespace balance::peers
