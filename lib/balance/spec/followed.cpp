// What discs and couplings follow: a joint coordinate, or several with a ratio each.

#include "balance/base/nearest.hpp"
#include "balance/spec/draft.hpp"

#include <fmt/format.h>

#include <set>

namespace balance::read {

FollowedOf<Expression> read_followed(const Cursor& at, Draft& draft, const Dimension& follower) {
  if (!at.is_map()) return read_coordinate(at, draft);
  std::vector<CoordinateTermOf<Expression>> terms;
  std::set<int> known;
  bool right = true;
  for (const Member& member : members(at, "a joint coordinate, or a mapping of joint coordinates to ratios")) {
    const auto read = [&] {
      const CoordinateId coordinate = find_coordinate(member.key, member.name, draft);
      const CoordinateKind kind = draft.mechanism().coordinates[static_cast<std::size_t>(coordinate)].kind;
      const Expression ratio = read_number(member.value, draft, follower / dimension_of(kind));
      if (is_stuck_at_zero(member.value, ratio, draft))
        member.value.fail({.expected = "a ratio other than 0 (what does not count is not followed)", .found = "0"});
      if (known.insert(coordinate).second) terms.push_back({coordinate, ratio});
    };
    right = draft.problems.guard(read) && right;
  }
  if (!right) throw Consequence();
  if (terms.empty()) at.fail({.expected = "at least one joint coordinate", .found = at.found()});
  return FollowedOf<Expression>(std::move(terms));
}

bool follows_several(const Cursor& map) {
  if (!map.is_map()) return false;
  const Node& node = map.node();
  for (std::size_t k = 0; k < node.keys.size(); ++k)
    if (node.keys[k].text == "follows") return node.items[k].kind == Node::Kind::map;
  return false;
}

}  // namespace balance::read
