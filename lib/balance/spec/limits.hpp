#pragma once
/// Sizes beyond which a misprint is likelier than a wish.

namespace balance {

/// Samples of one run.
inline constexpr long most_samples = 100'000'000;

/// A seed: what a number in a text surely holds.
inline constexpr long most_seed = 9'007'199'254'740'991;

/// Of a motion [s].
inline constexpr double shortest_duration = 1e-9;
inline constexpr double longest_duration = 1e9;

}  // namespace balance
