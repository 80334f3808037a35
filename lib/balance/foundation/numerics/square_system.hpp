#pragma once
/// Square linear systems of fixed sparsity over any scalar. Over doubles: BlockTriangular itself. Over duals, the
/// values are factorised once and each derivative adds one right-hand side: A x = b implies A dx = db − dA x.

#include "balance/foundation/base/dual.hpp"
#include "balance/foundation/numerics/block_triangular.hpp"

#include <vector>

namespace balance::numerics {

/// Same interface as BlockTriangular; regularity and nearness are those of the values.
template <int N>
class DualBlockTriangular {
 public:
  using T = Dual<N>;

  bool analyse(const SparsityPattern& pattern) {
    if (!values_.analyse(pattern)) return false;
    nonzeros_.clear();
    for (int row = 0; row < values_.size(); ++row)
      for (const int column : pattern[static_cast<std::size_t>(row)])
        nonzeros_.push_back({row, column, values_.index(row, column)});
    entries_.assign(values_.entry_count(), 0);
    right_hand_side_.assign(static_cast<std::size_t>(values_.size()), 0);
    solution_ = right_hand_side_;
    work_.assign(right_hand_side_.size(), 0);
    return true;
  }

  int size() const { return values_.size(); }
  int index(int row, int column) const { return values_.index(row, column); }
  T* storage() { return entries_.data(); }
  const T* storage() const { return entries_.data(); }
  /// Zero outside the pattern.
  T at(int row, int column) const {
    const int entry = values_.index(row, column);
    return entry < 0 ? T(0) : entries_[static_cast<std::size_t>(entry)];
  }
  BlockTriangular& values() { return values_; }

  double factorise() {
    for (const Nonzero& entry : nonzeros_) values_.storage()[entry.index] = entries_[at(entry)].value;
    return values_.factorise();
  }
  void store() { values_.store(); }
  bool is_near_stored(double limit) { return values_.is_near_stored(limit); }

  void solve(T* x) {
    solve_with(
        x, [&](auto* rhs, auto* work) { values_.solve(rhs, work); },
        [](const Nonzero& entry) { return std::pair(entry.row, entry.column); });
  }
  void solve_pair(T* x, T* z) {
    solve(x);
    solve(z);
  }
  void solve_transposed(T* x) {
    solve_with(
        x, [&](auto* rhs, auto* work) { values_.solve_transposed(rhs, work); },
        [](const Nonzero& entry) { return std::pair(entry.column, entry.row); });
  }

 private:
  struct Nonzero {
    int row, column, index;
  };
  std::size_t at(const Nonzero& entry) const { return static_cast<std::size_t>(entry.index); }

  /// Solves for values and derivatives together: the final right-hand sides share the matrix of the values.
  template <class Solve, class Position>
  void solve_with(T* x, const Solve& solve_values, const Position& position) {
    for (int i = 0; i < size(); ++i) solution_[i] = x[i].value;
    solve_values(solution_.data(), right_hand_side_.data());
    for (const Nonzero& entry : nonzeros_) {
      const auto [row, column] = position(entry);
      const T& a = entries_[at(entry)];
      x[row].d -= a.d * solution_[column];
    }
    solve_values(x, work_.data());
  }

  BlockTriangular values_;
  std::vector<T> entries_;
  std::vector<Nonzero> nonzeros_;
  std::vector<double> right_hand_side_, solution_;
  std::vector<T> work_;
};

inline BlockTriangular& values_of(BlockTriangular& system) { return system; }
template <int N>
BlockTriangular& values_of(DualBlockTriangular<N>& system) {
  return system.values();
}

template <class T>
struct SquareSystemOf;
template <>
struct SquareSystemOf<double> {
  using Type = BlockTriangular;
};
template <int N>
struct SquareSystemOf<Dual<N>> {
  using Type = DualBlockTriangular<N>;
};
template <class T>
using SquareSystem = typename SquareSystemOf<T>::Type;

}  // namespace balance::numerics
