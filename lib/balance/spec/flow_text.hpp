#pragma once
/// Values as YAML.

#include "balance/spec/node.hpp"

#include <string>

namespace balance::read {

/// The text in double quotes, on one line.
std::string double_quoted(const std::string& text);

/// The text as a scalar that stands anywhere in YAML: without blanks around it, and in quotes unless it is a number or a simple
/// expression.
std::string as_scalar(const std::string& text);

/// The node on one line, anywhere in YAML. Aliases are written out.
std::string flow_text(const Node& node);

}  // namespace balance::read
