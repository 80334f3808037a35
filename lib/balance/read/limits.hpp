#pragma once
/// Sizes beyond which a misprint is likelier than a wish.

namespace balance {

/// Samples of one run.
inline constexpr long most_samples = 100'000'000;

}  // namespace balance
