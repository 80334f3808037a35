#pragma once
/// Text as XML holds it.

#include <string>
#include <string_view>

namespace balance {

/// Fit for an attribute or an element: marks escaped, line ends kept, what is not UTF-8 or no character of XML 1.0
/// replaced by U+FFFD.
std::string escape_xml(std::string_view text);

}  // namespace balance
