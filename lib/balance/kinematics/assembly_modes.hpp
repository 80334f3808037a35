#pragma once
/// The ways to assemble a mechanism at a pose: what the same equations have for solutions, looked for from random starts that are the
/// same every time.

#include "balance/kinematics/assembly.hpp"
#include "balance/model/mechanism.hpp"

#include <string>
#include <vector>

namespace balance {

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

}  // namespace balance
