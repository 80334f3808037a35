#pragma once
/// Mass properties as unknowns of a convex problem for given lengths.
///
/// Variables in which all relevant terms are affine are unknowns themselves. The position of an element's CoM is
/// multiplied by its mass. Therefore the first moment h is the unknown, restricted to the cone over all positions, and
/// so is its contribution to the moment of inertia, at least |h|²/m. All other variables are outer ones: lengths,
/// motions, angles that rotate more than one element.

#include "balance/foundation/numerics/cone_program.hpp"
#include "balance/synthesis/design/solver_context.hpp"

namespace balance::design {

/// The terms (list_terms) and the constraints on the unknowns at one geometry.
struct AffineTerms {
  MatrixX matrix;                     ///< terms × unknowns
  VectorX constant;                   ///< terms = constant + matrix · unknowns
  numerics::ConeProgram constraints;  ///< of the unknowns; no cost
};

class ConvexMassModel {
 public:
  /// @param anchor unit coordinates of a valid mechanism
  /// @param is_active_parameter for each term (list_terms), whether it occurs in a condition or figure
  ConvexMassModel(const SolverContext& context, const VectorX& anchor, const std::vector<bool>& is_active_parameter);

  /// Indices of the variables that are not unknowns but have an effect.
  const std::vector<int>& outer() const { return outer_; }
  /// Indices of the variables that are unknowns themselves; these come first among the unknowns.
  const std::vector<int>& linear() const { return linear_; }
  /// Unknowns of elements that have no mass as long as the linear variables do not exceed `upper` [SI]; these unknowns
  /// are zero.
  std::vector<Eigen::Index> list_massless_unknowns(const AffineTerms& terms, const VectorX& upper) const;
  Eigen::Index unknown_count() const { return unknowns_; }
  /// @return std::nullopt if there is no mechanism
  std::optional<AffineTerms> evaluate(const VectorX& u) const;
  /// All variables: the outer ones from u, the others from the unknowns.
  VectorX recover_variables(const VectorX& u, const VectorX& unknowns) const;

 private:
  /// An element, or the same one in another load case: with the same mass, place and inertia for all values of the
  /// variables.
  struct ElementCopy {
    int first = 0;     ///< index of its mass among the terms; the first moment follows
    int inertia = -1;  ///< feature of the moment of inertia about the CoM
  };
  /// An element whose first moment is an unknown.
  struct FirstMomentLift {
    std::vector<int> numbers;
    std::vector<ElementCopy> copies;  ///< at least one
    int first = 0;                    ///< index of its mass among the terms; the first moment follows
    int inertia = -1;                 ///< feature of the planar moment of inertia about the CoM, if relevant
    int unknown = 0;                  ///< first of its unknowns
    double radius = 0;                ///< maximum of |c|
    double mass = 0;                  ///< a typical value
    MatrixX directions;               ///< K × dimension
    VectorX support;                  ///< maximum of direction · c
    MatrixX com_samples;              ///< dimension × samples: c
    MatrixX variable_samples;         ///< variables × samples
  };
  VectorX features(const VectorX& u) const;
  void classify_variables(const VectorX& anchor, const std::vector<bool>& is_active_parameter);
  void move_nonlinear_out(std::vector<int>& inner, const std::vector<bool>& is_active_parameter);
  bool is_nonlinear(int i, int j, const VectorX& base, const std::vector<bool>& is_active_parameter) const;
  Eigen::Index count_mass_terms() const { return dimension_ == 2 ? 4 : 10; }
  bool are_copies(const ElementCopy& a, const ElementCopy& b) const;
  std::vector<ElementCopy> list_moved_elements(int number) const;
  std::optional<FirstMomentLift> find_lift(int number, const std::vector<bool>& is_active_parameter) const;
  bool sample_com_positions(FirstMomentLift& lift, const VectorX& anchor) const;
  VectorX com_position(const FirstMomentLift& lift, const VectorX& u) const;
  void add_lift_cones(const FirstMomentLift& lift, const AffineTerms& terms, const VectorX& at_zero,
                      const MatrixX& slopes, numerics::ConeProgramBuilder& rows) const;
  void write_lift_rows(const FirstMomentLift& lift, const ElementCopy& element, const VectorX& at_zero,
                       const MatrixX& slopes, AffineTerms& terms) const;

  const SolverContext& context_;
  int dimension_;
  Eigen::Index terms_ = 0, unknowns_ = 0;
  std::vector<int> outer_, linear_;
  std::vector<FirstMomentLift> lifts_;
};

}  // namespace balance::design
