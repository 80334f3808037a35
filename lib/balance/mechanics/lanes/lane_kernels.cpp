// Compiled once for every instruction set: see cmake/Lanes.cmake.
#include "balance/mechanics/lanes/lane_kernels.hpp"

#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/lanes/lane_motion.hpp"

#include <algorithm>

// Shared with objects for other sets.
static_assert(alignof(balance::Vector2) == 16 && alignof(balance::Vector3) == 8 && alignof(balance::Matrix3) == 8);

namespace balance {

namespace {

using Lanes = EngineScalar;

/// Rows of a table as lanes, one entry per column, and back: in squares of as many rows and columns as there are lanes. Where rows are
/// shorter than a square is wide it reaches into those after them; where there are none, number by number by way of memory of its own.
class LaneRows {
 public:
  LaneRows(int columns, long count)
      : columns_(columns), count_(count), numbers_(static_cast<std::size_t>(columns) * W) {}

  /// Rows k…; behind the last one it goes on with the last.
  void load(const double* table, long k, Lanes* out) {
    if (can_transpose_blocks(k)) {
      for (int square = 0; square < columns_; square += W) {
        const int first = first_column(square);
        Lanes entries[W];
        for (int l = 0; l < W; ++l) entries[l] = Lanes::load(table + (k + l) * columns_ + first);
        transpose(entries);
        for (int c = 0; c < W; ++c)
          if (c < columns_) out[first + c] = entries[c];
      }
      return;
    }
    for (int l = 0; l < W; ++l) {
      const double* row = table + std::min(k + l, count_ - 1) * columns_;
      for (int c = 0; c < columns_; ++c) numbers_[c * W + l] = row[c];
    }
    for (int c = 0; c < columns_; ++c) out[c] = Lanes::load(&numbers_[c * W]);
  }

  /// Rows k…, and perhaps the beginning of the next one, which must follow.
  void store(const Lanes* in, long k, double* table) {
    if (can_transpose_blocks(k)) {
      for (int square = 0; square < columns_; square += W) {
        const int first = first_column(square);
        Lanes entries[W];
        for (int c = 0; c < W; ++c) entries[c] = in[std::min(first + c, columns_ - 1)];
        transpose(entries);
        for (int l = 0; l < W; ++l) entries[l].store(table + (k + l) * columns_ + first);
      }
      return;
    }
    for (int c = 0; c < columns_; ++c) in[c].store(&numbers_[c * W]);
    const int kept = static_cast<int>(std::min<long>(W, count_ - k));
    for (int l = 0; l < kept; ++l)
      for (int c = 0; c < columns_; ++c) table[(k + l) * columns_ + c] = numbers_[c * W + l];
  }

 private:
  static constexpr int W = Lanes::lanes;

  /// The last square of wide rows ends with them.
  int first_column(int square) const { return std::max(0, std::min(square, columns_ - W)); }
  bool can_transpose_blocks(long k) const {
    return (k + W - 1) * columns_ + std::max(W, columns_) <= count_ * columns_;
  }

  int columns_;
  long count_;
  std::vector<double> numbers_;
};

template <class L, class S>
void run_lane_inverse_dynamics(const Tree<S>& tree, const typename S::Vector& gravity, const InverseDynamicsJob& job) {
  const int columns = tree.columns;
  const typename L::Vector field = gravity.template cast<Lanes>();
  TreeState<L> state(tree.nodes.size());
  std::vector<Wrench<L>> wrenches(tree.nodes.size());
  LaneRows rows(columns, job.count);
  std::vector<Lanes> numbers(static_cast<std::size_t>(columns) * 4);
  Lanes *y = numbers.data(), *dy = y + columns, *ddy = dy + columns, *tau = ddy + columns;
  for (long k = 0; k < job.count; k += Lanes::lanes) {
    rows.load(job.y, k, y);
    rows.load(job.dy, k, dy);
    rows.load(job.ddy, k, ddy);
    open_tree_inverse_dynamics<L>(tree, y, dy, ddy, field, state, wrenches, tau);
    rows.store(tau, k, job.tau);
  }
}

template <class L, class S>
std::unique_ptr<GroupSolver<S>> make_lane_motion(const GroupSetup<S>& setup) {
  return std::make_unique<LaneGroupSolver<L, S>>(setup);
}

}  // namespace

extern "C" {
extern const LaneKernels BALANCE_LANES_TABLE;
const LaneKernels BALANCE_LANES_TABLE = {
    .planar_torques = run_lane_inverse_dynamics<PlanarOf<Lanes>, Planar>,
    .spatial_torques = run_lane_inverse_dynamics<SpatialOf<Lanes>, Spatial>,
    .planar_motion = make_lane_motion<PlanarOf<Lanes>, Planar>,
    .spatial_motion = make_lane_motion<SpatialOf<Lanes>, Spatial>,
};
}

}  // namespace balance
