// Compiled once for every instruction set: see cmake/Lanes.cmake.
#include "balance/lanes/kernels.hpp"

#include "balance/base/number.hpp"
#include "balance/dynamics/recursion.hpp"
#include "balance/lanes/motion.hpp"

#include <algorithm>

// Shared with objects for other sets.
static_assert(alignof(balance::Vector2) == 16 && alignof(balance::Vector3) == 8 && alignof(balance::Matrix3) == 8);

namespace balance {

namespace {

using Lanes = Number;

/// Rows k… of a table as lanes, one entry per column. Behind the last row it goes on with the last.
void load(const double* table, int columns, long k, long count, Lanes* out) {
  const double* row[Lanes::lanes];
  for (int l = 0; l < Lanes::lanes; ++l) row[l] = table + std::min(k + l, count - 1) * columns;
  for (int c = 0; c < columns; ++c)
    for (int l = 0; l < Lanes::lanes; ++l) out[c].v[l] = row[l][c];
}

void store(const Lanes* in, int columns, long k, long count, double* table) {
  const int kept = static_cast<int>(std::min<long>(Lanes::lanes, count - k));
  for (int c = 0; c < columns; ++c)
    for (int l = 0; l < kept; ++l) table[(k + l) * columns + c] = in[c][l];
}

template <class L, class S>
void torques(const Tree<S>& tree, const typename S::Vector& gravity, const TorqueJob& job) {
  const int columns = tree.columns;
  const Tree<L> lanes = broadcast<L>(tree);
  const typename L::Vector field = gravity.template cast<Lanes>();
  State<L> state(tree.nodes.size());
  std::vector<Wrench<L>> wrenches(tree.nodes.size());
  std::vector<Lanes> numbers(static_cast<std::size_t>(columns) * 4);
  Lanes *y = numbers.data(), *dy = y + columns, *ddy = dy + columns, *tau = ddy + columns;
  for (long k = 0; k < job.count; k += Lanes::lanes) {
    load(job.y, columns, k, job.count, y);
    load(job.dy, columns, k, job.count, dy);
    load(job.ddy, columns, k, job.count, ddy);
    tree_torques<L>(lanes, y, dy, ddy, field, state, wrenches, tau);
    store(tau, columns, k, job.count, job.tau);
  }
}

template <class L, class S>
std::unique_ptr<GroupMotion<S>> motion(const GroupSetup<S>& setup) {
  return std::make_unique<LaneMotion<L, S>>(setup);
}

}  // namespace

extern "C" {
extern const LaneKernels BALANCE_LANES_TABLE;
const LaneKernels BALANCE_LANES_TABLE = {
    .planar_torques = torques<PlanarOf<Lanes>, Planar>,
    .spatial_torques = torques<SpatialOf<Lanes>, Spatial>,
    .planar_motion = motion<PlanarOf<Lanes>, Planar>,
    .spatial_motion = motion<SpatialOf<Lanes>, Spatial>,
};
}

}  // namespace balance
