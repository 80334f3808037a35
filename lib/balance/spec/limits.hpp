#pragma once
/// Sizes beyond which a misprint is likelier than a wish.

namespace balance {

/// A seed: what a number in a text surely holds.
inline constexpr long max_seed = 9'007'199'254'740'991;

}  // namespace balance
