#pragma once
/// What a spec says about its numbers: from it formulas know which parameter stands where, and what the numbers are made of.

#include "balance/study/recording.hpp"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace balance {

struct ParameterText {
  std::string name;
  std::string text;  ///< a number or an expression of other parameters; of a free one its start value
};

/// Nothing in it: a mechanism that no spec says.
struct SpecNumberTexts {
  std::vector<ParameterText> parameters;       ///< in the document's order
  std::map<std::string, std::string> numbers;  ///< scalars by key path, `bodies.link1.com[0]`
  std::shared_ptr<const Recording> recording;  ///< null: every number is what it is
};

}  // namespace balance
