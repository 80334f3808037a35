#pragma once
/// Text in a table of comma-separated values.

#include <string>

namespace balance {

/// A text as one field: quoted where a comma or a quote would end it.
std::string csv_field(const std::string& text);

}  // namespace balance
