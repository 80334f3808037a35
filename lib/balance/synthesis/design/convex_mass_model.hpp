#pragma once
/// The numbers of masses as unknowns of a convex problem, once lengths are chosen.
///
/// Numbers in which everything that matters is affine are unknowns themselves. The place of an element's CoM is one more
/// product with its mass: instead of it the first moment h is an unknown, within the cone over all places, and what it adds to
/// the moment of inertia, at least |h|²/m. All other numbers are outer ones: lengths, motions, angles that turn more than one
/// element.

#include "balance/foundation/numerics/cone_program.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// The terms (list_terms) and what is demanded of the unknowns, at one geometry.
struct AffineTerms {
  MatrixX matrix;           ///< terms × unknowns
  VectorX constant;         ///< terms = constant + matrix · unknowns
  ConeProgram constraints;  ///< of the unknowns; no cost
};

class ConvexMassModel {
 public:
  /// @param anchor unit coordinates of a mechanism that exists
  /// @param matters per term (list_terms): it occurs in a condition or figure
  ConvexMassModel(const SolverContext& context, const VectorX& anchor, const std::vector<bool>& matters);

  /// Positions of the numbers that are no unknowns and change something.
  const std::vector<int>& outer() const { return outer_; }
  /// Positions of the numbers that are unknowns themselves, the first of all unknowns.
  const std::vector<int>& linear() const { return linear_; }
  /// Unknowns of elements that have no mass where the linear numbers are not above `upper` [SI]: none of them is anything but zero.
  std::vector<Eigen::Index> list_massless_unknowns(const AffineTerms& terms, const VectorX& upper) const;
  Eigen::Index unknown_count() const { return unknowns_; }
  /// @return nothing where there is no mechanism
  std::optional<AffineTerms> evaluate(const VectorX& u) const;
  /// All numbers: the outer ones as in u, the others as the unknowns say.
  VectorX recover_variables(const VectorX& u, const VectorX& unknowns) const;

 private:
  /// An element whose first moment is unknown.
  struct FirstMomentLift {
    std::vector<int> numbers;
    int first = 0;             ///< its mass among the terms, the first moment behind it
    int inertia = -1;          ///< feature of the planar moment of inertia about the CoM, if that matters
    int unknown = 0;           ///< first of its unknowns
    double radius = 0;         ///< |c| is not larger
    double mass = 0;           ///< a size
    MatrixX directions;        ///< K × dimension
    VectorX support;           ///< direction · c is not larger
    MatrixX com_samples;       ///< dimension × samples: c
    MatrixX variable_samples;  ///< numbers × samples
  };
  VectorX features(const VectorX& u) const;
  void classify_variables(const VectorX& anchor, const std::vector<bool>& matters);
  void move_nonlinear_out(std::vector<int>& inner, const std::vector<bool>& matters);
  bool is_nonlinear(int i, int j, const VectorX& base, const std::vector<bool>& matters) const;
  std::optional<FirstMomentLift> find_lift(int number, const std::vector<bool>& matters) const;
  bool sample_com_positions(FirstMomentLift& lift, const VectorX& anchor) const;
  VectorX com_position(const FirstMomentLift& lift, const VectorX& u) const;
  void add_lift_cones(const FirstMomentLift& lift, const AffineTerms& terms, const VectorX& at_zero,
                      const MatrixX& slopes, ConeProgramBuilder& rows) const;
  void write_lift_rows(const FirstMomentLift& lift, const VectorX& at_zero, const MatrixX& slopes,
                       AffineTerms& terms) const;

  const SolverContext& context_;
  int dimension_;
  Eigen::Index terms_ = 0, unknowns_ = 0;
  std::vector<int> outer_, linear_;
  std::vector<FirstMomentLift> lifts_;
};

}  // namespace balance::design
