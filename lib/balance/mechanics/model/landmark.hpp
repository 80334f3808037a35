#pragma once
/// Points that elements of a mechanism mark.

#include "balance/mechanics/model/mechanism.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::model {

/// A point marked by an element of the mechanism.
struct Landmark {
  enum class Kind {
    origin,      ///< of a body's frame
    com,         ///< of a body alone, without attachments
    point,       ///< a named point of a body
    attachment,  ///< the centre of mass of a counterweight or payload
    disc,        ///< centre of mass of a disc
  };
  Kind kind = Kind::origin;
  BodyId body = 0;  ///< for origin, com and point
  int index = 0;    ///< of the body's point, of the attachment or of the disc
};

/// A point fixed to a body.
struct BodyPoint {
  BodyId body = 0;
  Vector3 position = Vector3::Zero();  ///< in the body's axes [m]
};

BodyPoint locate_landmark(const Mechanism& mechanism, const Landmark& landmark);

/// The landmark of that name: of a counterweight, payload or disc, `body.point`, `body.com` or `body.origin`.
/// @return std::nullopt if there is none
std::optional<Landmark> find_landmark(const Mechanism& mechanism, const std::string& name);

/// The names of all landmarks.
std::vector<std::string> list_landmarks(const Mechanism& mechanism);

}  // namespace balance::model
