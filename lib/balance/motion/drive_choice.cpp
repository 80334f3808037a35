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
DriveChoice<S> make_drive_choice(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                                 int freedoms) {
  DriveChoice<S> choice;
  choice.quantities = choose_drive_quantities(mechanism, trajectory, freedoms);
  choice.drive = make_drive(mechanism, tree, choice.quantities);
  return choice;
}

/// Rates of the drive's quantities per unit of each velocity that the loops allow.
MatrixX compute_reduced_drive_jacobian(const Tree<Spatial>& tree, const Drive<Spatial>& drive, const VectorX& y,
                                       const MatrixX& null_space) {
  ConstraintSystem<Spatial> system(tree, drive);
  DriveSample here;
  here.value.setZero(drive.value_count());
  VectorX residual;
  MatrixX jacobian;
  system.evaluate(y, here, residual, jacobian);  // measure() speaks of the configuration last evaluated
  system.evaluate(y, system.measure(y), residual, jacobian);
  return jacobian.bottomRows(drive.row_count()) * null_space;
}

bool has_independent_rows(const MatrixX& rates) {
  constexpr double min_independent_rate = 1e-6;  // in characteristic lengths or radians per unit of all coordinates
  if (rates.rows() == 0 || rates.rows() > rates.cols()) return rates.rows() == 0;
  return singular_values(rates)[rates.rows() - 1] > min_independent_rate;
}

/// The first components, positions before rotations, that tool or centre of mass can follow at once beside the coordinates that remain.
/// @return as many as `asked`; empty if there are not so many
std::vector<Component> select_drivable_components(const Mechanism& mechanism, const Tree<Spatial>& tree,
                                                  Trajectory trajectory, const VectorX& y, const MatrixX& null_space,
                                                  int asked) {
  std::vector<Component> chosen;
  for (const Component component :
       {Component::x, Component::y, Component::z, Component::rx, Component::ry, Component::rz}) {
    if (static_cast<int>(chosen.size()) == asked || (component > Component::z && !mechanism.tool)) break;
    chosen.push_back(component);
    trajectory.components = chosen;
    const Drive<Spatial> drive = make_drive_choice(mechanism, tree, trajectory, 0).drive;
    if (!has_independent_rows(compute_reduced_drive_jacobian(tree, drive, y, null_space))) chosen.pop_back();
  }
  if (static_cast<int>(chosen.size()) < asked) chosen.clear();
  return chosen;
}

/// The default components of a tool or a centre of mass in space are its position; where that cannot move in one of them, as in a planar
/// linkage that is written in space, others are taken.
Trajectory complete_components(const Mechanism& mechanism, const Tree<Spatial>& tree, Trajectory trajectory,
                               const VectorX& y, int freedoms) {
  if (trajectory.drive == DriveKind::joints || !trajectory.components.empty() ||
      std::holds_alternative<TablePath>(trajectory.path))  // a table has columns for the usual ones
    return trajectory;
  const DriveChoice<Spatial> usual = make_drive_choice(mechanism, tree, trajectory, freedoms);
  if (!usual.quantities.mismatch.empty()) return trajectory;
  ConstraintSystem<Spatial> closures(tree, Drive<Spatial>{});
  const VectorX scale = column_scale(tree);
  const int asked = freedoms - count_remaining_quantities(trajectory);
  std::vector<Component> others;
  VectorX here = y;
  MatrixX jacobian;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    closures.velocity_jacobian(here, {}, jacobian);
    const RankDecomposition loops = decompose_rank(jacobian);
    if (loops.null_space.cols() == freedoms) {  // elsewhere it says more than the motion can do
      if (has_independent_rows(compute_reduced_drive_jacobian(tree, usual.drive, here, loops.null_space)))
        return trajectory;
      const auto found = select_drivable_components(mechanism, tree, trajectory, here, loops.null_space, asked);
      if (others.empty()) others = found;
    }
    const VectorX random = random_coordinates(tree, seed).cwiseQuotient(scale);
    const VectorX aside = loops.null_space * (loops.null_space.transpose() * random);
    const AssemblySolution moved =
        solve_assembly(closures, here + scale.cwiseProduct(0.2 / std::max(1e-12, aside.norm()) * aside), {});
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
    return make_drive_choice(mechanism, tree, complete_components(mechanism, tree, trajectory, y, freedoms), freedoms);
  else
    return make_drive_choice(mechanism, tree, trajectory, freedoms);
}

template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&,
                                                  const VectorX&, int);
template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                    const VectorX&, int);

}  // namespace balance
