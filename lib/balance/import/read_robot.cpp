#include "balance/import/read_robot.hpp"

#include "balance/base/nearest.hpp"
#include "balance/import/chrono.hpp"
#include "balance/import/mbse.hpp"
#include "balance/import/mjcf.hpp"
#include "balance/import/urdf.hpp"
#include "balance/import/xml_document.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::foreign {

namespace {

ForeignModel read_xml(const std::string& text, const std::string& file) {
  const auto document = parse_xml(text, file);
  const std::string& root = document->root.name;
  if (root == "robot") return read_urdf(*document);
  if (root == "mujoco") return read_mjcf(*document);
  throw SpecError({.place = place_of(document->root),
                   .message = fmt::format("expected <robot> (URDF) or <mujoco> (MJCF), found <{}>", root)});
}

ForeignModel read_yaml(const std::string& text, const std::string& file) {
  specification::SpecErrorCollector problems(file);
  ForeignModel robot;
  try {
    const specification::YamlNode root = specification::parse_yaml(text, problems);
    const specification::SpecCursor top(root, "", problems);
    const auto has = [&](const char* key) {
      return std::any_of(root.keys.begin(), root.keys.end(),
                         [key](const specification::YamlNode& one) { return one.text == key; });
    };
    if (has("planar_bodies"))
      robot = read_mbse(top, file);
    else if (has("model") || has("chrono-version"))
      robot = read_chrono(top, file);
    else if (has("space") && has("joints"))
      top.fail({.expected = "a foreign file", .found = "a spec, which needs no import"});
    else
      top.fail_expected("URDF or MJCF (XML), MBSE ('points' and 'planar_bodies') or Chrono ('model')");
  } catch (const specification::ReadError& problem) {
    problems.add(problem);
  } catch (const specification::CascadingError&) {
  }
  problems.throw_if_any();
  return robot;
}

}  // namespace

ForeignModel read_foreign_model(const std::string& text, const std::string& file) {
  const std::size_t begin = text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0;
  const std::size_t first = text.find_first_not_of(" \t\r\n", begin);
  const bool xml = first != std::string::npos && text[first] == '<';
  ForeignModel robot = xml ? read_xml(text, file) : read_yaml(text, file);
  for (const std::size_t count : {robot.bodies.size(), robot.joints.size()})
    if (count > max_model_elements)
      throw SpecError({.place = {file, 1, 1, ""},
                       .message = fmt::format("expected at most {} bodies and as many joints, found {}",
                                              max_model_elements, count)});
  return robot;
}

}  // namespace balance::foreign
