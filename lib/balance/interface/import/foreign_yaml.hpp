#pragma once
/// Plain values of foreign YAML: numbers without units or expressions.

#include "balance/foundation/base/types.hpp"
#include "balance/interface/specification/spec_cursor.hpp"

#include <initializer_list>
#include <map>
#include <string>
#include <vector>

namespace balance::foreign {

/// Reads a finite number; fails otherwise.
double read_plain_number(const specification::SpecCursor& at);
/// Reads a list of as many numbers as one of `counts`.
std::vector<double> plain_numbers(const specification::SpecCursor& at, const std::string& what,
                                  std::initializer_list<std::size_t> counts);
Vector3 plain_vector(const specification::SpecCursor& at);
/// The same, normalised; fails for a zero vector.
Vector3 plain_direction(const specification::SpecCursor& at);
/// Reads `true` or `false`, also capitalised.
bool read_bool(const specification::SpecCursor& at);

/// Entries of a mapping by key.
std::map<std::string, specification::SpecCursor> read_mapping(const specification::SpecCursor& map,
                                                              const std::string& what);

}  // namespace balance::foreign
