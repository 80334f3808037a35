#pragma once
/// The mechanisms of `configs/` at configurations that they can take.

#include "every_config.hpp"

#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/kinematics/assembly.hpp"

#include <cmath>

namespace equations {

using balance::CoordinateValue;
using balance::MatrixX;
using balance::Mechanism;
using balance::Study;
using balance::Vector3;
using balance::VectorX;
using balance::dynamics::EquationTerms;

inline constexpr const char* machines[] = {"rr.yaml",
                                           "planar-rrr.yaml",
                                           "spatial-rrr.yaml",
                                           "scara.yaml",
                                           "four-bar.yaml",
                                           "5r.yaml",
                                           "3rrr.yaml",
                                           "delta.yaml",
                                           "stewart.yaml",
                                           "bricard.yaml",
                                           "rccc.yaml",
                                           "spring-press.yaml",
                                           "slider-crank.yaml",
                                           "squeezer.yaml",
                                           "watt-six-bar.yaml",
                                           "geared-five-bar.yaml",
                                           "spatial-slider-crank.yaml"};

inline VectorX wave(Eigen::Index n, double phase) {
  VectorX v(n);
  for (Eigen::Index k = 0; k < n; ++k) v[k] = std::sin(1.7 * static_cast<double>(k + 1) + phase);
  return v;
}

/// The pose that a study's first trajectory starts from, of all coordinates.
inline std::vector<CoordinateValue> start_of(const Study& study) {
  return balance::kinematics::solve_configuration(study.mechanism, study.trajectories.front().from).coordinates;
}

/// Values of the independent coordinates among all.
inline VectorX own(const EquationTerms& terms, const std::vector<CoordinateValue>& all) {
  VectorX q(terms.degrees_of_freedom());
  for (Eigen::Index k = 0; k < q.size(); ++k)
    q[k] = all[static_cast<std::size_t>(terms.independent()[static_cast<std::size_t>(k)])].value;
  return q;
}

inline double largest(const MatrixX& matrix) { return matrix.size() == 0 ? 0 : matrix.cwiseAbs().maxCoeff(); }

}  // namespace equations
