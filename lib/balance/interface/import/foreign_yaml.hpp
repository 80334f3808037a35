#pragma once
/// Plain values of foreign YAML: numbers without units or expressions.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <initializer_list>
#include <map>
#include <string>
#include <vector>

namespace balance::foreign {

/// A finite number; fails otherwise.
double read_plain_number(const specification::SpecCursor& at);
/// A list with as many of them as one of the counts says.
std::vector<double> plain_numbers(const specification::SpecCursor& at, const std::string& what,
                                  std::initializer_list<std::size_t> counts);
Vector3 plain_vector(const specification::SpecCursor& at);
/// The same, normalised; fails if it has no length.
Vector3 plain_direction(const specification::SpecCursor& at);
/// `true` or `false`.
bool read_bool(const specification::SpecCursor& at);

/// The entries of a mapping by their keys.
std::map<std::string, specification::SpecCursor> read_mapping(const specification::SpecCursor& map,
                                                              const std::string& what);

}  // namespace balance::foreign
