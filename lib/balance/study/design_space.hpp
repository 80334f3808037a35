#pragma once
/// A spec with its free numbers still free.

#include "balance/study/study.hpp"

#include <functional>

namespace balance {

struct DesignSpace {
  Study start;  ///< at the start values, complete and validated
  /// The same study with other values of start.free_numbers (SI, in that order). Not checked for physical sense (a mass may
  /// be zero); everything else is as when the spec was read. Pure: may be called in any order.
  std::function<Study(const VectorX& x)> at;
};

}  // namespace balance
