#pragma once
/// Random configurations that a mechanism can reach without being disassembled.

#include "balance/foundation/numerics/random.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace balance::conditions {

/// A configuration and its admissible velocities.
struct SampledConfiguration {
  VectorX y;
  MatrixX null_space;  ///< columns × freedoms, orthonormal: null space of the scaled closures' Jacobian
};

/// Finds the configuration nearest to y that closes the loops, with an arbitrary orthonormal basis of its velocities.
/// @return false if there is none
template <class S>
bool project_onto_closures(kinematics::ConstraintSystem<S>& closures, const VectorX& y, int freedoms,
                           SampledConfiguration& sample);
extern template bool project_onto_closures(kinematics::ConstraintSystem<kinematics::Planar>&, const VectorX&, int,
                                           SampledConfiguration&);
extern template bool project_onto_closures(kinematics::ConstraintSystem<kinematics::Spatial>&, const VectorX&, int,
                                           SampledConfiguration&);

/// Random walk through the configurations that are connected to the assembled one: a parallelogram that can fold into
/// an antiparallelogram must not be required to balance as both. Open chains need no walk.
template <class S>
class ConfigurationSampler {
 public:
  /// @param tree its floating spherical joints may get new reference orientations
  ConfigurationSampler(const Mechanism& mechanism, kinematics::Tree<S>& tree, std::uint64_t seed);

  /// Finds another configuration, sufficiently far from the last one and from singular ones.
  /// @return false if the loops cannot be closed or the mechanism cannot move
  bool next(SampledConfiguration& configuration);

  int freedoms() const { return freedoms_; }
  /// Why no configuration was found, if there was none.
  std::string infeasibility_reason();

 private:
  bool find_start();
  double take_step();
  void evaluate_regularity(const VectorX& y);
  void perturb_direction(double amount);
  bool is_out_of_range(const VectorX& y) const;

  const Mechanism& mechanism_;
  kinematics::Tree<S>& tree_;
  kinematics::ConstraintSystem<S> closures_;
  VectorX scale_;
  numerics::UniformRandom random_;
  bool started_ = false;
  int rank_ = 0, freedoms_ = 0;
  VectorX y_, direction_;  ///< direction_: scaled, a unit vector in the null space
  MatrixX null_space_;
  SampledConfiguration current_;        ///< last one evaluated
  double min_singular_value_ = 0;       ///< smallest nonzero singular value of the closures' Jacobian there
  double accepted_singular_value_ = 0;  ///< the same at y_
  double max_singular_value_ = 0;       ///< maximum so far
  double step_factor_ = 1;  ///< allows longer steps at small singular values that have hardly changed for a while
};

extern template class ConfigurationSampler<kinematics::Planar>;
extern template class ConfigurationSampler<kinematics::Spatial>;

}  // namespace balance::conditions
