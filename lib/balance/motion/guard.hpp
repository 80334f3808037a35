#pragma once
/// A second matrix that must stay regular along a motion, beside the one that determines it. Private to motion and dynamics.

#include "balance/motion/equations.hpp"

#include <cstddef>

namespace balance {

template <class S>
class RegularityMonitor {
 public:
  virtual ~RegularityMonitor() = default;

  /// Factorises the matrix at the configuration that the equations are filled at.
  /// @return its smallest pivot, 0 if it is singular
  virtual double factorise(const KinematicEquations<S>& equations) = 0;
  /// Remembers the matrix last looked at.
  virtual void store() = 0;
  /// Whether every matrix on the straight way from the one kept to the one last looked at is regular; see Equations::near_kept.
  virtual bool is_near_stored(double limit) = 0;

  /// The mobility that the motion would have if the guard's quantities drove it: the smallest singular value of the closures and their
  /// rows. Remembers nothing. Equations: as above.
  virtual double mobility(const KinematicEquations<S>& equations) const = 0;
  /// How many of these quantities could be left out one at a time; 0 if none can.
  virtual std::size_t redundant_count() const = 0;
  /// Singular values, largest first, of that matrix without one of the quantities: as many as columns where that has enough rows.
  virtual VectorX singular_values_without(std::size_t quantity, const KinematicEquations<S>& equations) const = 0;
};

}  // namespace balance
