// Compiled once for every instruction set: see cmake/Lanes.cmake.
#include "balance/mechanics/lanes/lane_kernels.hpp"

#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/engine_scalar.hpp"
#include "balance/mechanics/dynamics/tree_dynamics.hpp"
#include "balance/mechanics/lanes/lane_motion.hpp"

#include <algorithm>

// These types are shared with objects compiled for other instruction sets.
static_assert(alignof(balance::Vector2) == 16 && alignof(balance::Vector3) == 8 && alignof(balance::Matrix3) == 8);

namespace balance::lanes {

namespace {

using Lanes = EngineScalar;

/// Loads rows of a table as lanes, one entry per column, and stores them back, in square blocks of as many rows and
/// columns as there are lanes. A block wider than the rows reaches into the rows after them; if there are none, numbers
/// are copied one by one through a buffer.
class LaneRows {
 public:
  LaneRows(int columns, long count)
      : columns_(columns), count_(count), buffer_(static_cast<std::size_t>(columns) * W) {}

  /// Loads rows k…; beyond the last row it repeats the last.
  void load(const double* table, long k, Lanes* out) {
    if (can_transpose_blocks(k)) {
      for (int block = 0; block < columns_; block += W) {
        const int first = first_column(block);
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
      for (int c = 0; c < columns_; ++c) buffer_[c * W + l] = row[c];
    }
    for (int c = 0; c < columns_; ++c) out[c] = Lanes::load(&buffer_[c * W]);
  }

  /// Stores rows k…; may overwrite the beginning of the next row, which must be stored afterwards.
  void store(const Lanes* in, long k, double* table) {
    if (can_transpose_blocks(k)) {
      for (int block = 0; block < columns_; block += W) {
        const int first = first_column(block);
        Lanes entries[W];
        for (int c = 0; c < W; ++c) entries[c] = in[std::min(first + c, columns_ - 1)];
        transpose(entries);
        for (int l = 0; l < W; ++l) entries[l].store(table + (k + l) * columns_ + first);
      }
      return;
    }
    for (int c = 0; c < columns_; ++c) in[c].store(&buffer_[c * W]);
    const int row_count = static_cast<int>(std::min<long>(W, count_ - k));
    for (int l = 0; l < row_count; ++l)
      for (int c = 0; c < columns_; ++c) table[(k + l) * columns_ + c] = buffer_[c * W + l];
  }

 private:
  static constexpr int W = Lanes::lanes;

  /// The last block of a wide row ends with the row.
  int first_column(int block) const { return std::max(0, std::min(block, columns_ - W)); }
  bool can_transpose_blocks(long k) const {
    return (k + W - 1) * columns_ + std::max(W, columns_) <= count_ * columns_;
  }

  int columns_;
  long count_;
  std::vector<double> buffer_;
};

template <class L, class S>
void run_lane_inverse_dynamics(const kinematics::Tree<S>& tree, const typename S::Vector& gravity,
                               const InverseDynamicsJob& job) {
  const int columns = tree.columns;
  const typename L::Vector field = gravity.template cast<Lanes>();
  kinematics::TreeState<L> state(tree.nodes.size());
  std::vector<dynamics::Wrench<L>> wrenches(tree.nodes.size());
  LaneRows rows(columns, job.count);
  std::vector<Lanes> numbers(static_cast<std::size_t>(columns) * 4);
  Lanes *y = numbers.data(), *dy = y + columns, *ddy = dy + columns, *tau = ddy + columns;
  for (long k = 0; k < job.count; k += Lanes::lanes) {
    rows.load(job.y, k, y);
    rows.load(job.dy, k, dy);
    rows.load(job.ddy, k, ddy);
    dynamics::open_tree_inverse_dynamics<L>(tree, y, dy, ddy, field, state, wrenches, tau);
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
    .planar_torques = run_lane_inverse_dynamics<kinematics::PlanarOf<Lanes>, kinematics::Planar>,
    .spatial_torques = run_lane_inverse_dynamics<kinematics::SpatialOf<Lanes>, kinematics::Spatial>,
    .planar_motion = make_lane_motion<kinematics::PlanarOf<Lanes>, kinematics::Planar>,
    .spatial_motion = make_lane_motion<kinematics::SpatialOf<Lanes>, kinematics::Spatial>,
};
}

}  // namespace balance::lanes
