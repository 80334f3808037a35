#pragma once
/// How near a point of one body comes to another point, or to the line between two.

#include <vector>

namespace balance {

/// A place that something in the mechanism marks.
struct Landmark {
  enum class Kind {
    origin,      ///< of a body's frame
    com,         ///< of a body alone, without what is attached
    point,       ///< a named one of a body
    attachment,  ///< the centre of mass of a counterweight or payload
    disc,        ///< its centre of mass
  };
  Kind kind = Kind::origin;
  BodyId body = 0;  ///< of origin, com and point
  int index = 0;    ///< of the body's point, of the attachment or of the disc
};

/// Distance between a point and `to`: another point, or the straight line from one to another [m].
struct Clearance {
  Landmark point;
  std::vector<Landmark> target;  ///< one or two
};

}  // namespace balance
