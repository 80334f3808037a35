#pragma once
/// What a program of a mechanism with loops does around its straight-line functions: it closes the loops, solves for the
/// rates and accelerations of the dependent coordinates, and projects the tree's torques to the motors.

#include "balance/foundation/base/types.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/program_code.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance::formulas {

/// The sizes and constants of such a program.
struct LoopProgram {
  std::size_t columns = 0, closures = 0;
  std::vector<std::size_t> independent, dependent;  ///< columns
  bool has_all_coordinates = false;                 ///< its arguments are all coordinates, which close the loops
  double length = 1;                                ///< of the mechanism [m]
  std::vector<double> max_steps;                    ///< per independent coordinate, along which the loops stay closed
  std::vector<double> start;                        ///< per column, with the loops closed
  std::vector<std::string> motors;                  ///< names of what drives it
  /// Per motor, the index of its coordinate among the independent ones. Empty: the torques are those of least norm of
  /// `force_units` times each.
  std::vector<std::size_t> direct;
  std::vector<double> force_units;
};

/// `torques` and the functions that it calls, after `tree_torques`, `closures`, `closure_bias` and `inputs`.
std::string format_loop_functions(const LoopProgram& program, Language language);

/// Runs the straight-line functions of a printed program as format_loop_functions does.
class LoopProgramRunner {
 public:
  LoopProgramRunner(ProgramInterpreter& interpreter, const LoopProgram& program)
      : interpreter_(interpreter), program_(program) {}

  struct Closures {
    VectorX h;
    MatrixX A;
  };
  Closures closures(const VectorX& q);
  /// Moves the dependent coordinates to the nearest pose at which the loops close. @return whether they do
  bool close_loops(VectorX& q);
  /// Moves a pose to independent coordinates along a straight line, as the program does. @return whether it arrives
  bool follow(const VectorX& x, VectorX& q);
  /// Smallest singular value of the dependent coordinates' Jacobian that counts, relative to the largest.
  double regularity(const VectorX& q);
  /// ẏ = C q̇.
  MatrixX transformation(const VectorX& q);

  struct Motion {
    VectorX dq, ddq;      ///< of all coordinates
    VectorX generalised;  ///< forces of the independent coordinates, Cᵀ τ
  };
  /// @param dx, ddx of the independent coordinates
  Motion move(const VectorX& q, const VectorX& dx, const VectorX& ddx);

 private:
  MatrixX dependent_columns(const MatrixX& A) const;

  ProgramInterpreter& interpreter_;
  const LoopProgram& program_;
};

}  // namespace balance::formulas
