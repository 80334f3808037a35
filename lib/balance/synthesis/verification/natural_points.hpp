#pragma once
/// Complex arithmetic in the plane: a point (x, y) is x + iy, and everything rigid is linear in a few points. Lengths
/// are in units of the mechanism's characteristic length.

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"

#include <complex>
#include <string>
#include <vector>

namespace balance::verification::natural {

using Complex = std::complex<double>;

/// e^(i angle).
inline Complex make_unit_complex(double angle) { return {elementary::cos(angle), elementary::sin(angle)}; }
inline constexpr Complex imaginary{0, 1};

inline double dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }
inline double cross(Complex a, Complex b) { return a.real() * b.imag() - a.imag() * b.real(); }

/// Values, rates or accelerations of all coordinates. The moving points come first, then those of the ground.
struct NaturalCoordinates {
  std::vector<Complex> points;
  std::vector<double> scalars;  ///< angles [rad] and slides that are unknowns besides the points

  /// Adds factor times a vector in the order of the unknowns: x and y of the moving points, then the scalars.
  void add(double factor, const VectorX& unknowns);
  void set(const VectorX& unknowns);
};

/// A configuration with its two time derivatives.
struct NaturalState {
  double time = 0;
  NaturalCoordinates position, velocity, acceleration;
};

struct PointTerm {
  int point = 0;
  Complex weight;
};

/// constant + Σ weight · point: a position or direction on a body.
struct AffineForm {
  Complex constant;
  std::vector<PointTerm> terms;

  Complex at(const NaturalCoordinates& position) const;
  /// For rates or accelerations, to which the constant does not contribute.
  Complex rate(const NaturalCoordinates& rates) const;
};

AffineForm operator+(AffineForm a, const AffineForm& b);
AffineForm operator-(const AffineForm& a, const AffineForm& b);
AffineForm operator*(Complex factor, AffineForm form);
/// A constant direction or position.
AffineForm make_constant_form(Complex value);

struct ScalarTerm {
  int scalar = 0;
  double coefficient = 1;
};

/// One equation: Re(conj(left) right) + Σ coefficient · scalar = constant, at most quadratic; or, if `angle` ≥ 0,
/// Im(exp(−i scalar[angle]) right) = 0, which ties a rotation angle to a direction.
struct ConstraintRow {
  AffineForm left, right;
  std::vector<ScalarTerm> scalars;
  double constant = 0;
  int angle = -1;

  double value(const NaturalCoordinates& position) const;
  /// Derivatives with respect to the unknowns.
  /// @param out one entry per unknown; overwritten
  void gradient(const NaturalCoordinates& position, int moving_points, Eigen::Ref<Eigen::RowVectorXd> out) const;
  double rate(const NaturalCoordinates& position, const NaturalCoordinates& velocity) const;
  /// The part of the second derivative that depends on velocities alone.
  double bias(const NaturalCoordinates& position, const NaturalCoordinates& velocity) const;
  double second_rate(const NaturalState& state) const;
};

// Choice of the points that describe each body. Revolute and fixed joints share a point between their bodies (P3
// section 2). A body with too few points, or with points that are too close together, gets auxiliary ones.

/// A basic point from the viewpoint of one body.
struct BodyPoint {
  int point = 0;
  Complex position;  ///< in the body's axes
};

struct BodyPoints {
  /// The first two are the base: their difference is the body's direction. Empty for the ground.
  std::vector<BodyPoint> points;
  /// The first three form a triangle large enough to carry the mass; the third is tied by distances, others linearly.
  bool has_mass_triangle = false;
};

struct BasicPoints {
  double length = 1;               ///< unit of all positions [m]
  int moving = 0;                  ///< number of moving points, which come first; those of the ground follow
  std::vector<std::string> names;  ///< per point: "crank1.B", a joint's point on the first body that has it
  std::vector<Complex> fixed;      ///< positions of the ground's points, in order
  std::vector<BodyPoints> bodies;
  int count() const { return static_cast<int>(names.size()); }
};

BasicPoints choose_basic_points(const Mechanism& mechanism);

/// A vector of the model in the plane, in units of length.
inline Complex to_complex(const Vector3& v, double length) { return Complex(v.x(), v.y()) / length; }

}  // namespace balance::verification::natural
