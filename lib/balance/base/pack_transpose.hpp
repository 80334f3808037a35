#pragma once
/// Squares of numbers whose rows are packs. Private to base and lanes.

#include "balance/base/pack.hpp"

#include <utility>

namespace balance {

namespace packs {

// One stage of a transposition: a and b have rows D apart, and exchange every second D of their columns.
template <int D, int W, int... Lane>
void exchange(Pack<W>& a, Pack<W>& b, std::integer_sequence<int, Lane...>) {
  const Pack<W> first(__builtin_shufflevector(a.v, b.v, (Lane & D ? W + Lane - D : Lane)...));
  b.v = __builtin_shufflevector(a.v, b.v, (Lane & D ? W + Lane : Lane + D)...);
  a = first;
}

template <int D, int W>
inline void transpose_stage(Pack<W> (&rows)[W]) {
  for (int i = 0; i < W; ++i)
    if ((i & D) == 0) exchange<D>(rows[i], rows[i + D], std::make_integer_sequence<int, W>());
  if constexpr (2 * D < W) transpose_stage<2 * D>(rows);
}

}  // namespace packs

/// rows[i][j] becomes rows[j][i].
template <int W>
inline void transpose(Pack<W> (&rows)[W]) {
  packs::transpose_stage<1>(rows);
}

}  // namespace balance
