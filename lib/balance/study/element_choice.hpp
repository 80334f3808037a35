#pragma once
/// Which of the elements that a spec offers a design may keep.

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

/// An element that a design may leave out.
struct OptionalElementText {
  std::string name;
  std::size_t begin = 0,
              end = 0;  ///< bytes of spec_text without which the spec is one without it; begin = end: there are none
};

/// Elements of one section, of which a design keeps only so many.
struct CardinalityRequest {
  std::string section;  ///< "counterweights", "discs" or "springs"
  std::vector<OptionalElementText> elements;
  bool is_whole_section = false;  ///< of the section, unless they cannot vanish; else those that the spec names
  int max_count = -1;             ///< that are kept; −1: as few as will do
};

}  // namespace balance
