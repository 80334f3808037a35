#include "balance/control/massless_freedom.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/control/tree_state.hpp"

#include <algorithm>

namespace balance {

namespace {

constexpr double inertia_epsilon = 1e-14;  // of the largest inertia: round-off

bool has_singular_inertia(const Body& body) { return body.mass == 0 || body.inertia.isZero(0); }

std::string describe_missing_inertia(const Body& body) {
  return "body '" + body.name + "' has no " + (body.mass == 0 ? "mass" : "moment of inertia");
}

/// The light body on a joint, else all light ones.
std::string light_bodies(const Mechanism& mechanism, JointId joint) {
  for (const BodyId body : {mechanism.joints[joint].second, mechanism.joints[joint].first})
    if (body != ground && has_singular_inertia(mechanism.bodies[body]))
      return describe_missing_inertia(mechanism.bodies[body]);
  std::string all;
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (has_singular_inertia(mechanism.bodies[b]))
      all += (all.empty() ? "" : ", ") + describe_missing_inertia(mechanism.bodies[b]);
  return all;
}

}  // namespace

template <class S>
MotionOutcome check_mass_matrix(const Mechanism& mechanism, LoopDynamics<S>& loops, double time, const double* dy) {
  const MotionOutcome fine{MotionStatus::done, time, "", {}};
  if (std::none_of(mechanism.bodies.begin() + 1, mechanism.bodies.end(), has_singular_inertia) || loops.freedoms() == 0)
    return fine;
  loops.compute_tree_terms(time, dy);
  loops.reduce_to_independent();
  MatrixX mass = loops.reduced_mass();
  for (int a = 0; a < loops.freedoms(); ++a) {
    mass.row(a) *= loops.scale()[loops.independent()[a]];
    mass.col(a) *= loops.scale()[loops.independent()[a]];
  }
  const SymmetricEigenSolver solver(mass);
  const VectorX& sizes = solver.eigenvalues();  // increasing
  if (sizes[0] > inertia_epsilon * sizes[sizes.size() - 1]) return fine;
  const Eigen::Index free = max_index(solver.eigenvectors().col(0).cwiseAbs());
  const CoordinateId coordinate = find_column_coordinates(loops.tree())[loops.independent()[free]];
  return {MotionStatus::actuation_singularity,
          time,
          "the mass matrix is singular: no mass resists an acceleration of " + mechanism.coordinates[coordinate].name +
              "; " + light_bodies(mechanism, mechanism.coordinates[coordinate].joint),
          {}};
}

template MotionOutcome check_mass_matrix(const Mechanism&, LoopDynamics<Planar>&, double, const double*);
template MotionOutcome check_mass_matrix(const Mechanism&, LoopDynamics<Spatial>&, double, const double*);

}  // namespace balance
