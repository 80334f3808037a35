#pragma once
/// Random configurations that a mechanism can take without being taken apart. Private to conditions.

#include "balance/kinematics/assembly.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace balance {

/// Numbers that are the same with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double lower, double upper);
  VectorX normal(Eigen::Index size);

 private:
  std::mt19937_64 bits_;
};

/// One configuration and the velocities that it allows.
struct Configuration {
  VectorX y;
  MatrixX null_space;  ///< columns × freedoms, orthonormal, of the scaled closures' Jacobian
};

/// The configuration nearest to y that closes the loops; its basis of velocities is any orthonormal one.
/// @return false if there is none
template <class S>
bool settle(System<S>& closures, const VectorX& y, int freedoms, Configuration& here);
extern template bool settle(System<Planar>&, const VectorX&, int, Configuration&);
extern template bool settle(System<Spatial>&, const VectorX&, int, Configuration&);

/// Wanders through the configurations that are connected to the one the mechanism is assembled in: a parallelogram that can
/// fold into an antiparallelogram must not be asked to balance as both. Open chains need no wandering.
template <class S>
class Sampler {
 public:
  /// @param tree may get new reference orientations of floating spherical joints
  Sampler(const Mechanism& mechanism, Tree<S>& tree, std::uint64_t seed);

  /// Configurations far enough from each other and from singular ones.
  /// @return false if the loops cannot be closed or the mechanism cannot move
  bool next(Configuration& configuration);

  int freedoms() const { return freedoms_; }
  /// Why there is no configuration, where there has been none.
  std::string obstacle();

 private:
  bool start();
  double step();
  void look(const VectorX& y);
  void turn(double amount);
  bool out_of_range(const VectorX& y) const;

  const Mechanism& mechanism_;
  Tree<S>& tree_;
  System<S> closures_;
  VectorX scale_;
  Random random_;
  bool started_ = false;
  int rank_ = 0, freedoms_ = 0;
  VectorX y_, direction_;  ///< direction: scaled, a unit vector of the null space
  MatrixX null_space_;
  Configuration seen_;  ///< last looked at
  double margin_ = 0;   ///< smallest singular value of the loops there
  double room_ = 0;     ///< at y
  double widest_ = 0;   ///< largest met so far
  double pace_ = 1;     ///< steps longer than a small margin alone would allow: it has hardly changed for a while
};

extern template class Sampler<Planar>;
extern template class Sampler<Spatial>;

}  // namespace balance
