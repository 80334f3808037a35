#pragma once
/// Calculations in lanes to compare between instruction sets, eight samples at a time.

#include "balance/foundation/numerics/block_triangular.hpp"

struct Probe {
  int lanes;
  /// For eight numbers each: sine, cosine, and what the other operations make of two.
  void (*operations)(const double* x, const double* y, double* out);
  static constexpr int operation_results = 7;
  /// Eight systems of the scalar one's pattern (entries [sample][row][column]) for one right-hand side.
  /// @param out per sample quality, solution, solution of the transposed system
  void (*solve)(const balance::numerics::BlockTriangular& scalar, const double* entries, const double* right,
                double* out);
};
