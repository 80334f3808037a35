#pragma once
/// Motion of the mechanism under given efforts: forward dynamics integrated over time with error control.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/motion/control/control_law.hpp"

namespace balance::control {

struct PlantOptions {
  double relative_tolerance = 1e-9;   ///< of every coordinate and rate per step, in (0, 1e-2]
  double absolute_tolerance = 1e-11;  ///< the same in rad, characteristic lengths, and these per second; positive
  double max_step = 0.05;             ///< [s], positive
  long max_steps = 5'000'000;         ///< of all advances together, including rejected ones; positive
  dynamics::ForwardOptions dynamics;

  /// @throws std::invalid_argument if an option is out of range
  void validate() const;
};

/// Cost of the integration so far.
struct PlantCost {
  long steps = 0, rejected = 0, evaluations = 0;
  long choices = 0;  ///< of independent coordinates
  long events = 0;   ///< of dry friction: joints that come to rest, reverse or break loose
};

class Plant {
 public:
  /// @param mechanism must outlive the plant
  /// @param about reference point of moments in the world
  /// @throws std::invalid_argument if an option is out of range
  explicit Plant(const Mechanism& mechanism, const PlantOptions& options = {}, const Vector3& about = Vector3::Zero());
  ~Plant();
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  /// Starts at joint coordinates and rates. Coordinates that violate the closures are corrected: the actuated ones are
  /// kept if they determine the rest, else the ones that determine it best. Rates follow from the same coordinates.
  /// @param position, velocity per mechanism coordinate (of cut joints, angles only tell the full turns)
  MotionOutcome start(double time, const VectorX& position, const VectorX& velocity);

  /// Advances to a later time with constant efforts (zero-order hold).
  /// @param efforts one per actuator [N m or N]
  /// @return done, or why it stopped: constraint_singularity, or unreachable if the integration cannot continue. The
  ///        state is then the last valid one, at time().
  MotionOutcome advance(double time, const VectorX& efforts);
  /// The same with efforts that change over time.
  /// @param effort_profile must not change during the call
  MotionOutcome advance(double time, const EffortProfile& effort_profile);

  int freedoms() const;
  const std::vector<CoordinateId>& independent() const;  ///< as ForwardDynamics::independent(); may change in advance()
  double time() const;
  const VectorX& position() const;  ///< per mechanism coordinate; angles are continuous past ±π
  const VectorX& velocity() const;

  /// At the current state. Joints with dry friction at rest stick or break loose under these efforts:
  VectorX acceleration(const VectorX& efforts);  ///< per mechanism coordinate
  dynamics::EquationOfMotion equation();         ///< without the friction of sticking joints
  const Sample& observe(const VectorX& efforts);

  /// Maximum magnitudes of terms at all states observed since the start.
  const results::TermMagnitudes& term_sizes() const;
  const results::TermMagnitudes& term_sizes_over_mobility()
      const;  ///< the same, each divided by the mobility of its state if that is below one

  const PlantCost& cost() const;
  /// Notes for the user: minimum-norm reactions, held spins.
  const std::vector<std::string>& notes() const;

  class Implementation;  ///< the planar or the spatial one; for internal use

 private:
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace balance::control
