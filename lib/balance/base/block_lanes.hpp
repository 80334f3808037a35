#pragma once
/// A block triangular system (BlockTriangular) for several samples at once: a matrix in every lane, all of one pattern, its rows
/// in the order of pivots that one of them was factorised in. A lane that this order does not suit is given its own, and a lane
/// without a regular matrix is told of; neither changes a bit of the others' results.

#include "balance/base/block_triangular.hpp"
#include "balance/base/lane_blocks.hpp"
#include "balance/base/lane_inverse.hpp"

#include <vector>

namespace balance {

/// @tparam T Pack<W>
template <class T>
class LaneBlockTriangular {
 public:
  /// @param scalar factorised, for a state near those of the lanes
  explicit LaneBlockTriangular(const BlockTriangular& scalar) : scalar_(scalar), structure_(scalar.structure()) {
    const auto n = static_cast<std::size_t>(size());
    values_.assign(scalar.entry_count(), T(0.0));
    work_.assign(n, T(0.0));
    factors_.assign(static_cast<std::size_t>(structure_.diagonal_entries), T(0.0));
    exchanged_.resize(structure_.blocks.size());
    quality_.assign(structure_.blocks.size(), T(0.0));
    order_.resize(n);
    set_pivot_order(scalar);
  }

  /// The rows in the order of pivots of another matrix of the same pattern.
  void set_pivot_order(const BlockTriangular& scalar) {
    structure_.row_exchanges = scalar.structure().row_exchanges;
    for (const BlockTriangular::Block& block : structure_.blocks) {
      for (int i = 0; i < block.size; ++i) order_[block.begin + i] = block.begin + i;
      if (block.size > lane_blocks::max_inverted_size)
        for (int i = 0; i < block.size; ++i)
          std::swap(order_[block.begin + i], order_[block.begin + structure_.row_exchanges[block.begin + i]]);
    }
  }

  int size() const { return static_cast<int>(structure_.row_position.size()); }
  /// As of BlockTriangular, whose index() holds here too.
  T* storage() { return values_.data(); }
  const T* storage() const { return values_.data(); }
  int index(int row, int column) const { return scalar_.index(row, column); }
  T& at(int row, int column) { return values_[static_cast<std::size_t>(scalar_.index(row, column))]; }

  /// @return per lane the smallest |pivot| or 1/|entry of an inverse|, 0 if singular or not finite
  T factorise() {
    T quality = 1.0;
    for (std::size_t b = 0; b < structure_.blocks.size(); ++b) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      quality_[b] = small_blocks::dispatch_by_size(
          block.size, [&](auto size) { return factorise_block<size>(block, exchanged_[b]); });
      quality = min(quality, quality_[b]);
    }
    return select(quality > 0.0, quality, T(0.0));
  }

  const std::vector<BlockTriangular::Block>& blocks() const { return structure_.blocks; }
  /// Of one diagonal block, of the last factorisation; as factorise() returns it.
  const T& min_pivot(std::size_t block) const { return quality_[block]; }
  /// x := A_bb⁻¹ x for diagonal block b. @param x twice as long as the block: behind the right-hand side there is room to work in
  void solve_in_block(std::size_t b, T* x) {
    const Block& block = structure_.blocks[b];
    T* work = &work_[block.begin];
    std::copy_n(x, block.size, work);
    small_blocks::dispatch_by_size(block.size,
                                   [&](auto size) { solve_block<size>(block, exchanged_[b], x + block.size); });
    std::copy_n(work, block.size, x);
  }

  /// x := A⁻¹ x, in the original order. Allocates nothing.
  void solve(T* x) {
    const int n = size();
    for (int row = 0; row < n; ++row) work_[structure_.row_position[row]] = x[row];
    for (std::size_t b = 0; b < structure_.blocks.size(); ++b) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      for (int i = block.begin; i < block.begin + block.size; ++i)
        for (int k = structure_.row_begin[i]; k < structure_.row_begin[i + 1]; ++k)
          work_[i] -= values_[structure_.diagonal_entries + k] * work_[structure_.column_index[k]];
      small_blocks::dispatch_by_size(block.size, [&](auto size) { solve_block<size>(block, exchanged_[b], x); });
    }
    for (int column = 0; column < n; ++column) x[column] = work_[structure_.column_position[column]];
  }

  /// x := A⁻ᵀ x.
  void solve_transposed(T* x) {
    const int n = size();
    for (int column = 0; column < n; ++column) work_[structure_.column_position[column]] = x[column];
    for (std::size_t b = structure_.blocks.size(); b-- > 0;) {
      const BlockTriangular::Block& block = structure_.blocks[b];
      small_blocks::dispatch_by_size(block.size,
                                     [&](auto size) { solve_block_transposed<size>(block, exchanged_[b], x); });
      for (int i = block.begin; i < block.begin + block.size; ++i)
        for (int k = structure_.row_begin[i]; k < structure_.row_begin[i + 1]; ++k)
          work_[structure_.column_index[k]] -= values_[structure_.diagonal_entries + k] * work_[i];
    }
    for (int row = 0; row < n; ++row) x[row] = work_[structure_.row_position[row]];
  }

 private:
  using Block = BlockTriangular::Block;
  using Exchanges = lane_blocks::RowExchanges<T>;

  void fill(const Block& block, const std::vector<int>& order, T* factors) const {
    for (int i = 0; i < block.size; ++i)
      for (int j = 0; j < block.size; ++j)
        factors[i * block.size + j] = values_[block.offset + (order[block.begin + i] - block.begin) * block.size + j];
  }

  template <int N>
  T factorise_block(const Block& block, Exchanges& exchanges) {
    T* factors = factors_.data() + block.offset;
    fill(block, order_, factors);
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      return lane_blocks::invert(std::integral_constant<int, N>{}, factors);
    } else {
      exchanges.clear();
      auto grown = lane_blocks::eliminate<N>(factors, block.size);
      if (any(grown.needs_pivoting)) {
        fill(block, order_, factors);
        grown = lane_blocks::eliminate_with_pivoting<N>(factors, block.size, grown.needs_pivoting, exchanges);
      }
      return grown.min_pivot;
    }
  }

  template <int N>
  void solve_block(const Block& block, const Exchanges& exchanges, T* scratch) {
    const T* factors = factors_.data() + block.offset;
    T* work = &work_[block.begin];
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      lane_blocks::multiply<N>(factors, work);
    } else {
      for (int i = 0; i < block.size; ++i) scratch[i] = work_[order_[block.begin + i]];
      for (const auto& e : exchanges) lane_blocks::exchange(e.lanes, scratch[e.row], scratch[e.other]);
      lane_blocks::solve<N>(factors, block.size, scratch);
      for (int i = 0; i < block.size; ++i) work[i] = scratch[i];
    }
  }

  template <int N>
  void solve_block_transposed(const Block& block, const Exchanges& exchanges, T* scratch) {
    const T* factors = factors_.data() + block.offset;
    T* work = &work_[block.begin];
    if constexpr (N > 0 && N <= lane_blocks::max_inverted_size) {
      lane_blocks::multiply_transposed<N>(factors, work);
    } else {
      lane_blocks::solve_transposed<N>(factors, block.size, work);
      for (auto e = exchanges.rbegin(); e != exchanges.rend(); ++e)
        lane_blocks::exchange(e->lanes, work[e->row], work[e->other]);
      for (int i = 0; i < block.size; ++i) scratch[i] = work[i];
      for (int i = 0; i < block.size; ++i) work_[order_[block.begin + i]] = scratch[i];
    }
  }

  BlockTriangular scalar_;  ///< for the places of entries
  BlockTriangular::Structure structure_;
  std::vector<int> order_;            ///< per permuted row: the row that stands there in its block's factors
  std::vector<T> values_, factors_;   ///< as in BlockTriangular
  std::vector<T> quality_;            ///< per block, of the last factorisation
  std::vector<Exchanges> exchanged_;  ///< per block
  std::vector<T> work_;
};

}  // namespace balance
