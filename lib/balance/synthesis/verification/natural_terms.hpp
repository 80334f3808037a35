#pragma once
/// A planar mechanism's equations in natural coordinates at one configuration, as P3 writes them.

#include "balance/mechanics/model/mechanism.hpp"

#include <complex>
#include <string>
#include <vector>

namespace balance::verification::natural {

/// C_P of P3 eq. 37: the 2×2 matrix [re −im; im re] [kg].
struct PointMatrix {
  std::string point;  ///< "crank1.B"; "crank1.(2)" is an auxiliary point
  bool fixed = false;
  std::complex<double> coefficient;
};

struct NaturalTerms {
  std::vector<std::string> points;       ///< p points, the moving ones first
  Eigen::Index moving = 0;               ///< number of moving points
  std::vector<std::string> coordinates;  ///< u unknowns: x and y of the moving points, then counted angles and slides
  MatrixX position;                      ///< p×2 [m]
  MatrixX mass;                          ///< 2p×2p [kg]: M of P3 eq. 21–23, 35, symmetric
  std::vector<std::string> rotors;  ///< discs that rotate with the counted angles, besides the points' masses, as text
  double unit = 1;                  ///< unit of length in the constraints [m]: points are divided by it
  std::vector<std::string> constraints;   ///< as text: P3 eq. 30, at most quadratic
  VectorX residual;                       ///< of the constraints at this configuration
  MatrixX jacobian;                       ///< constraints × u: P3 eq. 31
  std::vector<PointMatrix> coefficients;  ///< C_P of all points (P3 eq. 37–46)
  double total_mass = 0;                  ///< of all moving bodies [kg]
};

/// @param coordinates values of all joint coordinates, with the loops closed
/// @throws std::invalid_argument if the mechanism is spatial or the number of values is not that of the coordinates
NaturalTerms compute_natural_terms(const Mechanism& mechanism, const VectorX& coordinates);

}  // namespace balance::verification::natural
