#include "balance/natural/inertia.hpp"

namespace balance::natural {

NaturalInertia& NaturalInertia::operator+=(const NaturalInertia& other) {
  mass += other.mass;
  first_moment += other.first_moment;
  second_moment += other.second_moment;
  return *this;
}

Eigen::Matrix2cd two_point_mass(const NaturalInertia& inertia, Complex a, Complex b) {
  const Complex way = b - a;
  const Complex first = (inertia.first_moment - inertia.mass * a) / way;  // ∫ κ dm
  const double square =                                                   // ∫ |κ|² dm
      (inertia.second_moment - 2 * dot(a, inertia.first_moment) + inertia.mass * std::norm(a)) / std::norm(way);
  Eigen::Matrix2cd M;
  M(0, 0) = inertia.mass - 2 * first.real() + square;
  M(0, 1) = first - square;  // ∫ conj(1 − κ) κ dm
  M(1, 0) = std::conj(M(0, 1));
  M(1, 1) = square;
  return M;
}

Matrix3 isotropic_moments(const NaturalInertia& inertia) {
  const double m = inertia.mass, x = inertia.first_moment.real(), y = inertia.first_moment.imag();
  const double half =
      m > 0 ? (inertia.second_moment - std::norm(inertia.first_moment) / m) / 2 : inertia.second_moment / 2;
  Matrix3 S;
  S << m, x, y,                                                  //
      x, half + (m > 0 ? x * x / m : 0), m > 0 ? x * y / m : 0,  //
      y, m > 0 ? x * y / m : 0, half + (m > 0 ? y * y / m : 0);
  return S;
}

Matrix3 three_point_mass(const Matrix3& moments, Complex a, Complex b, Complex c) {
  Matrix3 corners;  // column k: 1, x, y of corner k
  corners << 1, 1, 1, a.real(), b.real(), c.real(), a.imag(), b.imag(), c.imag();
  const Matrix3 weights = corners.inverse();  // row k: λ_k = weights · [1 x y]ᵀ
  return weights * moments * weights.transpose();
}

}  // namespace balance::natural
