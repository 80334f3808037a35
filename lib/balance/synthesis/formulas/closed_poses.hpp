#pragma once
/// Poses at which the loops of a symbolic tree close, and the values of its names there.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/symbolic_equations.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace balance::formulas {

inline std::vector<double> to_list(const VectorX& x) { return {x.data(), x.data() + x.size()}; }

/// Values of all names at a pose, except those that steps of an elimination define.
/// @param y per column of the tree [rad or m]
std::map<std::string, double> evaluate_names(const Ring& ring, const SymbolicEquations& equations,
                                             const std::vector<double>& y);

/// Values of a ring's symbols and angles, by their indices.
struct PoseValues {
  std::vector<double> symbols, angles;

  double operator()(const Polynomial& p) const { return p.is_zero() ? 0 : evaluate_polynomial(p, symbols, angles); }
  MatrixX operator()(const Matrix& matrix, Eigen::Index columns) const;
};

PoseValues evaluate_pose(const Ring& ring, const std::map<std::string, double>& names);
PoseValues evaluate_pose(const Ring& ring, const SymbolicEquations& equations, const VectorX& y);

/// Per column, its value in this list; 0 for columns without one.
VectorX rough_pose(const SymbolicTree& tree, const std::vector<CoordinateValue>& values);

/// Moves a pose to the nearest one at which the loops close, by Gauss and Newton.
/// @return whether they close there
bool close_loops(const Ring& ring, const SymbolicEquations& equations, VectorX& y);

/// Closed poses near a rough one, at most `count`; first the one that is nearest to it.
/// @param close_loops moves a pose to one at which the loops close, and returns whether it does
std::vector<VectorX> find_closed_poses(const VectorX& rough, std::size_t count, std::uint64_t seed,
                                       const std::function<bool(VectorX&)>& close_loops);

/// Coordinates of all joints where the engine assembles the mechanism at the independent coordinates q.
/// @return nothing if it does not, or not at the tree's pose y
std::optional<VectorX> assemble_engine(InverseDynamics& engine, const Mechanism& mechanism, const SymbolicTree& tree,
                                       const VectorX& q, const VectorX& y);

}  // namespace balance::formulas
