#pragma once
/// The total linear momentum as Σ C_P Ṗ over the basic points, and the conditions for it to vanish in every motion.

#include "balance/synthesis/verification/natural_model.hpp"

#include <string>
#include <vector>

namespace balance::verification::natural {

/// C_P: sum over the bodies at P of the columns of their mass matrices, as a complex number for [Re −Im; Im Re].
/// Source: P3 eq. 37–46 as corrected.
struct PointCoefficient {
  std::string point;  ///< "crank1.B"; "crank1.(2)" is an auxiliary point
  bool fixed = false;
  Complex coefficient;  ///< [kg]
};

std::vector<PointCoefficient> point_coefficients(const Mechanism& mechanism);

/// R π = 0 for the parameters m, mx, my, J (SI) of all bodies but the ground, all attachments and all discs, in this
/// order: the same π as in derive_conditions. Necessary and sufficient for force balance.
struct ForceConditions {
  bool is_valid = false;
  std::string reason;               ///< one sentence if not valid
  MatrixX matrix;                   ///< rows × parameters, orthonormal in the mechanism's natural units
  int points = 0;                   ///< number of moving points and rims of discs
  int relations = 0;                ///< number of linear relations between their velocities that the joints impose
  int special_relations = 0;        ///< further ones due to special lengths: a parallelogram's coupler does not rotate
  double singular_value_ratio = 0;  ///< ratio of the two singular values that decide about hidden relations
};

/// @param start a configuration of the intended motion
/// @throws std::invalid_argument if the mechanism is spatial or the start has the wrong size
ForceConditions force_conditions(const Mechanism& mechanism, const InitialCoordinates& start);

/// Rows A with A ġ = 0 in every motion, for the velocities ġ of the moving points and then of the discs' rims. They
/// follow from bodies with more than two points, directions that stay together and slides that move together.
Eigen::MatrixXcd velocity_relations(const Mechanism& mechanism, const NaturalModel& model);

}  // namespace balance::verification::natural
