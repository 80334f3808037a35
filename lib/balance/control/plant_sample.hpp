#pragma once
/// An observation in the plain values of a PlantSample. Private to control.

#include "balance/control/plant.hpp"
#include "balance/dynamics/observer.hpp"

namespace balance {

/// Everything that the observer knows; time, friction and figures of the solution are left alone.
template <class S>
void copy_observation(const Observation<S>& seen, PlantSample& sample);

extern template void copy_observation<Planar>(const Observation<Planar>&, PlantSample&);
extern template void copy_observation<Spatial>(const Observation<Spatial>&, PlantSample&);

}  // namespace balance
