// What discs and couplings follow: a joint coordinate, or several with a ratio each.

#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <fmt/format.h>

#include <set>

namespace balance::specification {

CoordinateCombinationOf<Expression> read_followed(const SpecCursor& at, StudyBuilder& draft,
                                                  const Dimension& follower) {
  if (!at.is_map()) return read_coordinate(at, draft);
  std::vector<CoordinateTermOf<Expression>> terms;
  std::set<int> known;
  bool right = true;
  for (const Member& member : list_members(at, "a joint coordinate, or a mapping of joint coordinates to ratios")) {
    const auto read = [&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      const Expression ratio = read_number(member.value, draft, follower / dimension_of(kind));
      if (is_fixed_zero(member.value, ratio, draft))
        member.value.fail({.expected = "a ratio other than 0 (what does not count is not followed)", .found = "0"});
      if (known.insert(coordinate).second) terms.push_back({coordinate, ratio});
    };
    right = draft.problems.collect(read) && right;
  }
  if (!right) throw CascadingError();
  if (terms.empty()) at.fail({.expected = "at least one joint coordinate", .found = at.describe_found()});
  return CoordinateCombinationOf<Expression>(std::move(terms));
}

bool has_several_leaders(const SpecCursor& map) {
  if (!map.is_map()) return false;
  const YamlNode& node = map.node();
  for (std::size_t k = 0; k < node.keys.size(); ++k)
    if (node.keys[k].text == "follows") return node.items[k].kind == YamlNode::Kind::map;
  return false;
}

}  // namespace balance::specification
