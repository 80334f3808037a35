#pragma once
/// The scalar that a source of templates is compiled for. The same sources make the engine over doubles (`balance::core`) and over
/// numbers with derivatives (`balance::derivatives`, with BALANCE_DUALS), some of them over many samples at once (cmake/Lanes.cmake):
/// see cmake/Libraries.cmake. Only for their last lines, where they name their instances.

#include "balance/foundation/base/dual.hpp"
#ifdef BALANCE_LANES_TABLE
#include "balance/foundation/base/pack.hpp"
#include "balance/foundation/numerics/lane_block_triangular.hpp"
#endif

namespace balance {

/// Derivatives with respect to more numbers are taken so many at a time.
inline constexpr int dual_width = 8;

#ifdef BALANCE_DUALS
using EngineScalar = Dual<dual_width>;
#elif defined(BALANCE_LANES_TABLE)
using EngineScalar = Pack<native_lanes>;
#else
using EngineScalar = double;
#endif

}  // namespace balance
