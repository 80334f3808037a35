#include "balance/spec/joint_type.hpp"

#include "balance/base/nearest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

namespace balance::specification {
namespace {

constexpr NamedJointType joint_types[]{{"revolute", JointType::revolute, true, true},
                                       {"prismatic", JointType::prismatic, true, true},
                                       {"fixed", JointType::fixed, true, true},
                                       {"pin-slot", JointType::pin_slot, true, false},
                                       {"rolling", JointType::pin_slot, true, false, true},
                                       {"rolling", JointType::rolling_disc, false, true, true},
                                       {"cylindrical", JointType::cylindrical, false, true},
                                       {"universal", JointType::universal, false, true},
                                       {"spherical", JointType::spherical, false, true},
                                       {"planar", JointType::planar, false, true}};

/// What others call the types.
constexpr std::pair<const char*, const char*> joint_type_synonyms[]{
    {"hinge", "revolute"},
    {"pin", "revolute"},
    {"pivot", "revolute"},
    {"rotary", "revolute"},
    {"rotational", "revolute"},
    {"turning", "revolute"},
    {"continuous", "revolute"},
    {"slider", "prismatic"},
    {"slide", "prismatic"},
    {"sliding", "prismatic"},
    {"linear", "prismatic"},
    {"translational", "prismatic"},
    {"ball", "spherical"},
    {"ball-joint", "spherical"},
    {"ball-and-socket", "spherical"},
    {"spheric", "spherical"},
    {"weld", "fixed"},
    {"welded", "fixed"},
    {"rigid", "fixed"},
    {"clamp", "fixed"},
    {"cardan", "universal"},
    {"hooke", "universal"},
    {"u-joint", "universal"},
    {"gimbal", "universal"},
    {"cylinder", "cylindrical"},
    {"cylindric", "cylindrical"},
    {"plane", "planar"},
    {"pin-in-slot", "pin-slot"},
    {"slot", "pin-slot"},
    {"slotted", "pin-slot"},
    {"wheel", "rolling"},
    {"roll", "rolling"},
    {"rolling-contact", "rolling"},
};

/// The type that a word means in another vocabulary; empty: none.
std::string find_synonym(std::string word) {
  for (char& c : word) c = c == '_' || c == ' ' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* ending : {"-joint", "-pair"})
    if (word.ends_with(ending) && word != ending) word.erase(word.size() - std::string_view(ending).size());
  for (const auto& [synonym, type] : joint_type_synonyms)
    if (word == synonym || word == type) return type;
  return word == "u" ? "universal" : "";
}

}  // namespace

NamedJointType read_joint_type(const SpecCursor& at, bool planar) {
  std::vector<std::string> names;
  std::vector<NamedJointType> possible;
  for (const NamedJointType& t : joint_types) {
    if (!(planar ? t.planar : t.spatial)) continue;
    names.emplace_back(t.name);
    possible.push_back(t);
  }
  const std::string what = fmt::format("a joint type of a {} mechanism", planar ? "planar" : "spatial");
  const std::string meant = at.is_scalar() ? find_synonym(at.node().text) : "";
  const bool known = at.is_scalar() && std::find(names.begin(), names.end(), at.node().text) != names.end();
  if (known || std::find(names.begin(), names.end(), meant) == names.end())
    return possible[at.read_choice(what, names)];
  at.fail({.expected = fmt::format("{} ({})", what, join_alternatives(names)),
           .found = at.describe_found(),
           .hint = fmt::format("that is '{}' here", meant)});
}

}  // namespace balance::specification
