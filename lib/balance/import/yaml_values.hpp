#pragma once
/// Plain values of foreign YAML: numbers without units or expressions.

#include "balance/base/types.hpp"
#include "balance/spec/cursor.hpp"

#include <initializer_list>
#include <map>
#include <string>
#include <vector>

namespace balance::foreign {

/// A finite number; fails otherwise.
double plain_number(const read::Cursor& at);
/// A list with as many of them as one of the counts says.
std::vector<double> plain_numbers(const read::Cursor& at, const std::string& what,
                                  std::initializer_list<std::size_t> counts);
Vector3 plain_vector(const read::Cursor& at);
/// The same, normalised; fails if it has no length.
Vector3 plain_direction(const read::Cursor& at);
/// `true` or `false`.
bool truth(const read::Cursor& at);

/// The entries of a mapping by their keys.
std::map<std::string, read::Cursor> entries(const read::Cursor& map, const std::string& what);

}  // namespace balance::foreign
