#pragma once
/// Values as YAML.

#include "balance/spec/node.hpp"

#include <string>

namespace balance::specification {

/// The text in double quotes, on one line.
std::string quote_yaml(const std::string& text);

/// The text as a scalar that stands anywhere in YAML: without blanks around it, and in quotes unless it is a number or a simple
/// expression.
std::string format_scalar(const std::string& text);

/// The node on one line, anywhere in YAML. Aliases are written out.
std::string format_flow(const YamlNode& node);

}  // namespace balance::specification
