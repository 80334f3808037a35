#pragma once
/// Finding configurations: Levenberg–Marquardt from a guess, restarts from seeded random ones, continuation along a straight
/// way, ranks by singular values.

#include "balance/mechanics/kinematics/constraint_system.hpp"
#include "balance/mechanics/kinematics/tree.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/trajectory/motion_outcome.hpp"
#include "balance/mechanics/trajectory/trajectory.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace balance {

/// The configuration that a pose means: every coordinate of a mechanism where its tool, some of its joints or its centre of mass are.
struct ConfigurationResult {
  MotionOutcome
      outcome;  ///< done; not_assembled, unreachable; drive_singularity, mismatch: the pose does not tell enough
  std::vector<CoordinateValue> coordinates;  ///< all of the mechanism, if done
};

/// In the assembly mode nearest to the mechanism's `assembly`.
/// @throws std::invalid_argument if the pose names a tool that the mechanism lacks
ConfigurationResult solve_configuration(const Mechanism& mechanism, const PoseTarget& pose);

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

/// The ways to assemble a mechanism at a pose: what the same equations have for solutions, looked for from random starts that are the
/// same every time.
template <class S>
class AssemblyModes {
 public:
  /// @param system of the pose; it and the other arguments must outlive the modes
  /// @param selected tree coordinates of the first mode
  AssemblyModes(const Mechanism& mechanism, const Tree<S>& tree, ConstraintSystem<S>& system, const DriveSample& target,
                const VectorX& selected);

  /// Looks from one more start. @return what it took: steps times coordinates
  long search_from(std::uint64_t start);

  /// Of each mode all coordinates of the mechanism; the selected one first.
  const std::vector<std::vector<double>>& modes() const { return modes_; }

 private:
  bool is_same_mode(const std::vector<double>& a, const std::vector<double>& b) const;

  const Mechanism& mechanism_;
  const Tree<S>& tree_;
  ConstraintSystem<S>& system_;
  const DriveSample& target_;
  std::vector<std::vector<double>> modes_;
};

/// "assembly: {B: -1.2}": the coordinates that tell modes apart, those of the tree that the pose does not state itself.
/// In the spec's units. @param drive of the pose
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

// Where a mechanism stands, in a few words for a message.

/// The first dozen coordinates of the tree: "A 0.5, B -1.2".
template <class S>
std::string format_configuration(const Mechanism& mechanism, const Tree<S>& tree, const double* y);

extern template std::string format_configuration<Planar>(const Mechanism&, const Tree<Planar>&, const double*);
extern template std::string format_configuration<Spatial>(const Mechanism&, const Tree<Spatial>&, const double*);

}  // namespace balance
