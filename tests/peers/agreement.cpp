#include "agreement.hpp"

#include "peer_efforts.hpp"

#include <algorithm>
#include <cmath>

namespace balance::peers {
namespace {

/// Largest magnitude in a run, or a thousandth of that of its terms: where these cancel, as in a balanced mechanism, their
/// round-off is left. Where there are no terms, it is one unit.
double find_scale(const Samples& values, const VectorX& terms) {
  const double term = terms.size() == 0 ? 0 : terms.maxCoeff();
  const double scale = std::max(values.cwiseAbs().maxCoeff(), 1e-3 * term);
  return scale == 0 ? 1 : scale;
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
  Agreement worst;
  double force = 0, moment = 0;
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
    const Vector3 about_reference = wrench.moment - run.moment_reference.cross(wrench.force);
    // balance gives what the mechanism exerts on the ground
    force = std::max(force, vector_difference(-wrench.force, run.ground_force.row(k)));
    moment = std::max(moment, vector_difference(-about_reference, run.ground_moment.row(k)));
  }
  worst.efforts /= find_scale(run.torque, run.term_magnitudes.effort);
  if (peer.gives_ground_wrench()) {
    worst.ground_force = force / find_scale(run.ground_force, run.term_magnitudes.force);
    worst.ground_moment = moment / find_scale(run.ground_moment, run.term_magnitudes.moment);
  }
  worst.closure_rate /= find_scale(subject.dx, {});
  return worst;
}

}  // namespace balance::peers
