// Compiled once for every instruction set: see cmake/Lanes.cmake.
#include "probe.hpp"

#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/lane_block_triangular.hpp"

namespace {

constexpr int eight = 8;
using Lanes = balance::Pack<balance::native_lanes>;

void operations(const double* x, const double* y, double* out) {
  for (int k = 0; k < eight; k += Lanes::lanes) {
    const Lanes a = Lanes::load(x + k), b = Lanes::load(y + k);
    const auto turn = balance::sine_cosine(a);
    const Lanes results[Probe::operation_results] = {turn.sine,          turn.cosine,
                                                     a * b + a,  // must not be fused
                                                     a / b - b * a,      sqrt(abs(a)), max(a, min(b, a * a)),
                                                     select(a < b, a, b)};
    for (int r = 0; r < Probe::operation_results; ++r) results[r].store(out + r * eight + k);
  }
}

void solve(const balance::numerics::BlockTriangular& scalar, const double* entries, const double* right, double* out) {
  balance::numerics::LaneBlockTriangular<Lanes> lanes(scalar);
  const int n = lanes.size(), width = 2 * n + 1;
  std::vector<Lanes> x(n), z(n);
  for (int k = 0; k < eight; k += Lanes::lanes) {
    for (int i = 0; i < n; ++i) {
      x[i] = z[i] = right[i];
      for (int j = 0; j < n; ++j)
        for (int l = 0; l < Lanes::lanes; ++l) lanes.at(i, j).v[l] = entries[((k + l) * n + i) * n + j];
    }
    const Lanes quality = lanes.factorise();
    lanes.solve(x.data());
    lanes.solve_transposed(z.data());
    for (int l = 0; l < Lanes::lanes; ++l) {
      double* row = out + (k + l) * width;
      row[0] = quality[l];
      for (int i = 0; i < n; ++i) row[1 + i] = x[i][l], row[1 + n + i] = z[i][l];
    }
  }
}

}  // namespace

extern "C" {
extern const Probe BALANCE_LANES_TABLE;
const Probe BALANCE_LANES_TABLE = {Lanes::lanes, operations, solve};
}
