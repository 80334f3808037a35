#pragma once
/// The total linear momentum as Σ C_P Ṗ over the basic points, and the conditions for it to vanish in every motion.

#include "balance/synthesis/verification/natural_model.hpp"

#include <string>
#include <vector>

namespace balance::natural {

/// C_P = Σ over the bodies at P of their mass matrix's columns: a 2×2 matrix [Re −Im; Im Re], here as a complex number.
/// Source: P3 eq. 37–46 as corrected.
struct PointCoefficient {
  std::string point;  ///< "crank1.B"; "crank1.(2)": an auxiliary one
  bool fixed = false;
  Complex coefficient;  ///< [kg]
};

std::vector<PointCoefficient> point_coefficients(const Mechanism& mechanism);

/// R π = 0 for the parameters m, mx, my, J (SI) of all bodies but the ground, all attachments and all discs, in this order: the
/// same π as that of derive_conditions. Necessary and sufficient for a force-balanced mechanism.
struct ForceConditions {
  bool is_valid = false;
  std::string reason;               ///< one sentence if not done
  MatrixX matrix;                   ///< rows × parameters, orthonormal in the mechanism's own units
  int points = 0;                   ///< moving points and rims of discs
  int relations = 0;                ///< linear relations between their velocities that the joints impose
  int special_relations = 0;        ///< further ones, of special lengths: a parallelogram's coupler does not turn
  double singular_value_ratio = 0;  ///< between the singular values that decide about hidden relations
};

/// @param start a configuration of the motion that is meant
/// @throws std::invalid_argument if the mechanism is spatial or the start has the wrong size
ForceConditions force_conditions(const Mechanism& mechanism, const InitialCoordinates& start);

/// Rows A with A ġ = 0 in every motion, for the velocities ġ of the moving points and then of the discs' rims: what bodies with
/// more than two points, directions that stay together and slides that move together impose.
Eigen::MatrixXcd velocity_relations(const Mechanism& mechanism, const NaturalModel& model);

}  // namespace balance::natural
