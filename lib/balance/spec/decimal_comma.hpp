#pragma once
/// A comma that was meant to begin decimals makes two entries of one number, between brackets and between braces.

#include "balance/spec/node.hpp"

#include <string>

namespace balance::specification {

/// A hint on the first two entries of a list that may be one number, `[0,25, 0]`; else empty.
std::string find_decimal_comma_in(const YamlNode& list);

/// A hint on a key of a mapping that may be the decimals of the value before it, `{m: 1,5}`; else empty.
std::string find_decimal_comma_before(const YamlNode& map, const std::string& key);

}  // namespace balance::specification
