#pragma once
/// Templates for new specs, from configs/starters. The build embeds their text in the program.

#include <string_view>
#include <vector>

namespace balance::app {

struct Starter {
  std::string_view kind;
  std::string_view text;

  /// Description: the first line of the text, a comment.
  std::string_view summary() const {
    const std::string_view line = text.substr(0, text.find('\n'));
    return line.substr(line.find_first_not_of("# "));
  }
};

const std::vector<Starter>& starters();

}  // namespace balance::app
