#pragma once
/// Where a planar linkage is, and how it moves, at one moment of a prescribed motion, for all lengths of a box:
/// intervals of coordinates, rates and accelerations, and of their derivatives by the lengths.
///
/// Closures and drive are equations f(y, l) = 0 of the tree's coordinates y. Krawczyk's operator shows that they have
/// exactly one solution near the one known in the middle of the box, for each l of the box; by continuity it is the same
/// assembly. Implicit differentiation in interval arithmetic gives the rest. Derivation: docs/certificate.md, section 14.

#include "balance/foundation/base/interval_jet.hpp"
#include "balance/mechanics/kinematics/forward_kinematics.hpp"
#include "balance/motion/study/design_space.hpp"
#include "balance/synthesis/certificate/bernstein_form.hpp"

#include <vector>

namespace balance::certificate {

using IntervalPlane = kinematics::PlanarOf<IntervalJet>;
using IntervalVector = std::vector<Interval>;

/// What a trajectory prescribes: components of the tool point, then joint coordinates.
struct PlanarDrive {
  std::vector<int> point;  ///< world components
  std::vector<CoordinateId> coordinates;

  std::size_t size() const { return point.size() + coordinates.size(); }
};

/// One moment of a motion: the prescribed values, which no length changes, and the tree's coordinates at given lengths.
struct MotionPoint {
  VectorX y;
  VectorX value, rate, acceleration;  ///< of the drive
};

/// The linkage for all lengths of a box.
struct LinkageEnclosure {
  MechanismOf<IntervalJet> mechanism;
  kinematics::Tree<IntervalPlane> tree;
  kinematics::FixedFrame<IntervalPlane> tool;  ///< if the mechanism has one
};

/// A system of jets: rows × columns.
struct JetMatrix {
  std::size_t size = 0;
  std::vector<IntervalJet> entries;

  IntervalJet& at(std::size_t row, std::size_t column) { return entries[row * size + column]; }
  const IntervalJet& at(std::size_t row, std::size_t column) const { return entries[row * size + column]; }
  void reset(std::size_t n) {
    size = n;
    entries.assign(n * n, IntervalJet());
  }
};

/// Solves square systems whose matrices are near an approximate one. All may depend on the lengths.
class IntervalSolver {
 public:
  /// Prepares for a matrix. @throws EnclosureError if it may be singular
  void set(const MatrixX& approximate_inverse, const JetMatrix& matrix);
  IntervalVector solve(const IntervalVector& right) const;
  /// With derivatives. @param matrix that was set
  std::vector<IntervalJet> solve(const JetMatrix& matrix, const std::vector<IntervalJet>& right, int variables,
                                 int order) const;

 private:
  MatrixX inverse_;
  std::vector<Interval> factors_;  ///< of the approximate inverse times the matrix, without pivoting
};

/// Approximate inverse of the middle values. @throws EnclosureError if they are singular
MatrixX invert_middle(const JetMatrix& matrix);

/// The box's middle and the box itself, in the orders of derivatives that an enclosure needs.
struct BoxLinkages {
  LinkageEnclosure middle;      ///< order 0
  LinkageEnclosure values;      ///< order 0
  LinkageEnclosure slopes;      ///< order 1
  LinkageEnclosure last;        ///< of the order that is asked for
  std::vector<Interval> steps;  ///< per length: from the middle to any point of the box
  int order = 2;
};

class MotionEnclosure {
 public:
  /// @param linkages must outlive this object
  MotionEnclosure(const BoxLinkages& linkages, PlanarDrive drive);

  /// @param at the configuration of the middle of the box
  /// @return false if nothing could be shown; otherwise the following are for this moment
  bool enclose(const MotionPoint& at);

  const std::vector<IntervalJet>& coordinates() const { return y_; }
  const std::vector<IntervalJet>& rates() const { return dy_; }
  const std::vector<IntervalJet>& accelerations() const { return ddy_; }
  /// Poses, velocities and accelerations of the nodes, without gravity.
  const kinematics::TreeState<IntervalPlane>& state() const { return state_; }
  /// Rates of the tree's coordinates for which the closures hold and the coordinates `driven` have the given rates.
  /// @param rates as many as the drive has quantities
  /// @throws EnclosureError if they do not determine the motion
  std::vector<IntervalJet> solve_rates(const std::vector<CoordinateId>& driven, const std::vector<IntervalJet>& rates);

 private:
  void enclose_coordinates(const MotionPoint& at);
  void differentiate_coordinates(const MotionPoint& at);
  void enclose_rates(const MotionPoint& at);
  void evaluate(const LinkageEnclosure& linkage, const std::vector<IntervalJet>& y, const MotionPoint& at,
                bool has_matrix);
  void evaluate_closure(const LinkageEnclosure& linkage, const kinematics::Closure<IntervalPlane>& closure,
                        std::size_t row, bool has_matrix);
  void evaluate_drive(const LinkageEnclosure& linkage, const std::vector<IntervalJet>& y, const MotionPoint& at,
                      std::size_t row, bool has_matrix);

  const BoxLinkages& linkages_;
  PlanarDrive drive_;
  int variables_;
  std::size_t columns_;
  MatrixX inverse_;  ///< approximate, at the middle
  IntervalSolver solver_;
  kinematics::TreeState<IntervalPlane> state_;
  std::vector<IntervalJet> residual_;
  JetMatrix matrix_;
  std::vector<IntervalJet> y_, dy_, ddy_;
};

}  // namespace balance::certificate
