#pragma once
/// The free numbers of a spec while it is being read.

#include "balance/expression/expression.hpp"
#include "balance/spec/node.hpp"
#include "balance/study/study.hpp"

namespace balance::specification {

/// A free number, the mapping that says so, and the input that stands for it. Its span is not known yet.
struct FreeNumberEntry {
  const YamlNode* node = nullptr;
  FreeNumber number;
  Expression input;
  bool is_list_item = false;  ///< one of a list that the mapping stands for
};

}  // namespace balance::specification
