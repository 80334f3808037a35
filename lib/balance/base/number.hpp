#pragma once
/// The scalar that a source of templates is compiled for. The same sources make the engine over doubles (`balance::core`) and over
/// numbers with derivatives (`balance::gradients`, with BALANCE_DUALS): see cmake/Libraries.cmake. Only for their last lines, where
/// they name their instances.

#include "balance/base/dual.hpp"

namespace balance {

/// Derivatives with respect to more numbers are taken so many at a time.
inline constexpr int dual_width = 8;

#ifdef BALANCE_DUALS
using Number = Dual<dual_width>;
#else
using Number = double;
#endif

}  // namespace balance
