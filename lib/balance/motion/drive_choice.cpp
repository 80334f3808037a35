#include "balance/motion/drive_choice.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/motion/plan.hpp"

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <variant>

namespace balance {

namespace {

template <class S>
DriveChoice<S> drive_of(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory, int freedoms) {
  DriveChoice<S> choice;
  choice.quantities = choose_quantities(mechanism, trajectory, freedoms);
  choice.drive = drive_rows(mechanism, tree, choice.quantities);
  return choice;
}

/// Rates of the drive's quantities per unit of each velocity that the loops allow.
MatrixX allowed_rates(const Tree<Spatial>& tree, const Drive<Spatial>& drive, const VectorX& y,
                      const MatrixX& null_space) {
  System<Spatial> system(tree, drive);
  DriveSample here;
  here.value.setZero(drive.values());
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(y, here, residual, jacobian);  // measure() speaks of the configuration last evaluated
  system.evaluate(y, system.measure(y), residual, jacobian);
  return jacobian.bottomRows(drive.rows()) * null_space;
}

bool independent(const MatrixX& rates) {
  constexpr double least = 1e-6;  // in characteristic lengths or radians per unit of all coordinates
  if (rates.rows() == 0 || rates.rows() > rates.cols()) return rates.rows() == 0;
  return singular_values(rates)[rates.rows() - 1] > least;
}

/// The first components, positions before rotations, that tool or centre of mass can follow at once beside the coordinates that remain.
/// @return as many as `asked`; empty if there are not so many
std::vector<Component> followed(const Mechanism& mechanism, const Tree<Spatial>& tree, Trajectory trajectory,
                                const VectorX& y, const MatrixX& null_space, int asked) {
  std::vector<Component> chosen;
  for (const Component component :
       {Component::x, Component::y, Component::z, Component::rx, Component::ry, Component::rz}) {
    if (static_cast<int>(chosen.size()) == asked || (component > Component::z && !mechanism.tool)) break;
    chosen.push_back(component);
    trajectory.components = chosen;
    const Drive<Spatial> drive = drive_of(mechanism, tree, trajectory, 0).drive;
    if (!independent(allowed_rates(tree, drive, y, null_space))) chosen.pop_back();
  }
  if (static_cast<int>(chosen.size()) < asked) chosen.clear();
  return chosen;
}

/// The default components of a tool or a centre of mass in space are its position; where that cannot move in one of them, as in a planar
/// linkage that is written in space, others are taken.
Trajectory with_components(const Mechanism& mechanism, const Tree<Spatial>& tree, Trajectory trajectory,
                           const VectorX& y, int freedoms) {
  if (trajectory.drive == DriveKind::joints || !trajectory.components.empty() ||
      std::holds_alternative<TablePath>(trajectory.path))  // a table has columns for the usual ones
    return trajectory;
  const DriveChoice<Spatial> usual = drive_of(mechanism, tree, trajectory, freedoms);
  if (!usual.quantities.mismatch.empty()) return trajectory;
  System<Spatial> closures(tree, Drive<Spatial>{});
  const VectorX scale = column_scale(tree);
  const int asked = freedoms - remaining_values(trajectory);
  std::vector<Component> others;
  VectorX here = y;
  MatrixX jacobian;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    closures.rates(here, {}, jacobian);
    const RankReport loops = rank_of(jacobian);
    if (loops.null_space.cols() == freedoms) {  // elsewhere it says more than the motion can do
      if (independent(allowed_rates(tree, usual.drive, here, loops.null_space))) return trajectory;
      const auto found = followed(mechanism, tree, trajectory, here, loops.null_space, asked);
      if (others.empty()) others = found;
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX aside = loops.null_space * (loops.null_space.transpose() * random);
    const Solution moved = solve(closures, here + scale.cwiseProduct(0.2 / std::max(1e-12, aside.norm()) * aside), {});
    if (moved.found) here = moved.y;
  }
  trajectory.components = others;
  return trajectory;
}

}  // namespace

template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            const VectorX& y, int freedoms) {
  if constexpr (std::is_same_v<S, Spatial>)
    return drive_of(mechanism, tree, with_components(mechanism, tree, trajectory, y, freedoms), freedoms);
  else
    return drive_of(mechanism, tree, trajectory, freedoms);
}

template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&,
                                                  const VectorX&, int);
template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                    const VectorX&, int);

}  // namespace balance
