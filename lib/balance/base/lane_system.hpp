#pragma once
/// The linear systems of base/square_system.hpp and base/tall_system.hpp with a sample in every lane. Private to motion and lanes.

#include "balance/base/block_lanes.hpp"
#include "balance/base/pack_eigen.hpp"
#include "balance/base/square_system.hpp"
#include "balance/base/tall_system.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace balance {

/// The interface is that of BlockTriangular. What is told of all lanes together is that of the worst; the matrix kept is that of the
/// last lane, and nearness that of every lane to the one before it.
template <int W>
class LaneSquareSystem {
 public:
  using T = Pack<W>;

  bool analyse(const SparsityPattern& pattern) {
    BlockTriangular scalar;
    if (!scalar.analyse(pattern)) return false;
    lanes_.emplace(scalar);
    inside_ = static_cast<std::size_t>(scalar.structure().diagonal_entries);
    kept_.assign(scalar.entry_count(), 0);
    change_.assign(inside_, T(0.0));
    sums_.assign(static_cast<std::size_t>(scalar.size()), T(0.0));
    column_.assign(2 * sums_.size(), T(0.0));
    return true;
  }
  /// See LaneBlockTriangular.
  void take_order(const BlockTriangular& scalar) { lanes_->set_pivot_order(scalar); }

  int size() const { return lanes_->size(); }
  int index(int row, int column) const { return lanes_->index(row, column); }
  T* storage() { return lanes_->storage(); }
  const T* storage() const { return lanes_->storage(); }
  std::size_t stored() const { return kept_.size(); }
  T at(int row, int column) const {
    const int place = index(row, column);
    return place < 0 ? T(0.0) : storage()[place];
  }

  double factorise() {
    quality_ = lanes_->factorise();
    return reduce_min(quality_);
  }
  /// Per lane, of the last factorisation.
  const T& min_pivot() const { return quality_; }

  void store() {
    for (std::size_t k = 0; k < inside_; ++k) kept_[k] = storage()[k][W - 1];
  }
  /// A matrix of the same pattern, as stored by a BlockTriangular.
  void store(const double* matrix) { std::copy_n(matrix, inside_, kept_.begin()); }
  bool is_near_stored(double limit) {
    for (std::size_t b = 0; b < lanes_->blocks().size(); ++b)
      if (!block_near_kept(b, limit)) return false;
    return true;
  }

  void solve(T* x) { lanes_->solve(x); }
  void solve_pair(T* x, T* z) {
    solve(x);
    solve(z);
  }
  void solve_transposed(T* x) { lanes_->solve_transposed(x); }

 private:
  /// As BlockTriangular: the plain bound first.
  bool block_near_kept(std::size_t b, double limit) {
    const BlockTriangular::Block& block = lanes_->blocks()[b];
    const int n = block.size;
    const T* now = lanes_->storage() + block.offset;
    const double* kept = kept_.data() + block.offset;
    T widest = 0.0;
    for (int i = 0, k = 0; i < n; ++i) {
      T sum = 0.0;
      for (int j = 0; j < n; ++j, ++k) {
        change_[k] = now[k] - shift_lanes(now[k], kept[k]);
        sum += abs(change_[k]);
      }
      widest = max(widest, sum);
    }
    if (all(4.0 * n * widest <= limit * lanes_->min_pivot(b))) return true;
    for (int i = 0; i < n; ++i) sums_[i] = 0.0;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) column_[i] = change_[i * n + j];
      lanes_->solve_in_block(b, column_.data());
      for (int i = 0; i < n; ++i) sums_[i] += abs(column_[i]);
    }
    const auto within = [limit](const T& sum) { return all(sum <= limit); };  // false for NaN
    return std::all_of(sums_.begin(), sums_.begin() + n, within);
  }

  std::optional<LaneBlockTriangular<T>> lanes_;
  std::size_t inside_ = 0;  ///< entries of diagonal blocks
  std::vector<double> kept_;
  std::vector<T> change_, sums_, column_;  ///< for near_kept()
  T quality_ = 0.0;
};

template <int W>
struct SquareSystemOf<Pack<W>> {
  using Type = LaneSquareSystem<W>;
};

/// Redundant constraints are solved one sample after another: nobody may ask this of lanes.
template <int W>
class OverdeterminedSystem<Pack<W>> {
 public:
  using T = Pack<W>;
  void resize(int, int) { throw_unsupported(); }
  T* storage() { return throw_unsupported(); }
  const T* storage() const { return throw_unsupported(); }
  const T& at(int, int) const { return *throw_unsupported(); }
  double factorise() { return throw_unsupported(), 0; }
  void keep() { throw_unsupported(); }
  bool near_kept(double) const { return throw_unsupported(), false; }
  void solve(T*) const { throw_unsupported(); }

 private:
  [[noreturn]] static T* throw_unsupported() { throw std::logic_error("redundant constraints have no lanes"); }
};

}  // namespace balance
