#include "balance/spec/landmark.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

/// Index of the element of that name; −1: there is none.
template <class Elements>
int index_of(const Elements& elements, const std::string& name) {
  const auto found = std::find_if(elements.begin(), elements.end(), [&](const auto& e) { return e.name == name; });
  return found == elements.end() ? -1 : static_cast<int>(found - elements.begin());
}

}  // namespace

Landmark read_landmark(const SpecCursor& at, const StudyBuilder& draft) {
  const std::string& text = at.read_word("a point, body.point or a counterweight's name");
  const Mechanism& mechanism = draft.study.mechanism;
  using Kind = Landmark::Kind;
  if (text.find('.') == std::string::npos) {
    if (const int found = index_of(mechanism.attachments, text); found >= 0) return {Kind::attachment, 0, found};
    if (const int found = index_of(mechanism.discs, text); found >= 0) return {Kind::disc, 0, found};
    const SpecErrorCollector& problems = at.problems();
    for (const char* section : {"counterweights", "payloads", "discs"})
      if (problems.is_uncertain(fmt::format("{}.{}", section, text))) throw CascadingError();
    if (index_of(mechanism.bodies, text) < 0) {
      std::vector<std::string> names;
      for (const Attachment& attachment : mechanism.attachments) names.push_back(attachment.name);
      for (const Disc& disc : mechanism.discs) names.push_back(disc.name);
      at.fail({.expected = "body.point, or the name of a counterweight, payload or disc",
               .found = quote_for_message(text),
               .hint = format_nearest_name(text, names)});
    }
  }
  const std::size_t dot = text.find('.');
  const std::string name = dot == std::string::npos ? "" : text.substr(dot + 1);
  const BodyId body = index_of(mechanism.bodies, text.substr(0, dot));
  const int point = body < 0 ? -1 : index_of(mechanism.bodies[static_cast<std::size_t>(body)].points, name);
  if (point >= 0) return {Kind::point, body, point};
  if (body > 0 && name == "com") return {Kind::com, body, 0};
  return {Kind::origin, read_reference(at, draft).body, 0};
}

}  // namespace balance::specification
