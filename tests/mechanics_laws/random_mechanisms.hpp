#pragma once
/// Mechanisms that nobody designed: random trees of bodies with joints of every type walked either way, with and without a
/// loop, with gears, discs, attachments, springs, loads and friction, all lengths and axes in general position.

#include "transforms.hpp"

#include <cstdint>
#include <optional>

namespace laws {

/// @return nothing if this seed's motion cannot be driven well (near a singularity)
std::optional<Experiment> random_experiment(balance::SpaceKind space, std::uint32_t seed);

}  // namespace laws
