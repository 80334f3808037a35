#include "peer_case.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <filesystem>
#include <vector>

namespace balance::peers {

namespace {

/// Takes away what other libraries are not asked about, and says what that was: " without springs".
std::string remove_forces(Mechanism& mechanism) {
  std::string removed;
  const auto note = [&](bool is_removed, const char* what) {
    if (is_removed) removed += (removed.empty() ? " without " : ", ") + std::string(what);
  };
  note(!mechanism.springs.empty(), "springs");
  note(!mechanism.loads.empty(), "loads");
  note(!mechanism.friction.empty(), "friction");
  mechanism.springs.clear();
  mechanism.loads.clear();
  mechanism.friction.clear();
  note(std::erase_if(mechanism.attachments, model::is_temporary_payload<double>) > 0, "payloads that come and go");
  return removed;
}

}  // namespace

PeerCase read_peer_case(const std::string& path) {
  const Study study = read_spec_file(path);
  if (study.trajectories.empty()) throw NotComparable("has no motion");
  PeerCase out;
  out.motion = study.trajectories.front();
  out.mechanism = study.mechanism;
  out.name = std::filesystem::path(path).stem().string() + remove_forces(out.mechanism);
  out.tree = read_rigid_tree(out.mechanism);
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
