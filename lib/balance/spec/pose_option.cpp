// Poses and rates from the command line.

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/model/conversion.hpp"
#include "balance/spec/pose.hpp"
#include "balance/spec/read_spec.hpp"

#include <algorithm>

namespace balance {

namespace {

using namespace read;

/// `A1=0.3, J.slide=2` as the YAML that it is short for. Only a comma or the end may follow a value.
std::string as_mapping(const std::string& text) {
  std::string yaml = "{";
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string part = text.substr(at, comma - at);
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == part.size())
      throw Problem({}, "",
                    {.expected = "coordinates with their values such as A1=0.3,A2=0.5", .found = in_quotes(text)});
    yaml += (at == 0 ? "" : ", ") + part.substr(0, equals) + ": " + part.substr(equals + 1);
    at = comma + 1;
  }
  return yaml + "}";
}

/// A draft of the study with its units, whose complaints are about an option.
Draft draft_of(const Study& study, const char* option) {
  Draft draft(study.spec_file);
  draft.mechanism() = converted<Expression>(study.mechanism, [](double x) { return Expression(x); });
  draft.units.length = study.units.length;
  draft.units.angle = study.units.angle;
  draft.problems = Problems::of_option(option);
  return draft;
}

std::vector<CoordinateValue> present_values(const std::vector<CoordinateValueOf<Expression>>& read) {
  std::vector<CoordinateValue> values;
  for (const auto& one : read) values.push_back({one.coordinate, one.value.value()});
  return values;
}

Vector3 present_vector(const Vector3Of<Expression>& v) { return {v[0].value(), v[1].value(), v[2].value()}; }

void need_text(const std::string& text, const char* what) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw Problem({}, "", {.expected = what, .found = "an empty text"});
}

}  // namespace

PoseTarget read_pose(const std::string& text, const Study& study) {
  Draft draft = draft_of(study, "--at");
  PoseTarget pose;
  draft.problems.guard([&] {
    need_text(text, "a pose");
    const bool short_form = text.find('=') != std::string::npos;
    const std::string joints = short_form ? "{joints: " + as_mapping(text) + "}" : text;
    const Node root = parse_yaml(short_form || text.find('{') == 0 ? joints : "{" + joints + "}", draft.problems);
    const auto read = read::read_pose(Cursor(root, "", draft.problems), draft);
    pose.joints = present_values(read.joints);
    if (read.tool) pose.tool = present_vector(*read.tool);
    if (read.angle) pose.angle = read.angle->value();
    if (read.com) pose.com = present_vector(*read.com);
    if (read.orientation) {
      pose.orientation.emplace();
      for (int k = 0; k < 3; ++k)
        pose.orientation->col(k) = present_vector(Vector3Of<Expression>(read.orientation->col(k)));
    }
  });
  draft.problems.throw_all();
  return pose;
}

std::vector<CoordinateValue> read_rates(const std::string& text, const char* option, const Study& study) {
  Draft draft = draft_of(study, option);
  std::vector<CoordinateValue> rates;
  draft.problems.guard([&] {
    need_text(text, "rates of coordinates");
    const Node root = parse_yaml(as_mapping(text), draft.problems);
    rates = present_values(read_coordinate_values(Cursor(root, "", draft.problems), draft));
  });
  draft.problems.throw_all();
  return rates;
}

}  // namespace balance
