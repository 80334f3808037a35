#pragma once
/// What a spec calls the types of joints. Private to the library.

#include "balance/model/mechanism.hpp"

namespace balance {

inline const char* name_of(JointType type) {
  switch (type) {
    case JointType::revolute: return "revolute";
    case JointType::prismatic: return "prismatic";
    case JointType::fixed: return "fixed";
    case JointType::pin_slot: return "pin-slot";
    case JointType::cylindrical: return "cylindrical";
    case JointType::universal: return "universal";
    case JointType::spherical: return "spherical";
    case JointType::planar: return "planar";
    case JointType::rolling_disc:
    case JointType::rolling_sphere: return "rolling";
  }
  return "";
}

}  // namespace balance
