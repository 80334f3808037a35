#pragma once
/// Where names stand in a list, for thousands of questions. Private to spec.

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

namespace balance::specification {

class NameIndex {
 public:
  /// @param list of things with a name, not always the same from one call to the next
  /// @return the place of the first of that name; −1 if there is none
  template <class Named>
  int find(const std::vector<Named>& list, const std::string& name) {
    if (const int at = find_cached(name); at >= 0 && at < static_cast<int>(list.size()) && list[at].name == name)
      return at;
    places_.clear();
    for (std::size_t i = 0; i < list.size(); ++i) places_.emplace(list[i].name, static_cast<int>(i));
    return find_cached(name);
  }

 private:
  int find_cached(const std::string& name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? -1 : found->second;
  }

  std::unordered_map<std::string, int> places_;
};

}  // namespace balance::specification
