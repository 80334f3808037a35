#include "balance/mechanics/model/landmark.hpp"

#include <algorithm>

namespace balance::model {

namespace {

/// Index of the element with that name; −1 if there is none.
template <class Elements>
int index_of(const Elements& elements, const std::string& name) {
  const auto match = std::find_if(elements.begin(), elements.end(), [&](const auto& e) { return e.name == name; });
  return match == elements.end() ? -1 : static_cast<int>(match - elements.begin());
}

}  // namespace

BodyPoint locate_landmark(const Mechanism& mechanism, const Landmark& landmark) {
  const auto index = static_cast<std::size_t>(landmark.index), body = static_cast<std::size_t>(landmark.body);
  switch (landmark.kind) {
    case Landmark::Kind::origin: break;
    case Landmark::Kind::com: return {landmark.body, mechanism.bodies[body].com};
    case Landmark::Kind::point: return {landmark.body, mechanism.bodies[body].points[index].position};
    case Landmark::Kind::attachment: return {mechanism.attachments[index].body, mechanism.attachments[index].position};
    case Landmark::Kind::disc: return {mechanism.discs[index].body, mechanism.discs[index].position};
  }
  return {landmark.body, Vector3::Zero()};
}

std::optional<Landmark> find_landmark(const Mechanism& mechanism, const std::string& name) {
  using Kind = Landmark::Kind;
  if (const int index = index_of(mechanism.attachments, name); index >= 0) return Landmark{Kind::attachment, 0, index};
  if (const int index = index_of(mechanism.discs, name); index >= 0) return Landmark{Kind::disc, 0, index};
  // names of bodies may contain dots
  for (std::size_t dot = name.rfind('.'); dot != std::string::npos && dot > 0; dot = name.rfind('.', dot - 1)) {
    const BodyId body = index_of(mechanism.bodies, name.substr(0, dot));
    if (body < 0) continue;
    const std::string point_name = name.substr(dot + 1);
    const int point = index_of(mechanism.bodies[static_cast<std::size_t>(body)].points, point_name);
    if (point >= 0) return Landmark{Kind::point, body, point};
    if (body > 0 && point_name == "com") return Landmark{Kind::com, body, 0};
    if (point_name == "origin") return Landmark{Kind::origin, body, 0};
  }
  return std::nullopt;
}

std::vector<std::string> list_landmarks(const Mechanism& mechanism) {
  std::vector<std::string> names;
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    const Body& body = mechanism.bodies[b];
    for (const auto& point : body.points) names.push_back(body.name + "." + point.name);
    if (b > 0) names.push_back(body.name + ".com");
    if (index_of(body.points, "origin") < 0) names.push_back(body.name + ".origin");
  }
  for (const Attachment& attachment : mechanism.attachments) names.push_back(attachment.name);
  for (const Disc& disc : mechanism.discs) names.push_back(disc.name);
  return names;
}

}  // namespace balance::model
