#pragma once
/// Samples as text: base64 of little-endian floating-point numbers.

#include "balance/base/types.hpp"

#include <string>
#include <string_view>

namespace balance {

/// RFC 4648 with padding.
std::string base64(std::string_view bytes);

/// Four bytes a number, seven digits: what a picture needs.
std::string base64_floats(const Samples& by_row);
/// The same column after column.
std::string base64_float_columns(const Samples& samples);
/// Eight bytes a number.
std::string base64_doubles(const VectorX& numbers);

}  // namespace balance
