#include "mechanics_check.hpp"

#include "balance/mechanics/dynamics/forward_dynamics.hpp"
#include "balance/mechanics/model/couplings.hpp"
#include "balance/synthesis/verification/simulate_natural.hpp"

#include <algorithm>

namespace laws {

using namespace balance;

namespace {

double largest_entry(const Samples& a) { return a.size() == 0 ? 0 : a.cwiseAbs().maxCoeff(); }

/// A motor to spare may be spared differently.
bool more_motors(const Run& run) {
  return std::any_of(run.result.outcome.notes.begin(), run.result.outcome.notes.end(),
                     [](const std::string& note) { return note.rfind("over-actuated", 0) == 0; });
}

}  // namespace

void judge_formulations(const Run& run, Findings& findings) {
  if (run.mechanism.space != SpaceKind::planar) return;
  const RunResult other = verification::simulate_natural(run.mechanism, run.trajectory);
  if (other.outcome.status != MotionStatus::done)
    return findings.say("natural coordinates refuse: " + other.outcome.reason);
  const RunResult& one = run.result;
  // positions solved to 1e-12, enlarged by the condition of the equations
  const double allowed = 1e-9 / std::min(1.0, one.mobility.minCoeff() * one.mobility.minCoeff());
  const double force = largest_entry(one.joint_force) + largest_entry(one.shaking_force), L = run.length();
  findings.see("positions in natural coordinates", largest_entry(one.joint_position - other.joint_position), allowed);
  findings.see("shaking force in natural coordinates", largest_entry(one.shaking_force - other.shaking_force) / force,
               allowed);
  findings.see("shaking moment in natural coordinates",
               largest_entry(one.shaking_moment - other.shaking_moment) / (force * L), allowed);
  if (more_motors(run)) return;
  for (long c = 0; c < one.torque.cols(); ++c)
    findings.see("effort in natural coordinates",
                 largest_entry(one.torque.col(c) - other.torque.col(c)) /
                     (force * (one.actuator_units[c] == "N" ? 1 : std::max(L, 1.0))),
                 allowed);
}

/// Whether it sticks cannot be computed: forward dynamics refuse it.
bool rubs_dry_on_a_sum(const Mechanism& mechanism) {
  const auto roots = resolve_couplings(mechanism);
  return std::any_of(mechanism.friction.begin(), mechanism.friction.end(), [&](const Friction& f) {
    return f.coulomb != 0 && roots[static_cast<std::size_t>(f.coordinate)].terms.size() > 1;
  });
}

void judge_forward(const Run& run, Findings& findings) {
  if (rubs_dry_on_a_sum(run.mechanism)) return;
  dynamics::ForwardDynamics forward(run.mechanism);
  const RunResult& r = run.result;
  for (const long k : {run.samples() / 3, 2 * run.samples() / 3}) {
    const VectorX q = r.joint_position.row(k).transpose(), v = r.joint_velocity.row(k).transpose(),
                  a = r.joint_acceleration.row(k).transpose();
    const bool slow = std::any_of(run.mechanism.friction.begin(), run.mechanism.friction.end(), [&](const Friction& f) {
      return f.coulomb != 0 && std::abs(v[f.coordinate]) < 2e-3 * std::max(1.0, run.length());
    });
    if (slow) continue;  // there friction is smoothed
    const MotionOutcome outcome = forward.set_state(r.time[k], q, v);
    if (outcome.status != MotionStatus::done) return findings.say("forward dynamics refuse: " + outcome.reason);
    const double size = r.joint_acceleration.cwiseAbs().maxCoeff() + r.joint_velocity.cwiseAbs2().maxCoeff();
    const VectorX found = forward.acceleration(r.torque.row(k).transpose());
    findings.see("accelerations from the efforts", (found - a).cwiseAbs().maxCoeff() / size,
                 1e-8 / std::min(1.0, r.mobility.minCoeff() * r.mobility.minCoeff()));
  }
}

}  // namespace laws
