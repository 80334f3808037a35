#include "balance/gradients/state_gradient.hpp"

#include "balance/gradients/moment.hpp"
#include "balance/gradients/state_duals.hpp"
#include "balance/inverse/engine.hpp"

#include <algorithm>
#include <stdexcept>

namespace balance {

namespace {

/// The state and the mechanism with the derivatives of a few numbers set.
struct Seeded {
  MechanismOf<DualNumber> mechanism;
  DriveSampleOf<DualNumber> target;

  void seed(const Wanted& wanted, std::size_t k) {
    if (const auto* number = std::get_if<MechanismNumber>(&wanted)) {
      number_in(mechanism, *number).d[k] = 1;
      if (has_mirror(*number))
        number_in(mechanism, {number->kind, number->index, number->column, number->row}).d[k] = 1;
      return;
    }
    const StateNumber& own = std::get<StateNumber>(wanted);
    auto& values = own.kind == StateNumber::Kind::q    ? target.value
                   : own.kind == StateNumber::Kind::dq ? target.rate
                                                       : target.acceleration;
    values[own.index].d[k] = 1;
  }
};

void check(const InverseDynamics& door, const std::vector<Wanted>& wanted) {
  for (const Wanted& one : wanted) {
    if (const auto* number = std::get_if<MechanismNumber>(&one)) {
      require_number(door.mechanism(), *number);
    } else if (const int index = std::get<StateNumber>(one).index; index < 0 || index >= door.degrees_of_freedom()) {
      throw std::invalid_argument("a number of the state: there is no coordinate " + std::to_string(index) + " of " +
                                  std::to_string(door.degrees_of_freedom()));
    }
  }
}

/// So many of the numbers as are taken at a time.
template <class S>
bool add_derivatives(const InverseEngine<S>& engine, const Seeded& seeded, double time, std::size_t count,
                     StateGradient& found) {
  const Branch<S>& branch = engine.branch();
  DriveQuantities quantities;
  quantities.coordinates = branch.independent();
  DualMoment<S> moment(seeded.mechanism, branch.tree(), branch.needed(), quantities, branch.redundant(),
                       branch.freedoms(), to_vector<S>(engine.options.about).template cast<DualNumber>());
  moment.move(branch.y(), seeded.target);
  if (!moment.observe(time, engine.options.time_scale, Detail::everything)) return false;
  SampleOf<DualNumber> seen = moment.sample();
  seen.mobility = moment.mobility();
  for (std::size_t k = 0; k < count; ++k) {
    found.derivatives.push_back(derivative_of(seen, k));
    found.openings.push_back(moment.openings(k));
  }
  return true;
}

Answer<StateGradient> start_of(InverseDynamics& door, const VectorX& q, const VectorX& dq, const VectorX& ddq,
                               double time) {
  Answer<Sample> here = door.at(q, dq, ddq, time);
  return {here.outcome, {std::move(here.value), {}, {}}};
}

DriveSampleOf<DualNumber> target_of(const VectorX& q, const VectorX& dq, const VectorX& ddq) {
  return {q.cast<DualNumber>(),          dq.cast<DualNumber>(),
          ddq.cast<DualNumber>(),        Matrix3Of<DualNumber>::Identity(),
          Vector3Of<DualNumber>::Zero(), Vector3Of<DualNumber>::Zero()};
}

/// @return whether the actuators hold the mechanism
bool differentiate_state(const InverseDynamics& door, const Seeded& seeded, double time, std::size_t count,
                         Answer<StateGradient>& found) {
  const auto& engine = door.engine();
  const bool held = in_space(door.mechanism().space, [&]<class S>(S) {
    return add_derivatives(static_cast<const InverseEngine<S>&>(engine), seeded, time, count, found.value);
  });
  if (held) return true;
  found.outcome.status = MotionStatus::actuation_singularity;
  found.outcome.reason = "actuation singularity: the efforts have no derivatives there";
  return false;
}

}  // namespace

Answer<StateGradient> derivatives(InverseDynamics& door, const VectorX& q, const VectorX& dq, const VectorX& ddq,
                                  const std::vector<Wanted>& wanted, double time) {
  check(door, wanted);
  Answer<StateGradient> found = start_of(door, q, dq, ddq, time);
  if (!found) return found;
  const Seeded plain{with_derivatives(door.mechanism()), target_of(q, dq, ddq)};
  for (std::size_t first = 0; first < wanted.size(); first += dual_width) {
    const std::size_t count = std::min<std::size_t>(dual_width, wanted.size() - first);
    Seeded seeded = plain;
    for (std::size_t k = 0; k < count; ++k) seeded.seed(wanted[first + k], k);
    if (!differentiate_state(door, seeded, time, count, found)) break;
  }
  return found;
}

Answer<StateGradient> derivatives(InverseDynamics& door, const MechanismOf<DualNumber>& mechanism, const VectorX& q,
                                  const VectorX& dq, const VectorX& ddq, double time) {
  Answer<StateGradient> found = start_of(door, q, dq, ddq, time);
  if (found) differentiate_state(door, {mechanism, target_of(q, dq, ddq)}, time, dual_width, found);
  return found;
}

}  // namespace balance
