#pragma once
/// Finding configurations: Levenberg–Marquardt from a guess, restarts from seeded random guesses, continuation along a
/// straight line, ranks by singular values.

#include "balance/mechanics/kinematics/constraint_system.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace balance::kinematics {

/// The configuration defined by a pose: all coordinates of a mechanism, given those of its tool, of some joints or of
/// its centre of mass.
struct ConfigurationResult {
  MotionOutcome
      outcome;  ///< done; not_assembled, unreachable; drive_singularity, mismatch: the pose does not determine it
  std::vector<CoordinateValue> coordinates;  ///< all of the mechanism, if done
};

/// Finds the configuration in the assembly mode nearest to the mechanism's `assembly`.
ConfigurationResult solve_configuration(const Mechanism& mechanism, const trajectory::PoseTarget& pose);

/// The pose of a mechanism without a motion: its actuated coordinates at their assembly values, or zero.
trajectory::PoseTarget actuators_as_assembled(const Mechanism& mechanism);

/// Largest scaled residual that counts as closed.
inline constexpr double closure_tolerance = 1e-12;

struct AssemblySolution {
  bool found = false;
  VectorX y;
  double residual = 0;  ///< largest remaining scaled residual
  int iterations = 0;
};

/// SI values of the units in which the coordinates are solved for: the characteristic length for lengths, else 1.
template <class S>
VectorX column_scale(const Tree<S>& tree);

/// Finds a configuration near the guess that satisfies all equations. If there is none, minimises the residual in the
/// least-squares sense.
template <class S>
AssemblySolution solve_assembly(ConstraintSystem<S>& system, const VectorX& guess,
                                const trajectory::DriveSample& target, int iterations = 100);

/// Random coordinates: angles anywhere, lengths within ± the characteristic length.
template <class S>
VectorX random_coordinates(const Tree<S>& tree, std::uint64_t seed);

/// Numerical rank and the orthonormal null space of a scaled Jacobian.
struct RankDecomposition {
  int rank = 0;
  MatrixX null_space;  ///< columns × (columns − rank)
};
RankDecomposition decompose_rank(const MatrixX& jacobian, double tolerance = 1e-8);

/// Rank of all closures alone, velocity-level ones included: the maximum over a few configurations around y, because a
/// start pose may be singular by accident. For large mechanisms the smallest singular value proves that the rank is
/// full; if it does not, the cost is that of a dense matrix.
template <class S>
int find_generic_closure_rank(const Tree<S>& tree, const VectorX& y);

/// The same for the position-level closures. The number of columns minus this rank is the number of freedoms of the
/// configuration.
template <class S>
int find_generic_position_rank(const Tree<S>& tree, const VectorX& y);

/// Follows the target from `from` (met by y) to `to` in small steps. Scalars move linearly, rotations along the
/// shortest path.
/// @return the configuration at `to`, or found = false
template <class S>
AssemblySolution track_to(ConstraintSystem<S>& system, const VectorX& y, const trajectory::DriveSample& from,
                          const trajectory::DriveSample& to);

#define BALANCE_DECLARE(S)                                                                                           \
  extern template VectorX column_scale<S>(const Tree<S>&);                                                           \
  extern template AssemblySolution solve_assembly<S>(ConstraintSystem<S>&, const VectorX&,                           \
                                                     const trajectory::DriveSample&, int);                           \
  extern template VectorX random_coordinates<S>(const Tree<S>&, std::uint64_t);                                      \
  extern template int find_generic_closure_rank<S>(const Tree<S>&, const VectorX&);                                  \
  extern template int find_generic_position_rank<S>(const Tree<S>&, const VectorX&);                                 \
  extern template AssemblySolution track_to<S>(ConstraintSystem<S>&, const VectorX&, const trajectory::DriveSample&, \
                                               const trajectory::DriveSample&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

/// The assembly modes of a mechanism at a pose: the solutions of the pose's equations, searched from reproducible
/// random starts.
template <class S>
class AssemblyModes {
 public:
  /// @param system of the pose; it and the other arguments must outlive the modes
  /// @param selected tree coordinates of the first mode
  AssemblyModes(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system,
                const trajectory::DriveSample& target, const VectorX& selected);

  /// Searches from one more start. @return the cost: iterations times coordinates
  long search_from(std::uint64_t start);

  /// Per mode: all coordinates of the mechanism. The selected mode is the first.
  const std::vector<std::vector<double>>& modes() const { return modes_; }

 private:
  bool is_same_mode(const std::vector<double>& a, const std::vector<double>& b) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  ConstraintSystem<S>& system_;
  const trajectory::DriveSample& target_;
  std::vector<std::vector<double>> modes_;
};

/// "assembly: {B: -1.2}": the coordinates that distinguish modes, which are those of the tree that the pose does not
/// state itself. In the spec's units. @param drive of the pose
template <class S>
std::string format_assembly_line(const Mechanism& mechanism, const Tree<S>& tree, const Drive<S>& drive,
                                 const std::vector<double>& mode);

#define BALANCE_DECLARE(S)                                                                               \
  extern template class AssemblyModes<S>;                                                                \
  extern template std::string format_assembly_line<S>(const Mechanism&, const Tree<S>&, const Drive<S>&, \
                                                      const std::vector<double>&);
BALANCE_DECLARE(Planar)
BALANCE_DECLARE(Spatial)
#undef BALANCE_DECLARE

// Short descriptions of a configuration, for messages.

/// The first dozen coordinates of the tree: "A 0.5, B -1.2".
template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y);

extern template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
extern template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance::kinematics
