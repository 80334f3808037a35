#pragma once
/// Which figures a trade-off is between.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// A list of two or three figures, each as `minimize` has it, or {of: such a list, points: how many designs}.
FrontRequest read_front(const Cursor& at, Draft& draft);

}  // namespace balance::read
