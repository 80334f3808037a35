#include "balance/interface/import/foreign_yaml.hpp"

#include "balance/interface/import/xml_document.hpp"

#include <algorithm>

namespace balance::foreign {

double read_plain_number(const specification::SpecCursor& at) {
  const auto values = at.is_scalar() ? parse_number_list(at.node().text) : std::nullopt;
  if (!values || values->size() != 1) at.fail_expected("a number");
  return values->front();
}

std::vector<double> plain_numbers(const specification::SpecCursor& at, const std::string& what,
                                  std::initializer_list<std::size_t> counts) {
  std::vector<double> values;
  const auto items = at.items(what);
  if (std::find(counts.begin(), counts.end(), items.size()) == counts.end()) at.fail_expected(what);
  for (const specification::SpecCursor& item : items) values.push_back(read_plain_number(item));
  return values;
}

Vector3 plain_vector(const specification::SpecCursor& at) {
  const auto v = plain_numbers(at, "[x, y, z]", {3});
  return {v[0], v[1], v[2]};
}

Vector3 plain_direction(const specification::SpecCursor& at) {
  const Vector3 v = plain_vector(at);
  if (!(v.norm() > 1e-100 && v.norm() < 1e100)) at.fail_expected("a direction, [x, y, z] that is not zero");
  return v.normalized();
}

bool read_bool(const specification::SpecCursor& at) {
  return at.read_choice("a truth value", {"true", "false", "True", "False"}) % 2 == 0;
}

std::map<std::string, specification::SpecCursor> read_mapping(const specification::SpecCursor& map,
                                                              const std::string& what) {
  std::map<std::string, specification::SpecCursor> entries;
  for (const specification::Member& member : specification::list_members(map, what))
    entries.emplace(member.name, member.value);
  return entries;
}

}  // namespace balance::foreign
