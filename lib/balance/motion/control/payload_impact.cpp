#include "balance/motion/control/payload_impact.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/mechanics/dynamics/forward_dynamics.hpp"

namespace balance::control {

PayloadImpact take_up_payloads(const Mechanism& before, const Mechanism& after, double time, const VectorX& position,
                               const VectorX& velocity) {
  PayloadImpact impact;
  if (has_prescribed_speeds(before)) {
    // the impulse of the constraint's force does work
    impact.outcome = {MotionStatus::mismatch,
                      time,
                      "a payload is taken up while a constraint on speeds has a value: the impact is not treated",
                      {}};
    return impact;
  }
  dynamics::ForwardDynamics lighter(before);
  impact.outcome = lighter.set_state(time, position, velocity);
  if (impact.outcome.status != MotionStatus::done) return impact;
  dynamics::ForwardDynamics heavier(after, {.preferred = lighter.independent()});
  impact.outcome = heavier.set_state(time, lighter.position(), lighter.velocity());
  if (impact.outcome.status != MotionStatus::done) return impact;
  // rates of other coordinates would be another momentum
  if (heavier.independent() != lighter.independent()) {
    impact.outcome = {MotionStatus::constraint_singularity,
                      time,
                      "a payload is taken up in a configuration in which the independent coordinates change",
                      {}};
    return impact;
  }
  const VectorX rates = lighter.rates();
  const MatrixX mass_before = lighter.equation().mass, mass_after = heavier.equation().mass;
  const VectorX rates_after = mass_after.ldlt().solve(mass_before * rates);
  impact.velocity = heavier.transformation().matrix * rates_after;
  impact.energy_loss = std::max(0.0, (rates.dot(mass_before * rates) - rates_after.dot(mass_after * rates_after)) / 2);
  return impact;
}

}  // namespace balance::control
