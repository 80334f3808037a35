#pragma once
/// Which equations a trajectory's drive means on a mechanism with a given number of freedoms. Private to motion and dynamics.

#include "balance/kinematics/assembly.hpp"
#include "balance/motion/drive_quantities.hpp"

namespace balance {

/// What is driven, and the equations that do it.
template <class S>
struct DriveChoice {
  Drive<S> drive;
  DriveQuantities quantities;
};

/// @param y closes the loops; of a spatial tool those components are taken that it can follow around there, if the trajectory names none
template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            const VectorX& y, int freedoms);

extern template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&,
                                                         const VectorX&, int);
extern template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                           const VectorX&, int);

}  // namespace balance
