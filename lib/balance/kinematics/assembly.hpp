#pragma once
/// Finding configurations: Levenberg–Marquardt from a guess, restarts from seeded random ones, continuation along a straight
/// way, ranks by singular values. Private to kinematics, motion and dynamics.

#include "balance/kinematics/system.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace balance {

/// Largest scaled residual that counts as closed.
inline constexpr double closure_tolerance = 1e-12;

struct AssemblySolution {
  bool found = false;
  VectorX y;
  double residual = 0;  ///< largest scaled residual left
  int iterations = 0;
};

/// Lengths are solved for in units of the characteristic length: the SI value of every coordinate's unit.
template <class S>
VectorX column_scale(const Tree<S>& tree);

/// The configuration nearest in spirit to the guess that meets all equations (least-squares sense until it does).
template <class S>
AssemblySolution solve_assembly(ConstraintSystem<S>& system, const VectorX& guess, const DriveSample& target,
                                int iterations = 100);

/// Random coordinates: angles anywhere, lengths within ± the characteristic length.
template <class S>
VectorX random_coordinates(const Tree<S>& tree, std::uint64_t seed);

/// Numerical rank and the orthonormal null space of a scaled Jacobian.
struct RankDecomposition {
  int rank = 0;
  MatrixX null_space;  ///< columns × (columns − rank)
};
RankDecomposition decompose_rank(const MatrixX& jacobian, double tolerance = 1e-8);

/// Rank of all closures alone, those of rates included, at the most generic of a few configurations around y: a start pose may be singular
/// by accident. Of large mechanisms the smallest singular value proves that the rank is full; where it is not, they cost as much as a dense
/// matrix.
template <class S>
int find_generic_closure_rank(const Tree<S>& tree, const VectorX& y);

/// The same of the closures that bind places: the columns less these are the freedoms of the configuration.
template <class S>
int find_generic_position_rank(const Tree<S>& tree, const VectorX& y);

/// Follows the target from `from` (met by y) to `to` in small steps. Scalars go straight, rotations by the shortest way.
/// @return the configuration at `to`, or found = false
template <class S>
AssemblySolution track_to(ConstraintSystem<S>& system, const VectorX& y, const DriveSample& from,
                          const DriveSample& to);

#define BALANCE_DECLARE(S)                                                                                           \
  extern template VectorX column_scale<S>(const Tree<S>&);                                                           \
  extern template AssemblySolution solve_assembly<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&, int); \
  extern template VectorX random_coordinates<S>(const Tree<S>&, std::uint64_t);                                      \
  extern template int find_generic_closure_rank<S>(const Tree<S>&, const VectorX&);                                  \
  extern template int find_generic_position_rank<S>(const Tree<S>&, const VectorX&);                                 \
  extern template AssemblySolution track_to<S>(ConstraintSystem<S>&, const VectorX&, const DriveSample&,             \
                                               const DriveSample&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

}  // namespace balance
