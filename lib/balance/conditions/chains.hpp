#pragma once
/// The chains of a parallel mechanism as mechanisms of their own, each with point masses for its share of what they carry
/// together (P0 section 2.2). Private to conditions.

#include "balance/dynamics/parameter.hpp"

#include <string>
#include <vector>

namespace balance {

/// A chain alone: its bodies, joints and whatever hangs on them, and a payload at every tip.
struct Chain {
  std::string name;  ///< "crank1, coupler1"
  Mechanism mechanism;
  FreeSprings loose_springs;
  MatrixX parameters;  ///< π of the chain = parameters · π of the whole mechanism
};

/// The chains and what is left over are together the whole mechanism: at every moment the same forces result.
struct ChainSplit {
  std::string failure_reason;  ///< why the mechanism cannot be split; else empty
  bool is_serial = false;      ///< there is nothing to split
  std::vector<Chain> chains;
  MatrixX unassigned;  ///< P×P: parameters of the whole mechanism with everything taken off that the chains carry
  std::vector<std::string> notes;
};

/// A platform's mass and first moments, with those of everything on it, are replaced by point masses at its joints: barycentric
/// for three points in a plane, else the smallest ones with the same mass and, as far as possible, the same CoM. A payload
/// at the joint where a loop is opened is shared equally, unless both bodies have payloads there: then each keeps its own.
ChainSplit split_into_chains(const Mechanism& mechanism, const FreeSprings& loose = {});

}  // namespace balance
