#pragma once
/// Trial numbers for which an expression of the spec has no value (the root of something negative) make no mechanism. Private to
/// study.

#include "balance/study/design_space.hpp"

namespace balance {

/// The study with these free numbers.
/// @throws SpecError if a number of its mechanism is not finite
Study finite_study(const std::function<Study(const VectorX& x)>& at, const VectorX& x);

}  // namespace balance
