#include "balance/spec/decimal_comma.hpp"

#include "balance/base/nearest.hpp"

namespace balance::specification {
namespace {

/// A comma that was meant to stand before decimals makes two entries of a number: `0,25` between brackets or braces.
/// @return what to write, if the second follows the first without a space; else empty
std::string find_decimal_comma_between(const YamlNode& first, const YamlNode& second) {
  const auto ends_in_digit = [](const std::string& text) {
    return !text.empty() && text.back() >= '0' && text.back() <= '9';
  };
  const bool adjacent = first.kind == YamlNode::Kind::scalar && second.kind == YamlNode::Kind::scalar &&
                        !first.is_quoted && !second.is_quoted && first.place.line == second.place.line &&
                        second.place.column == first.place.column + static_cast<int>(first.text.size()) + 1;
  if (!adjacent || !ends_in_digit(first.text)) return "";
  return suggest_decimal_point(first.text + "," + second.text);
}

}  // namespace

std::string find_decimal_comma_in(const YamlNode& list) {
  for (std::size_t i = 0; i + 1 < list.items.size(); ++i)
    if (std::string hint = find_decimal_comma_between(list.items[i], list.items[i + 1]); !hint.empty())
      return "if a comma is meant to begin decimals: " + hint;
  return "";
}

std::string find_decimal_comma_before(const YamlNode& map, const std::string& key) {
  for (std::size_t i = 1; i < map.keys.size(); ++i)
    if (map.keys[i].text == key && map.items[i].kind == YamlNode::Kind::null)
      return find_decimal_comma_between(map.items[i - 1], map.keys[i]);
  return "";
}

}  // namespace balance::specification
