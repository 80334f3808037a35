#pragma once
/// A second matrix that must stay regular along a motion, beside the one that determines it. Private to motion and dynamics.

#include "balance/motion/equations.hpp"

namespace balance {

template <class S>
class Guard {
 public:
  virtual ~Guard() = default;

  /// Factorises the matrix at the configuration that the equations are filled at.
  /// @return its smallest pivot, 0 if it is singular
  virtual double look(const Equations<S>& equations) = 0;
  /// Remembers the matrix last looked at.
  virtual void keep() = 0;
  /// Whether every matrix on the straight way from the one kept to the one last looked at is regular; see Equations::near_kept.
  virtual bool near_kept(double limit) = 0;
};

}  // namespace balance
