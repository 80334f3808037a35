#pragma once
/// Complex arithmetic of the plane: a point (x, y) is x + iy, and everything rigid is linear in a few points.
/// Lengths are in units of the mechanism's characteristic length. Private to natural.

#include "balance/base/elementary.hpp"
#include "balance/base/types.hpp"

#include <complex>
#include <vector>

namespace balance::natural {

using Complex = std::complex<double>;

/// e^(i angle).
inline Complex unit_at(double angle) { return {elementary::cos(angle), elementary::sin(angle)}; }
inline constexpr Complex imaginary{0, 1};

inline double dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }
inline double cross(Complex a, Complex b) { return a.real() * b.imag() - a.imag() * b.real(); }

/// Values, rates or accelerations of all coordinates. Points: the moving ones first, then those of the ground.
struct Coordinates {
  std::vector<Complex> points;
  std::vector<double> scalars;  ///< angles [rad] and slides that the points do not carry

  /// Adds a vector in the order of the unknowns: x and y of the moving points, then the scalars.
  void add(double factor, const VectorX& unknowns);
  void set(const VectorX& unknowns);
};

/// A configuration with its two time derivatives.
struct State {
  double time = 0;
  Coordinates position, velocity, acceleration;
};

struct Term {
  int point = 0;
  Complex weight;
};

/// constant + Σ weight · point: a place or a direction of a body.
struct Form {
  Complex constant;
  std::vector<Term> terms;

  Complex at(const Coordinates& position) const;
  /// Of rates or accelerations, which the constant has none of.
  Complex rate(const Coordinates& rates) const;
};

Form operator+(Form a, const Form& b);
Form operator-(const Form& a, const Form& b);
Form operator*(Complex factor, Form form);
/// A constant direction or place.
Form constant_form(Complex value);

struct ScalarTerm {
  int scalar = 0;
  double coefficient = 1;
};

/// One equation: Re(conj(left) right) + Σ coefficient · scalar = constant, which is at most quadratic; or, with `angle` ≥ 0,
/// Im(exp(−i scalar[angle]) right) = 0, which ties a rotation angle to a direction.
struct Row {
  Form left, right;
  std::vector<ScalarTerm> scalars;
  double constant = 0;
  int angle = -1;

  double value(const Coordinates& position) const;
  /// Its derivatives by the unknowns. @param out as many entries as there are unknowns; overwritten
  void gradient(const Coordinates& position, int moving_points, Eigen::Ref<Eigen::RowVectorXd> out) const;
  double rate(const Coordinates& position, const Coordinates& velocity) const;
  /// The part of the second derivative that velocities alone cause.
  double bias(const Coordinates& position, const Coordinates& velocity) const;
  double second_rate(const State& state) const;
};

}  // namespace balance::natural
