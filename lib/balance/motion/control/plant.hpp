#pragma once
/// The mechanism as it moves under given efforts: forward dynamics integrated over time with error control.

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/results/term_magnitudes.hpp"
#include "balance/mechanics/trajectory/motion_sample.hpp"
#include "balance/motion/control/control_law.hpp"

namespace balance {

struct PlantOptions {
  double relative_tolerance = 1e-9;   ///< of every coordinate and rate per step, in (0, 1e-2]
  double absolute_tolerance = 1e-11;  ///< the same in rad, characteristic lengths, and these per second; positive
  double max_step = 0.05;             ///< [s], positive
  long max_steps = 5'000'000;         ///< of all advances together, rejected ones included; positive
  ForwardOptions dynamics;

  /// @throws std::invalid_argument
  void validate() const;
};

/// What the integration has cost so far.
struct PlantCost {
  long steps = 0, rejected = 0, evaluations = 0;
  long choices = 0;  ///< of independent coordinates
  long events = 0;   ///< of dry friction: joints that come to rest, turn back or break loose
};

class Plant {
 public:
  /// @param mechanism must outlive the plant
  /// @param about world point that moments are about
  /// @throws std::invalid_argument for options out of range
  explicit Plant(const Mechanism& mechanism, const PlantOptions& options = {}, const Vector3& about = Vector3::Zero());
  ~Plant();
  Plant(Plant&&) noexcept;
  Plant& operator=(Plant&&) noexcept;

  /// Starts at joint coordinates and rates. Coordinates that do not fit the closures are moved until they do: the actuated ones
  /// are kept where they determine the rest, else the ones that determine it best. Rates follow from the same ones.
  /// @param position, velocity per mechanism coordinate (those of cut joints do not matter)
  MotionOutcome start(double time, const VectorX& position, const VectorX& velocity);

  /// On to a later time, the efforts held constant (zero-order hold).
  /// @param efforts one per actuator [N m or N]
  /// @return done, or why it stopped: constraint_singularity, or unreachable where the integration cannot go on. The state is then
  ///         the last good one, at time().
  MotionOutcome advance(double time, const VectorX& efforts);
  /// The same under efforts that change on the way.
  /// @param course must stay as it is until then
  MotionOutcome advance(double time, const EffortProfile& course);

  int freedoms() const;
  const std::vector<CoordinateId>& independent() const;  ///< as ForwardDynamics::independent(); may change in advance()
  double time() const;
  const VectorX& position() const;  ///< per mechanism coordinate; angles run on past ±π
  const VectorX& velocity() const;

  /// At the present state. Joints with dry friction that stand still stick under these efforts or break loose:
  VectorX acceleration(const VectorX& efforts);  ///< per mechanism coordinate
  EquationOfMotion equation();                   ///< without the friction of joints that stick
  const Sample& observe(const VectorX& efforts);

  /// How large the terms were at all moments observed since the start.
  const TermMagnitudes& term_sizes() const;
  const TermMagnitudes& term_sizes_over_mobility()
      const;  ///< those of each moment over its mobility, where that is below one

  const PlantCost& cost() const;
  /// What a user should know: minimum-norm reactions, held spins.
  const std::vector<std::string>& notes() const;

  class Implementation;  ///< the planar or the spatial one; of no use elsewhere

 private:
  std::unique_ptr<Implementation> engine_;
};

}  // namespace balance
