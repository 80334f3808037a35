// Efforts at single states take nothing from the heap, along open trees and with loops that are followed.

#include "heap.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

TEST_CASE("the efforts of one state after another take nothing from the heap") {
  using namespace balance;
  if (!heap::counted()) return;
  for (const std::string file :
       {"planar-rrr.yaml", "spatial-rrr.yaml", "3rrr.yaml", "stewart.yaml", "slider-crank.yaml"}) {
    CAPTURE(file);
    InverseDynamics door(read_spec_file(std::string(BALANCE_CONFIGS "/") + file).mechanism);
    const auto n = static_cast<Eigen::Index>(door.degrees_of_freedom());
    VectorX q = VectorX::Zero(n), dq = VectorX::Ones(n), ddq = VectorX::Ones(n), effort;
    for (Eigen::Index k = 0; k < n; ++k)
      for (const CoordinateValue& value : door.mechanism().assembly)
        if (door.mechanism().coordinates[static_cast<std::size_t>(value.coordinate)].name ==
            door.independent()[static_cast<std::size_t>(k)])
          q[k] = value.value;
    bool good = true;
    long before = 0;
    for (int step = 0; step < 60; ++step) {
      if (step == 5) before = heap::requests();
      for (Eigen::Index k = 0; k < n; ++k) q[k] += 2e-4 * std::cos(0.1 * step + static_cast<double>(k));
      good = good && door.efforts(q, dq, ddq, effort).status == MotionStatus::done;
    }
    const long taken = heap::requests() - before;
    CHECK(good);
    CHECK(taken == 0);
  }
}
