#include "balance/interface/specification/read_adaptations.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_law.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/mechanics/trajectory/adaptation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace balance::specification {

namespace {

constexpr const char* move_form = "a move {to, start, duration}, or a list of moves";

/// Names that a body, a joint or an actuator already has are not free for the slide of a counterweight.
void check_name(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  if (study::find_by_name(draft.mechanism().bodies, name) || study::find_by_name(draft.mechanism().joints, name))
    at.fail({.expected = "a counterweight with a name of its own: its slide and its motor have it, too",
             .found = fmt::format("{}, which is also a body or a joint", quote_for_message(name))});
}

int find_counterweight(const SpecCursor& at, const std::string& name, const StudyBuilder& draft) {
  const auto& attachments = draft.mechanism().attachments;
  std::vector<std::string> names;
  for (std::size_t a = 0; a < attachments.size(); ++a) {
    if (attachments[a].kind != AttachmentKind::counterweight) continue;
    if (attachments[a].name == name) return static_cast<int>(a);
    names.push_back(attachments[a].name);
  }
  if (at.problems().is_uncertain("counterweights." + name) || at.problems().is_section_invalid("counterweights"))
    throw CascadingError();
  if (names.empty()) at.fail({.expected = "a counterweight", .found = "none in the spec"});
  fail_expected_one_of(at, "a counterweight", names);
}

trajectory::CounterweightMoveOf<Expression> read_move(const SpecCursor& at, BodyId body, StudyBuilder& draft) {
  trajectory::CounterweightMoveOf<Expression> move;
  std::optional<SpecCursor> to, law, ramp, ramps;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  const bool read =
      read_fields(at, move_form,
                  {{"to", Presence::required, store_in(to)},
                   {"start", Presence::required,
                    [&](const SpecCursor& c) {
                      move.start = read_fixed_time(c, draft);
                      if (move.start < 0)
                        c.fail({.expected = "a time of the motion, 0 or later", .found = c.describe_found()});
                    }},
                   {"duration", Presence::required,
                    [&](const SpecCursor& c) {
                      move.duration = read_fixed_time(c, draft);
                      if (!(move.duration > 0))
                        c.fail({.expected = "a positive duration", .found = c.describe_found()});
                    }},
                   {"law", Presence::optional, store_in(law)},
                   {"ramp", Presence::optional, store_in(ramp)},
                   {"ramps", Presence::optional, store_in(ramps)}});
  if (!read) throw CascadingError();
  move.to = read_position(*to, draft, body);
  if (law) {
    move.law.kind = read_law(*law);
    if (move.law.kind == MotionLawKind::uniform || is_mechanism_dependent(move.law.kind))
      law->fail(
          {.expected = "a law from rest to rest that is not found for the mechanism", .found = law->describe_found()});
  }
  if (ramp && ramps) ramps->fail({.expected = "'ramp' or 'ramps'", .found = "both"});
  for (const auto& entry : {ramp, ramps})
    if (entry) read_ramps(*entry, draft, move.law);
  return move;
}

trajectory::AdaptationOf<Expression> read_adaptation(const Member& member, StudyBuilder& draft) {
  trajectory::AdaptationOf<Expression> adaptation;
  adaptation.attachment = find_counterweight(member.key, member.name, draft);
  check_name(member.key, member.name, draft);
  const auto& attachment = draft.mechanism().attachments[static_cast<std::size_t>(adaptation.attachment)];
  const auto add = [&](const SpecCursor& at) {
    adaptation.moves.push_back(read_move(at, attachment.body, draft));
    if (attachment.shape)  // a place is that of a sector's axis
      adaptation.moves.back().to +=
          Vector3Of<Expression>(attachment.shape->axis_distance * attachment.shape->rotation.col(0));
  };
  if (!member.value.is_list())
    add(member.value);
  else
    read_each(member.value.items(move_form), add);
  if (adaptation.moves.empty()) member.value.fail_expected("at least one move");
  return adaptation;
}

}  // namespace

void read_adaptations(const SpecCursor& at, StudyBuilder& draft, TrajectoryOf<Expression>& trajectory) {
  if (is_mechanism_dependent(trajectory))
    at.fail({.expected = "no 'adapt' with a law, a corridor or a momentum for which the motion is searched"});
  const std::vector<Member> members = list_members(at, "a mapping of counterweights to their moves");
  for (const Member& member : members) {
    const bool read = at.problems().collect([&] { trajectory.adaptations.push_back(read_adaptation(member, draft)); });
    if (!read || !draft.is_mechanism_valid) continue;
    at.problems().collect([&] {
      Trajectory values = trajectory::cast_scalar<double>(trajectory, [](const Expression& e) { return e.value(); });
      values.adaptations = {values.adaptations.back()};
      try {
        trajectory::model_adaptations(draft.study.mechanism, values);
      } catch (const std::invalid_argument& error) {
        member.value.fail({.expected = "moves that can be made", .found = error.what()});
      }
    });
  }
  if (members.empty()) at.fail_expected("at least one counterweight");
}

}  // namespace balance::specification
