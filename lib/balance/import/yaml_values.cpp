#include "balance/import/yaml_values.hpp"

#include "balance/import/element_reader.hpp"

#include <algorithm>

namespace balance::foreign {

double plain_number(const read::Cursor& at) {
  const auto values = at.is_scalar() ? numbers_in(at.node().text) : std::nullopt;
  if (!values || values->size() != 1) at.expected("a number");
  return values->front();
}

std::vector<double> plain_numbers(const read::Cursor& at, const std::string& what,
                                  std::initializer_list<std::size_t> counts) {
  std::vector<double> values;
  const auto items = at.items(what);
  if (std::find(counts.begin(), counts.end(), items.size()) == counts.end()) at.expected(what);
  for (const read::Cursor& item : items) values.push_back(plain_number(item));
  return values;
}

Vector3 plain_vector(const read::Cursor& at) {
  const auto v = plain_numbers(at, "[x, y, z]", {3});
  return {v[0], v[1], v[2]};
}

Vector3 plain_direction(const read::Cursor& at) {
  const Vector3 v = plain_vector(at);
  if (!(v.norm() > 1e-100 && v.norm() < 1e100)) at.expected("a direction, [x, y, z] that is not zero");
  return v.normalized();
}

bool truth(const read::Cursor& at) { return at.choice("a truth value", {"true", "false", "True", "False"}) % 2 == 0; }

std::map<std::string, read::Cursor> entries(const read::Cursor& map, const std::string& what) {
  std::map<std::string, read::Cursor> found;
  for (const read::Member& member : read::members(map, what)) found.emplace(member.name, member.value);
  return found;
}

}  // namespace balance::foreign
