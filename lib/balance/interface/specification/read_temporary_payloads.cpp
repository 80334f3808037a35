#include "balance/interface/specification/read_temporary_payloads.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace balance::specification {

namespace {

SourceLocation place_of(const SpecCursor& at) {
  const NodeLocation& place = at.node().place;
  return {at.problems().file_of(place), place.line, place.column, at.path()};
}

/// Inputs of the recording that designs, load cases and tolerances change.
std::set<int> variable_inputs(const StudyBuilder& draft) {
  std::set<int> inputs;
  const study::Recording& recording = *draft.recording;
  for (const auto* free : {&draft.parameters.free_numbers(), &draft.free_numbers})
    for (const FreeNumberEntry& one : *free) inputs.insert(recording.input_index(one.input));
  for (const study::NamedExpression& parameter : recording.parameters)
    for (const auto* names : {&draft.load_names, &draft.tolerance_names})
      if (parameter.is_plain && !parameter.value.is_constant() &&
          (names->contains(parameter.name) || names->contains("parameters." + parameter.name)))
        inputs.insert(recording.input_index(parameter.value));
  return inputs;
}

bool has_dependence(const expression::ExpressionGraph& graph, const Expression& number, const std::set<int>& inputs) {
  if (number.is_constant() || inputs.empty()) return false;
  std::vector<bool> reachable(static_cast<std::size_t>(number.node()) + 1, false);
  reachable.back() = true;
  for (std::size_t n = reachable.size(); n-- > 0;) {  // arguments are earlier nodes
    if (!reachable[n]) continue;
    const expression::ExpressionNode& node = graph.nodes()[n];
    if (node.operation == expression::Operation::input && inputs.contains(node.input)) return true;
    for (const int argument : node.arguments)
      if (argument >= 0) reachable[static_cast<std::size_t>(argument)] = true;
  }
  return false;
}

}  // namespace

double read_fixed_time(const SpecCursor& at, StudyBuilder& draft) {
  const std::string what = "a time of the trajectory, a number or an expression";
  if (!at.is_scalar()) at.fail_expected(what);
  const Expression time = draft.parameters.evaluate(at) * draft.units.factor(dimension::time);
  if (is_variable_number(time, draft))
    at.fail({.expected = what + " of numbers that are neither free nor named under 'for' or 'tolerances'",
             .found = quote_for_message(at.node().text)});
  return time.value();
}

bool is_variable_number(const Expression& number, const StudyBuilder& draft) {
  return has_dependence(draft.recording->graph, number, variable_inputs(draft));
}

std::vector<Field> presence_fields(const SpecCursor& at, AttachmentKind kind, PresenceKeys& keys) {
  std::vector<Field> fields;
  for (auto& [name, slot] : {std::pair{"from", &keys.from}, std::pair{"until", &keys.until}}) {
    if (kind == AttachmentKind::payload)
      fields.push_back({name, Presence::optional, [slot = slot](const SpecCursor& c) { *slot = c; }});
    else if (at.has_entry(name))
      fields.push_back({name, Presence::optional, [name = name](const SpecCursor& c) {
                          c.fail({.expected = fmt::format("no '{}': counterweights are always there, payloads may come "
                                                          "and go",
                                                          name),
                                  .found = c.describe_found()});
                        }});
  }
  return fields;
}

void read_presence(const PresenceKeys& keys, StudyBuilder& draft, model::AttachmentOf<Expression>& attachment) {
  if (!keys.given()) return;
  const bool read = draft.problems.collect([&] {
    if (keys.from) attachment.from = read_fixed_time(*keys.from, draft);
  });
  draft.problems.collect([&] {
    if (!keys.until) return;
    attachment.until = read_fixed_time(*keys.until, draft);
    if (read && !(attachment.from < attachment.until))
      keys.until->fail({.expected = keys.from ? "a time later than 'from'" : "a time",
                        .found = fmt::format("{:.6g} s", attachment.until)});
    if (attachment.until <= 0)
      keys.until->fail({.expected = "a time later than the start of the motion, 0 s",
                        .found = fmt::format("{:.6g} s", attachment.until)});
  });
  const SpecCursor& entry = keys.from ? *keys.from : *keys.until;
  draft.study.temporary_payloads.push_back({attachment.name, place_of(entry)});
  draft.payload_activations.emplace_back(entry, attachment.from);
}

void require_permanent_payloads(const SpecCursor& at, const std::string& expected, const StudyBuilder& draft) {
  const auto& payloads = draft.study.temporary_payloads;
  if (payloads.empty()) return;
  at.fail({.expected = fmt::format("{}, because payload {} is taken up or set down on the way", expected,
                                   quote_for_message(payloads.front().name)),
           .found = at.describe_found()});
}

void check_temporary_payloads(const MotionKeys& keys, const StudyBuilder& draft,
                              const TrajectoryOf<Expression>& trajectory) {
  if (draft.study.temporary_payloads.empty()) return;
  if (trajectory.drive == DriveKind::com && keys.drive)
    require_permanent_payloads(*keys.drive, "'joints' or 'tool': the centre of mass would jump", draft);
  if (is_mechanism_dependent(trajectory.law.kind) && keys.law)
    require_permanent_payloads(*keys.law, "a law that is not searched for", draft);
  if (is_variable_number(trajectory.duration, draft))
    require_permanent_payloads(keys.at, "a 'duration' that no free number, load case or tolerance changes", draft);
  if (keys.limits) require_permanent_payloads(*keys.limits, "no 'limits'", draft);
  if (is_mechanism_dependent(trajectory))
    require_permanent_payloads(keys.at, "a motion that does not depend on masses", draft);
  for (const auto& [pose, place] : {std::pair{&trajectory.from, &keys.from}, std::pair{&trajectory.to, &keys.to}})
    if (pose->com) require_permanent_payloads(*place, "a pose by 'joints' or 'tool'", draft);
}

void check_presence(StudyBuilder& draft) {
  const auto& trajectories = draft.trajectories();
  if (trajectories.empty()) return;
  double max_duration = 0;
  for (const auto& trajectory : trajectories) {
    const auto* table = std::get_if<trajectory::TablePathOf<Expression>>(&trajectory.path);
    max_duration = std::max(max_duration, table != nullptr && !table->time.empty()
                                              ? table->time.back().value() - table->time.front().value()
                                              : trajectory.duration.value());
  }
  for (const auto& [at, from] : draft.payload_activations)
    draft.problems.collect([&, &at = at, &from = from] {
      if (from >= max_duration)
        at.fail({.expected = fmt::format("a time before the longest trajectory's end, {:.6g} s: the payload would "
                                         "never be there",
                                         max_duration),
                 .found = fmt::format("{:.6g} s", from)});
    });
}

}  // namespace balance::specification
