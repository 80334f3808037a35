// Poses and rates from the command line.

#include "balance/interface/specification/read_options.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/free_number.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/read_pose.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/read_speeds.hpp"

#include <algorithm>

namespace balance::specification {

StudyBuilder make_option_builder(const Study& study, const char* option) {
  StudyBuilder draft(study.spec_file);
  draft.study = study;
  draft.mechanism() = model::convert_mechanism<Expression>(study.mechanism, [](double x) { return Expression(x); });
  static_cast<model::DisplayUnits&>(draft.units) = study.mechanism.units;
  if (!study.spec_text.empty()) {  // of a mechanism made without a spec
    const YamlNode root = parse_yaml(study.spec_text, draft.problems);
    if (const YamlNode* section = find_entry(root, "parameters"))
      draft.parameters = SpecParameters(SpecCursor(*section, "parameters", draft.problems), study.overrides,
                                        list_added_element_parameters(root), *draft.recording, draft.problems);
  }
  draft.problems = SpecErrorCollector::of_option(option);
  return draft;
}

namespace {

/// Converts `A1=0.3, J.slide=2` to YAML. Only a comma or the end may follow a value.
std::string to_yaml_mapping(const std::string& text) {
  std::string yaml = "{";
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string entry = text.substr(at, comma - at);
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size())
      throw ReadError({}, "",
                      {.expected = "coordinates with their values such as A1=0.3,A2=0.5",
                       .found = quote_for_message(text),
                       .hint = suggest_decimal_point(text)});
    yaml += (at == 0 ? "" : ", ") + entry.substr(0, equals) + ": " + entry.substr(equals + 1);
    at = comma + 1;
  }
  return yaml + "}";
}

}  // namespace

trajectory::PoseTarget read_pose(const std::string& text, const Study& study) {
  StudyBuilder draft = make_option_builder(study, "--at");
  TrajectoryOf<Expression> trajectory;  // poses are converted as part of a trajectory
  draft.problems.collect([&] {
    require_text(text, "a pose");
    const bool short_form = text.find('=') != std::string::npos;
    const std::string joints = short_form ? "{joints: " + to_yaml_mapping(text) + "}" : text;
    const YamlNode root = parse_yaml(short_form || text.find('{') == 0 ? joints : "{" + joints + "}", draft.problems);
    trajectory.from = specification::read_pose(SpecCursor(root, "", draft.problems), draft);
  });
  draft.problems.throw_if_any();
  return trajectory::cast_scalar<double>(trajectory, [](const Expression& x) { return x.value(); }).from;
}

std::vector<CoordinateValue> read_coordinate_rates(const std::string& text, const char* option, const Study& study) {
  StudyBuilder draft = make_option_builder(study, option);
  std::vector<CoordinateValue> rates;
  draft.problems.collect([&] {
    require_text(text, "rates of coordinates");
    const YamlNode root = parse_yaml(to_yaml_mapping(text), draft.problems);
    for (const auto& [coordinate, rate] : read_coordinate_values(SpecCursor(root, "", draft.problems), draft))
      rates.push_back({coordinate, rate.value()});
  });
  draft.problems.throw_if_any();
  return rates;
}

namespace {

/// An option must not have free numbers.
void require_numbers(const Member& member) {
  if (member.value.is_scalar()) return;
  for (const Member& one : list_members(member.value, "a joint coordinate, or a mapping of these to factors"))
    if (!one.value.is_scalar()) one.value.fail_expected("a number");
}

}  // namespace

std::vector<model::GeneralisedSpeed> read_speeds(const std::string& text, const char* option, SpeedUse use,
                                                 const Study& study) {
  StudyBuilder draft = make_option_builder(study, option);
  std::vector<model::GeneralisedSpeed> speeds;
  draft.problems.collect([&] {
    require_text(text, "speeds");
    const YamlNode root = parse_yaml(text.find('{') == 0 ? text : "{" + text + "}", draft.problems);
    const SpecCursor all(root, "", draft.problems);
    for (const YamlNode& key : root.keys)
      if (key.text.find(':') != std::string::npos)
        all.fail({.expected = "a space behind every colon, as in 'v: tool.u'", .found = quote_for_message(text)});
    for (const Member& member : list_named_members(all, "a mapping of speeds", NameForm::simple))
      draft.problems.collect([&] {
        require_numbers(member);
        speeds.push_back(to_numbers(read_speed(member, use, draft)));
      });
    if (root.items.empty())
      SpecCursor(root, "", draft.problems).fail({.expected = "at least one speed", .found = "none"});
  });
  draft.problems.throw_if_any();
  return speeds;
}

}  // namespace balance::specification
