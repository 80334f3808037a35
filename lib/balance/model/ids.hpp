#pragma once
/// Indices into a mechanism's lists.

#include "balance/base/id.hpp"

namespace balance {

using BodyId = TypedIndex<struct BodyList>;              ///< into Mechanism::bodies
using JointId = TypedIndex<struct JointList>;            ///< into Mechanism::joints
using CoordinateId = TypedIndex<struct CoordinateList>;  ///< into Mechanism::coordinates

}  // namespace balance
