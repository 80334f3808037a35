#pragma once
/// Sine and cosine in lanes, to the bits of those of a single number. Private to the library.

#include "balance/base/pack.hpp"
#include "balance/base/sine.hpp"

namespace balance {

template <int W>
inline SineCosine<Pack<W>> sine_cosine(const Pack<W>& x) {
  using P = Pack<W>;
  auto reduced = sines::reduce_small<typename P::Numbers, typename P::Bits>(x.v);
  const Mask<W> small = abs(x) <= sines::largest_small;
  if (!all(small)) {
    for (int l = 0; l < W; ++l) {
      if (small[l]) continue;
      const auto lane = sines::reduce_large(x[l]);
      reduced.y[l] = lane.y, reduced.t[l] = lane.t, reduced.quadrant[l] = lane.quadrant;
    }
  }
  const auto both = sines::of_reduced(reduced);
  return {P(both.sine), P(both.cosine)};
}

/// Under the name that the recursions call.
template <int W>
inline void sine_and_cosine(const Pack<W>& x, Pack<W>& sine, Pack<W>& cosine) {
  const auto both = sine_cosine(x);
  sine = both.sine, cosine = both.cosine;
}

}  // namespace balance
