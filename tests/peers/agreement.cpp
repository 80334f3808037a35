#include "agreement.hpp"

#include "peer_efforts.hpp"

#include <algorithm>
#include <limits>

namespace balance::peers {
namespace {

/// Largest magnitude in a run. Where terms cancel to nothing, as in a balanced mechanism, it is that of the terms: the
/// rest is their round-off.
double find_scale(const Samples& values, const VectorX& terms) {
  constexpr double cancellation_threshold = 1e-6;
  const double term = terms.size() == 0 ? 0 : terms.maxCoeff(), value = values.cwiseAbs().maxCoeff();
  return std::max(value, value < cancellation_threshold * term ? term : 0.0);
}

/// The peer's vector of a sample less balance's, which has fewer components in the plane.
double vector_difference(const Vector3& peer, const Eigen::Ref<const Eigen::RowVectorXd>& ours) {
  if (ours.size() == 1) return std::abs(peer.z() - ours[0]);
  return (peer.head(ours.size()) - ours.transpose()).cwiseAbs().maxCoeff();
}

}  // namespace

Agreement compare_with_peer(const PeerCase& subject, Peer& peer) {
  const RunResult& run = subject.run;
  PeerEfforts efforts(subject.tree, peer, subject.x.row(0), subject.dx.row(0), subject.ddx.row(0));
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  Agreement worst;
  if (!peer.gives_ground_wrench()) worst.ground_force = worst.ground_moment = nothing;
  for (Eigen::Index k = 0; k < subject.x.rows(); ++k) {
    const VectorX& found = efforts.compute(subject.x.row(k), subject.dx.row(k), subject.ddx.row(k));
    worst.efforts = std::max(worst.efforts, (found.transpose() - run.torque.row(k)).cwiseAbs().maxCoeff());
    worst.closure = std::max(worst.closure, peer.closure_residual());
    if (!subject.tree.cut_joints.empty()) {
      const VectorX rate = peer.compute_closure_jacobian() * subject.dx.row(k).transpose();
      worst.closure_rate = std::max(worst.closure_rate, rate.cwiseAbs().maxCoeff());
    }
    if (!peer.gives_ground_wrench()) continue;
    const WorldWrench wrench = peer.ground_wrench();
    const Vector3 moment = wrench.moment - run.moment_reference.cross(wrench.force);
    // balance gives what the mechanism exerts on the ground
    worst.ground_force = std::max(worst.ground_force, vector_difference(-wrench.force, run.ground_force.row(k)));
    worst.ground_moment = std::max(worst.ground_moment, vector_difference(-moment, run.ground_moment.row(k)));
  }
  worst.efforts /= find_scale(run.torque, run.term_magnitudes.effort);
  worst.ground_force /= find_scale(run.ground_force, run.term_magnitudes.force);
  worst.ground_moment /= find_scale(run.ground_moment, run.term_magnitudes.moment);
  worst.closure_rate /= subject.dx.cwiseAbs().maxCoeff();
  return worst;
}

}  // namespace balance::peers
