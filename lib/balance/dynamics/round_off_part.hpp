#pragma once
/// How small is nothing but round-off.

namespace balance {

/// Of the terms' size; a sum of a hundred terms, each of which has gone through a few rotations.
inline constexpr double round_off_factor = 256 * 2.220446049250313e-16;

}  // namespace balance
