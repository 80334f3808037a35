#pragma once
/// Random configurations that a mechanism can take without being taken apart.

#include "balance/mechanics/kinematics/assembly.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace balance {

/// Numbers that are the same with every standard library.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : bits_(seed) {}
  double uniform(double lower, double upper);
  VectorX normal(Eigen::Index size);

 private:
  std::mt19937_64 bits_;
};

/// One configuration and the velocities that it allows.
struct SampledConfiguration {
  VectorX y;
  MatrixX null_space;  ///< columns × freedoms, orthonormal, of the scaled closures' Jacobian
};

/// The configuration nearest to y that closes the loops; its basis of velocities is any orthonormal one.
/// @return false if there is none
template <class S>
bool project_onto_closures(ConstraintSystem<S>& closures, const VectorX& y, int freedoms, SampledConfiguration& here);
extern template bool project_onto_closures(ConstraintSystem<Planar>&, const VectorX&, int, SampledConfiguration&);
extern template bool project_onto_closures(ConstraintSystem<Spatial>&, const VectorX&, int, SampledConfiguration&);

/// Wanders through the configurations that are connected to the one the mechanism is assembled in: a parallelogram that can
/// fold into an antiparallelogram must not be asked to balance as both. Open chains need no wandering.
template <class S>
class ConfigurationSampler {
 public:
  /// @param tree may get new reference orientations of floating spherical joints
  ConfigurationSampler(const Mechanism& mechanism, Tree<S>& tree, std::uint64_t seed);

  /// Configurations far enough from each other and from singular ones.
  /// @return false if the loops cannot be closed or the mechanism cannot move
  bool next(SampledConfiguration& configuration);

  int freedoms() const { return freedoms_; }
  /// Why there is no configuration, where there has been none.
  std::string infeasibility_reason();

 private:
  bool find_start();
  double take_step();
  void evaluate_regularity(const VectorX& y);
  void perturb_direction(double amount);
  bool is_out_of_range(const VectorX& y) const;

  const Mechanism& mechanism_;
  Tree<S>& tree_;
  ConstraintSystem<S> closures_;
  VectorX scale_;
  UniformRandom random_;
  bool started_ = false;
  int rank_ = 0, freedoms_ = 0;
  VectorX y_, direction_;  ///< direction: scaled, a unit vector of the null space
  MatrixX null_space_;
  SampledConfiguration current_;        ///< last looked at
  double min_singular_value_ = 0;       ///< smallest singular value of the loops there
  double accepted_singular_value_ = 0;  ///< at y
  double max_singular_value_ = 0;       ///< largest met so far
  double step_factor_ = 1;  ///< steps longer than a small margin alone would allow: it has hardly changed for a while
};

extern template class ConfigurationSampler<Planar>;
extern template class ConfigurationSampler<Spatial>;

}  // namespace balance
