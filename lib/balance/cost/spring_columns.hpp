#pragma once
/// What springs ask of the tree's coordinates, per unit of their parameters (conditions/parameter.hpp lists these). Private to
/// study.

#include "balance/dynamics/external.hpp"
#include "balance/dynamics/parameter.hpp"

#include <vector>

namespace balance {

template <class S>
class SpringRegressor {
 public:
  SpringRegressor(const Mechanism& mechanism, const Tree<S>& tree, const FreeSprings& loose);

  /// Parameters of all springs.
  Eigen::Index count() const { return count_; }

  /// @param state poses in the world @param y tree coordinates
  /// @param torque tree coordinates × count [N m or N per unit]
  void evaluate(const TreeState<S>& state, const double* y, Eigen::Ref<MatrixX> torque);

 private:
  /// A spring of stiffness 1, at rest or between unit points.
  using UnitSpring = ExternalForces<S>;

  /// How a spring's parameters are counted.
  enum class SpringKind { fixed, loose, in_joint };

  void add(const Spring& spring);
  VectorX torque_of(const UnitSpring& spring, const TreeState<S>& state);
  void loose_at(std::size_t first, const TreeState<S>& state, Eigen::Ref<MatrixX> torque);

  const Tree<S>& tree_;
  const Mechanism& mechanism_;
  std::vector<UnitSpring> units_;
  std::vector<SpringKind> forms_;  ///< per spring
  Eigen::Index count_ = 0;
  std::vector<Wrench<S>> wrenches_;
};

extern template class SpringRegressor<Planar>;
extern template class SpringRegressor<Spatial>;

}  // namespace balance
