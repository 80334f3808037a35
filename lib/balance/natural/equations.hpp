#pragma once
/// Constraints and prescribed quantities as one system, solved by Newton's method with dense factorisations. Private to natural.

#include "balance/base/factorizations.hpp"
#include "balance/model/drive_sample.hpp"
#include "balance/natural/drive.hpp"

namespace balance::natural {

class NaturalKinematicEquations {
 public:
  NaturalKinematicEquations(const NaturalModel& model, DriveRows drive);

  int unknown_count() const { return model_.unknowns(); }
  int constraint_count() const { return static_cast<int>(model_.constraints.size()); }
  int drive_row_count() const { return static_cast<int>(drive_.rows.size()); }
  int rows() const { return constraint_count() + drive_row_count(); }

  /// Left-hand sides less prescribed values [SI, one per driven row].
  VectorX residual(const NaturalCoordinates& position, const VectorX& prescribed) const;
  MatrixX jacobian(const NaturalCoordinates& position) const;
  MatrixX constraint_jacobian(const NaturalCoordinates& position) const;
  /// What the driven rows measure [SI].
  VectorX measure(const NaturalCoordinates& position) const;
  VectorX measure_rate(const NaturalState& state) const;

  /// Newton with as many rows as unknowns (LU) or more, consistent ones (least squares). The last correction follows a residual
  /// that is small already.
  /// @return false if it does not converge
  bool newton(NaturalCoordinates& position, const VectorX& prescribed);
  /// The same with corrections of least norm and any number of rows: for starts.
  bool solve_least_norm(NaturalCoordinates& position, const VectorX& prescribed) const;
  /// Velocities and accelerations from the matrix at the state's position, which this factorises.
  bool differentiate(NaturalState& state, const DriveSample& sample);
  /// Accelerations anew, with the factorisation at hand.
  void accelerate(NaturalState& state, const DriveSample& sample) const;

  /// Velocities per unit rate of the driven rows: spans what the constraints allow. Of the matrix last factorised.
  MatrixX allowed_velocities() const;
  int iterations() const { return iterations_; }

 private:
  bool factorise(const NaturalCoordinates& position);
  VectorX solve(const VectorX& right) const;

  const NaturalModel& model_;
  DriveRows drive_;
  bool square_;
  Eigen::PartialPivLU<MatrixX> lu_;
  ColumnPivotingQr qr_;
  int iterations_ = 0;
  double round_off_;
};

/// Constraints that are independent, at the most generic of a few configurations around one that meets them.
int find_generic_constraint_rank(const NaturalModel& model, const NaturalCoordinates& position);

}  // namespace balance::natural
