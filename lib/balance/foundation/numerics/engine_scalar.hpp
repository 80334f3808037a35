#pragma once
/// The scalar that a template source is compiled for. The same sources are compiled over doubles (`balance::core`) and
/// over duals (`balance::derivatives`, with BALANCE_DUALS), some also over many samples at once (cmake/Lanes.cmake) or
/// over interval jets (`balance::synthesis`, with BALANCE_INTERVALS): see cmake/Libraries.cmake. To be used only for the explicit instantiations at the end of a source.

#include "balance/foundation/base/dual.hpp"
#ifdef BALANCE_INTERVALS
#include "balance/foundation/base/interval_jet.hpp"
#endif
#ifdef BALANCE_LANES_TABLE
#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/lane_block_triangular.hpp"
#endif

namespace balance::numerics {

/// Number of derivatives per pass; more are computed in several passes.
inline constexpr int dual_width = 8;

#ifdef BALANCE_DUALS
using EngineScalar = Dual<dual_width>;
#elif defined(BALANCE_INTERVALS)
using EngineScalar = IntervalJet;
#elif defined(BALANCE_LANES_TABLE)
using EngineScalar = Pack<native_lanes>;
#else
using EngineScalar = double;
#endif

}  // namespace balance::numerics

namespace balance {

using numerics::EngineScalar;

}  // namespace balance
