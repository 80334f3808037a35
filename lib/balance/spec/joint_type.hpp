#pragma once
/// The words of a spec for the types of joints.

#include "balance/model/mechanism.hpp"
#include "balance/spec/cursor.hpp"

namespace balance::specification {

struct NamedJointType {
  const char* name;
  JointType type;
  bool planar, spatial;
  bool is_rolling = false;  ///< in the plane: a pin in a slot whose slide follows its angle
};

/// @throws Problem if the word is no type of a planar or of a spatial mechanism; it names what others call so
NamedJointType read_joint_type(const SpecCursor& at, bool planar);

}  // namespace balance::specification
