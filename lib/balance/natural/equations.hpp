#pragma once
/// Constraints and prescribed quantities as one system, solved by Newton's method with dense factorisations. Private to natural.

#include "balance/base/factorizations.hpp"
#include "balance/model/drive_sample.hpp"
#include "balance/natural/drive.hpp"

namespace balance::natural {

class Equations {
 public:
  Equations(const Model& model, DriveRows drive);

  int unknowns() const { return model_.unknowns(); }
  int constraints() const { return static_cast<int>(model_.constraints.size()); }
  int driven() const { return static_cast<int>(drive_.rows.size()); }
  int rows() const { return constraints() + driven(); }

  /// Left-hand sides less prescribed values [SI, one per driven row].
  VectorX residual(const Coordinates& position, const VectorX& prescribed) const;
  MatrixX jacobian(const Coordinates& position) const;
  MatrixX constraint_jacobian(const Coordinates& position) const;
  /// What the driven rows measure [SI].
  VectorX measure(const Coordinates& position) const;
  VectorX measure_rate(const State& state) const;

  /// Newton with as many rows as unknowns (LU) or more, consistent ones (least squares). The last correction follows a residual
  /// that is small already.
  /// @return false if it does not converge
  bool newton(Coordinates& position, const VectorX& prescribed);
  /// The same with corrections of least norm and any number of rows: for starts.
  bool approach(Coordinates& position, const VectorX& prescribed) const;
  /// Velocities and accelerations from the matrix at the state's position, which this factorises.
  bool differentiate(State& state, const DriveSample& sample);
  /// Accelerations anew, with the factorisation at hand.
  void accelerate(State& state, const DriveSample& sample) const;

  /// Velocities per unit rate of the driven rows: spans what the constraints allow. Of the matrix last factorised.
  MatrixX motions() const;
  int iterations() const { return iterations_; }

 private:
  bool factorise(const Coordinates& position);
  VectorX solve(const VectorX& right) const;

  const Model& model_;
  DriveRows drive_;
  bool square_;
  Eigen::PartialPivLU<MatrixX> lu_;
  ColumnPivotingQr qr_;
  int iterations_ = 0;
  double round_off_;
};

/// Constraints that are independent, at the most generic of a few configurations around one that meets them.
int generic_rank(const Model& model, const Coordinates& position);

}  // namespace balance::natural
