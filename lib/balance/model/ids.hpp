#pragma once
/// Indices into a mechanism's lists.

#include "balance/base/id.hpp"

namespace balance {

using BodyId = IdOf<struct BodyList>;              ///< into Mechanism::bodies
using JointId = IdOf<struct JointList>;            ///< into Mechanism::joints
using CoordinateId = IdOf<struct CoordinateList>;  ///< into Mechanism::coordinates

}  // namespace balance
