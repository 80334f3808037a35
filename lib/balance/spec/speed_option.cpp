#include "balance/spec/speed_option.hpp"

#include "balance/spec/option_draft.hpp"
#include "balance/spec/speeds.hpp"

namespace balance {

namespace {

using namespace read;

/// An option has no free numbers.
void need_numbers(const Member& member) {
  if (member.value.is_scalar()) return;
  for (const Member& one : members(member.value, "a joint coordinate, or a mapping of such to factors"))
    if (!one.value.is_scalar()) one.value.expected("a number");
}

}  // namespace

std::vector<Speed> read_speeds(const std::string& text, const char* option, const Study& study) {
  Draft draft = draft_of(study, option);
  std::vector<Speed> speeds;
  draft.problems.guard([&] {
    need_text(text, "speeds");
    const Node root = parse_yaml(text.find('{') == 0 ? text : "{" + text + "}", draft.problems);
    for (const Member& member : named_members(Cursor(root, "", draft.problems), "a mapping of speeds", Names::single))
      draft.problems.guard([&] {
        need_numbers(member);
        speeds.push_back(value_of(read_speed(member, draft)));
      });
    if (root.items.empty()) Cursor(root, "", draft.problems).fail({.expected = "at least one speed", .found = "none"});
  });
  draft.problems.throw_all();
  return speeds;
}

}  // namespace balance
