#pragma once
/// Which equations a trajectory's drive means on a mechanism with a given number of freedoms. Private to motion and dynamics.

#include "balance/kinematics/drive.hpp"
#include "balance/motion/trajectory.hpp"

#include <string>

namespace balance {

/// A drive with what its linear quantities stand for.
template <class S>
struct DriveChoice {
  Drive<S> drive;
  bool tool_angle = false;       ///< the first linear quantity is the planar tool's angle
  std::vector<int> coordinates;  ///< the joint coordinates among the linear quantities, in order
  std::string mismatch;          ///< why no drive fits; empty if one does
};

template <class S>
DriveChoice<S> choose_drive(const Mechanism& mechanism, const Tree<S>& tree, const Trajectory& trajectory,
                            int freedoms);

extern template DriveChoice<Planar> choose_drive<Planar>(const Mechanism&, const Tree<Planar>&, const Trajectory&, int);
extern template DriveChoice<Spatial> choose_drive<Spatial>(const Mechanism&, const Tree<Spatial>&, const Trajectory&,
                                                           int);

}  // namespace balance
