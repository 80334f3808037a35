#include "balance/control/massless_freedom.hpp"

#include "balance/base/extrema.hpp"
#include "balance/base/factorizations.hpp"
#include "balance/control/tree_state.hpp"

#include <algorithm>

namespace balance {

namespace {

constexpr double nothing = 1e-14;  // of the largest inertia: round-off

bool is_light(const Body& body) { return body.mass == 0 || body.inertia.isZero(0); }

std::string what_lacks(const Body& body) {
  return "body '" + body.name + "' has no " + (body.mass == 0 ? "mass" : "moment of inertia");
}

/// The light body on a joint, else all light ones.
std::string light_bodies(const Mechanism& mechanism, JointId joint) {
  for (const BodyId body : {mechanism.joints[joint].second, mechanism.joints[joint].first})
    if (body != ground && is_light(mechanism.bodies[body])) return what_lacks(mechanism.bodies[body]);
  std::string all;
  for (std::size_t b = 1; b < mechanism.bodies.size(); ++b)
    if (is_light(mechanism.bodies[b])) all += (all.empty() ? "" : ", ") + what_lacks(mechanism.bodies[b]);
  return all;
}

}  // namespace

template <class S>
MotionOutcome check_masses(const Mechanism& mechanism, LoopDynamics<S>& loops, double time, const double* dy) {
  const MotionOutcome fine{MotionStatus::done, time, "", {}};
  if (std::none_of(mechanism.bodies.begin() + 1, mechanism.bodies.end(), is_light) || loops.freedoms() == 0)
    return fine;
  loops.prepare(time, dy);
  loops.transform();
  MatrixX mass = loops.reduced_mass();
  for (int a = 0; a < loops.freedoms(); ++a) {
    mass.row(a) *= loops.scale()[loops.independent()[a]];
    mass.col(a) *= loops.scale()[loops.independent()[a]];
  }
  const SymmetricEigenSolver solver(mass);
  const VectorX& sizes = solver.eigenvalues();  // increasing
  if (sizes[0] > nothing * sizes[sizes.size() - 1]) return fine;
  const Eigen::Index free = max_index(solver.eigenvectors().col(0).cwiseAbs());
  const CoordinateId coordinate = leaders(loops.tree())[loops.independent()[free]];
  return {MotionStatus::actuation_singularity,
          time,
          "the mass matrix is singular: no mass resists an acceleration of " + mechanism.coordinates[coordinate].name +
              "; " + light_bodies(mechanism, mechanism.coordinates[coordinate].joint),
          {}};
}

template MotionOutcome check_masses(const Mechanism&, LoopDynamics<Planar>&, double, const double*);
template MotionOutcome check_masses(const Mechanism&, LoopDynamics<Spatial>&, double, const double*);

}  // namespace balance
