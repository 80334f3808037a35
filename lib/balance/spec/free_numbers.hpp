#pragma once
/// The free numbers of a spec while it is being read.

#include "balance/expression/expression.hpp"
#include "balance/spec/node.hpp"
#include "balance/study/study.hpp"

namespace balance::read {

/// A free number, the mapping that says so, and the input that stands for it. Its span is not known yet.
struct FoundFreeNumber {
  const Node* node = nullptr;
  FreeNumber number;
  Expression input;
  bool listed = false;  ///< one of a list that the mapping stands for
};

}  // namespace balance::read
