#include "balance/kinematics/joint_coordinates.hpp"
#include "balance/motion/plan.hpp"

#include "balance/base/rotation.hpp"

#include <cmath>
#include <stdexcept>

namespace balance {

namespace {

/// First guess of y from the assembly values of tree coordinates.
template <class S>
VectorX assembly_guess(const Mechanism& mechanism, const Tree<S>& tree) {
  VectorX y = VectorX::Zero(tree.columns);
  for (const CoordinateValue& rough : mechanism.assembly) {
    const LinearQuantity& source = tree.sources[rough.coordinate];
    if (!source.depends_on_one() || source.terms[0].second == 0) continue;  // a sum says nothing of its parts
    y[source.terms[0].first] = (rough.value - source.constant) / source.terms[0].second;
  }
  return y;
}

}  // namespace

template <class S>
double distance_from_assembly(const Mechanism& mechanism, const Tree<S>& tree, const VectorX& y) {
  if (mechanism.assembly.empty()) return 0;
  State<S> state(tree.nodes.size());
  poses(tree, y.data(), state);
  double sum = 0;
  for (const CoordinateValue& rough : mechanism.assembly) {
    const Coordinate& coordinate = mechanism.coordinates[rough.coordinate];
    const LinearQuantity& source = tree.sources[rough.coordinate];
    double value;
    if (source.depends() && !tree.floats[rough.coordinate]) {
      value = source.value(y.data());
    } else {
      const Joint& joint = mechanism.joints[coordinate.joint];
      value = read_joint(joint, relative_motion(tree, state, joint)).position[coordinate.index];
    }
    const double off = coordinate.kind == CoordinateKind::angle ? rough.value - unwrapped(value, rough.value)
                                                                : (rough.value - value) / tree.length;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(mechanism.assembly.size()));
}

template <class S>
Solution find_pose(const Mechanism& mechanism, const Tree<S>& tree, System<S>& system, const DriveSample& target) {
  // At the assembly values the first solution is the one; near them a few tries tell whether there is a nearer one, since one joint's
  // other mode need not be far on the mean of many; elsewhere the nearest of many is taken.
  constexpr double at = 0.1, near = 0.4;
  constexpr std::uint64_t few = 20, many = 200;
  const VectorX guess = assembly_guess(mechanism, tree);
  Solution best = solve(system, guess, target);
  double distance = best.found ? distance_from_assembly(mechanism, tree, best.y) : INFINITY;
  for (std::uint64_t seed = 1; seed <= (distance > near ? many : few) && distance > at; ++seed) {
    const VectorX random = random_coordinates(tree, seed);
    // the first restarts stay near the guess, later ones go anywhere
    const double spread = seed <= 60 ? 0.1 + 0.01 * static_cast<double>(seed) : 1;
    const Solution trial = solve(system, spread < 1 ? VectorX(guess + spread * random) : random, target);
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
  template Solution find_pose<S>(const Mechanism&, const Tree<S>&, System<S>&, const DriveSample&);

BALANCE_INSTANTIATE(Planar)
BALANCE_INSTANTIATE(Spatial)
#undef BALANCE_INSTANTIATE

}  // namespace balance
