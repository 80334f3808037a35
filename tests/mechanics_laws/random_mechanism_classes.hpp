#pragma once
/// A crowd of random mechanisms by class: trees and loops, several loops one in another, joints of every type walked either
/// way, gears, discs, counterweights, payloads, springs, loads, friction. Loops are closed where the bodies lie at a known
/// configuration, so that every member can be assembled. Uses nothing of the engine but the types of the model.

#include "transforms.hpp"

#include "balance/foundation/base/types.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace laws {

enum class Kind { planar_tree, planar_loop, planar_loops, spatial_tree, spatial_loop, spatial_loops, flat_in_space };

inline constexpr Kind kinds[] = {Kind::planar_tree,  Kind::planar_loop,   Kind::planar_loops, Kind::spatial_tree,
                                 Kind::spatial_loop, Kind::spatial_loops, Kind::flat_in_space};

std::string name_of(Kind kind);

struct Member {
  Experiment experiment;
  balance::VectorX start;  ///< of all coordinates: every joint agrees there
  int freedoms = 0;        ///< at the start, by the differences of how the loops close
};

/// The same for the same kind and seed on every machine.
/// @param reach how far the actuators go, as a part of a radian or of a length of one
Member member(Kind kind, std::uint32_t seed, double reach = 0.4);

/// How far bodies and joints are from agreeing when the coordinates have the values q: per joint three lengths and nine entries of a
/// rotation, then one entry per coupling.
balance::VectorX disagreement(const balance::Mechanism& mechanism, const balance::VectorX& q);

}  // namespace laws
