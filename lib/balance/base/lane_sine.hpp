#pragma once
/// Sine and cosine in lanes, to the bits of those of a single number. Private to the library.

#include "balance/base/pack.hpp"
#include "balance/base/sine.hpp"

namespace balance {

template <int W>
inline SineCosine<Pack<W>> sine_cosine(const Pack<W>& x) {
  using P = Pack<W>;
  auto reduced = sines::reduce_cody_waite<typename P::Numbers, typename P::Bits>(x.v);
  const Mask<W> small = abs(x) <= sines::max_cody_waite_argument;
  if (!all(small)) {
    for (int l = 0; l < W; ++l) {
      if (small[l]) continue;
      const auto lane = sines::reduce_payne_hanek(x[l]);
      reduced.y[l] = lane.y, reduced.t[l] = lane.t, reduced.quadrant[l] = lane.quadrant;
    }
  }
  const auto both = sines::sine_cosine_of_reduced(reduced);
  return {P(both.sine), P(both.cosine)};
}

/// Under the name that the recursions call.
template <int W>
inline void sine_cosine_into(const Pack<W>& x, Pack<W>& sine, Pack<W>& cosine) {
  const auto both = sine_cosine(x);
  sine = both.sine, cosine = both.cosine;
}

}  // namespace balance
