#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/plan.hpp"

#include "balance/base/rotation.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

/// First guess of y from the assembly values of tree coordinates.
template <class S>
VectorX make_initial_guess(const Mechanism& mechanism, const Tree<S>& tree) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& rough : mechanism.assembly) {
    const LinearQuantity& source = tree.coordinate_expressions[rough.coordinate];
    if (!source.has_single_term() || source.terms[0].second == 0) continue;  // a sum says nothing of its parts
    y[source.terms[0].first] = (rough.value - source.constant) / source.terms[0].second;
  }
  return y;
}

}  // namespace

template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  if (mechanism.assembly.empty()) return 0;
  TreeState<S> state(tree.nodes.size());
  compute_poses(tree, y.data(), state);
  double sum = 0;
  for (const CoordinateValue& rough : mechanism.assembly) {
    const Coordinate& coordinate = mechanism.coordinates[rough.coordinate];
    const LinearQuantity& source = tree.coordinate_expressions[rough.coordinate];
    double value;
    if (source.has_terms() && !tree.is_floating[rough.coordinate]) {
      value = source.value(y.data());
    } else {
      const Joint& joint = mechanism.joints[coordinate.joint];
      value = compute_joint_motion(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    }
    const double off = coordinate.kind == CoordinateKind::angle ? rough.value - unwrap_angle(value, rough.value)
                                                                : (rough.value - value) / tree.characteristic_length;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(mechanism.assembly.size()));
}

template <class S>
AssemblySolution solve_pose(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                            const DriveSample& target) {
  // At the assembly values the first solution is the one; near them a few tries tell whether there is a nearer one, since one joint's
  // other mode need not be far on the mean of many; elsewhere the nearest of many is taken.
  constexpr double accepted_distance = 0.1, near_distance = 0.4;
  constexpr std::uint64_t min_restarts = 20, max_restarts = 200;
  const VectorX guess = make_initial_guess(mechanism, tree);
  AssemblySolution best = solve_assembly(system, guess, target);
  double distance = best.found ? distance_from_assembly(mechanism, tree, best.y) : INFINITY;
  for (std::uint64_t seed = 1;
       seed <= (distance > near_distance ? max_restarts : min_restarts) && distance > accepted_distance; ++seed) {
    const VectorX random = random_coordinates(tree, seed);
    // the first restarts stay near the guess, later ones go anywhere
    const double spread = seed <= 60 ? 0.1 + 0.01 * static_cast<double>(seed) : 1;
    const AssemblySolution trial =
        solve_assembly(system, spread < 1 ? VectorX(guess + spread * random) : random, target);
    if (!trial.found) {
      if (!best.found && trial.residual < best.residual) best = trial;
      continue;
    }
    const double off = distance_from_assembly(mechanism, tree, trial.y);
    if (!best.found || off < distance) best = trial, distance = off;
  }
  return best;
}

#define BALANCE_INSTANTIATE(S)                                                                 \
  template double distance_from_assembly<S>(const Mechanism&, const Tree<S>&, const VectorX&); \
  template AssemblySolution solve_pose<S>(const Mechanism&, const Tree<S>&, ConstraintSystem<S>&, const DriveSample&);

BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
