#pragma once
/// Configurations that the constraints allow, connected to a first one without passing a singular one. Private to natural.

#include "balance/natural/equations.hpp"

#include <random>

namespace balance::natural {

class RandomWalk {
 public:
  /// @param model must outlive the walk
  explicit RandomWalk(const NaturalModel& model);

  /// Into a configuration that meets the constraints, near the model's start.
  bool begin();
  /// On to another one, far enough from the last.
  bool next();

  const NaturalCoordinates& position() const { return position_; }
  /// Velocities that the constraints allow there: unknowns × freedoms, orthonormal.
  const MatrixX& motions() const { return motions_; }

 private:
  bool compute_motions(const NaturalCoordinates& position, MatrixX& motions, double& margin) const;
  double step();
  void perturb_direction(double amount);
  VectorX random_direction();

  const NaturalModel& model_;
  NaturalKinematicEquations constraints_;
  std::mt19937_64 random_{1};
  int rank_ = 0;
  NaturalCoordinates position_;
  MatrixX motions_;
  VectorX direction_;
  double margin_ = 0, max_margin_ = 0;
};

}  // namespace balance::natural
