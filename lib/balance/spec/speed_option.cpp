#include "balance/spec/speed_option.hpp"

#include "balance/spec/option_draft.hpp"
#include "balance/spec/speeds.hpp"

namespace balance {

namespace {

using namespace specification;

/// An option has no free numbers.
void require_numbers(const Member& member) {
  if (member.value.is_scalar()) return;
  for (const Member& one : list_members(member.value, "a joint coordinate, or a mapping of such to factors"))
    if (!one.value.is_scalar()) one.value.fail_expected("a number");
}

}  // namespace

std::vector<GeneralisedSpeed> read_speeds(const std::string& text, const char* option, const Study& study) {
  StudyBuilder draft = make_option_builder(study, option);
  std::vector<GeneralisedSpeed> speeds;
  draft.problems.collect([&] {
    require_text(text, "speeds");
    const YamlNode root = parse_yaml(text.find('{') == 0 ? text : "{" + text + "}", draft.problems);
    for (const Member& member :
         list_named_members(SpecCursor(root, "", draft.problems), "a mapping of speeds", NameForm::simple))
      draft.problems.collect([&] {
        require_numbers(member);
        speeds.push_back(value_of(read_speed(member, draft)));
      });
    if (root.items.empty())
      SpecCursor(root, "", draft.problems).fail({.expected = "at least one speed", .found = "none"});
  });
  draft.problems.throw_if_any();
  return speeds;
}

}  // namespace balance
