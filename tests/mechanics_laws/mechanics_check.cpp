#include "mechanics_check.hpp"

#include "balance/mechanics/dynamics/inertia_regressor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

namespace laws {

using namespace balance;
using namespace balance::kinematics;

std::string Findings::text() const {
  std::string out;
  for (const std::string& text : texts_) out += (out.empty() ? "" : "; ") + text;
  return out;
}

void Findings::add(const std::string& law, double error, double allowed) {
  char text[80];
  std::snprintf(text, sizeof text, " by %.2g, allowed %.2g", error, allowed);
  texts_.push_back(law + text);
}

void judge_rates(const Run& run, Findings& findings) {
  const double h = run.step(), T = run.trajectory.duration;
  const Samples &q = run.result.joint_position, &v = run.result.joint_velocity, &a = run.result.joint_acceleration;
  for (long c = 0; c < q.cols(); ++c) {
    const double unit = run.mechanism.coordinates[c].kind == CoordinateKind::length ? run.length() : 1;
    const double fast = v.col(c).cwiseAbs().maxCoeff() + unit / T, hard = a.col(c).cwiseAbs().maxCoeff() + unit / T / T;
    for (long k = 6; k + 6 < run.samples(); k += 5) {
      if (!run.smooth[k - 3] || !run.smooth[k + 3]) continue;
      const auto wide = [&](auto f) {  // the same from samples twice as far apart tells what the step leaves
        const Samples every = q(Eigen::seqN(k - 6, 7, 2), c);
        return f(every, 3, 0, 2 * h);
      };
      const double first = rate(q, k, c, h), second = second_rate(q, k, c, h);
      findings.see("rate of " + run.result.coordinate_names[c], std::abs(first - v(k, c)) / fast,
                   1e-7 + 4 * std::abs(first - wide(rate)) / fast);
      findings.see("second rate of " + run.result.coordinate_names[c], std::abs(second - a(k, c)) / hard,
                   1e-5 + 4 * std::abs(second - wide(second_rate)) / hard);
      if (!findings.none()) return;
    }
  }
}

namespace {

template <class S>
void regress(const Mechanism& mechanism, Findings& findings) {
  std::mt19937 random(11);
  const Tree<S> tree = compile_tree<S>(mechanism, {});
  VectorX y(tree.columns), dy(tree.columns), ddy(tree.columns), tau(tree.columns);
  for (VectorX* v : {&y, &dy, &ddy})
    for (double& x : *v) x = 4 * (random() * 0x1p-32) - 2;
  TreeState<S> state(tree.nodes.size());
  balance::kinematics::compute_poses(tree, y.data(), state);
  compute_velocities(tree, dy.data(), state);
  compute_accelerations<S>(tree, dy.data(), ddy.data(), -to_vector<S>(mechanism.gravity), state);
  std::vector<dynamics::Wrench<S>> wrenches(tree.nodes.size());
  inverse_dynamics(tree, state, wrenches, tau.data());
  const VectorX pi = dynamics::list_inertial_parameters<S>(tree);
  const dynamics::InertiaRegressor<S> Y = dynamics::compute_regressor<S>(tree, state);
  const double scale = std::max(1e-300, (Y.torque.cwiseAbs() * pi.cwiseAbs()).maxCoeff());
  findings.see("regressor of efforts", (Y.torque * pi - tau).cwiseAbs().maxCoeff() / scale, 1e-12);
  findings.see(
      "regressor of forces",
      (Y.force * pi - wrenches[0].force).cwiseAbs().maxCoeff() / (Y.force.cwiseAbs() * pi.cwiseAbs()).maxCoeff(),
      1e-12);
}

double largest(const Samples& a) { return a.size() == 0 ? 0 : a.cwiseAbs().maxCoeff(); }

/// Whether two runs of one experiment say the same, the second with its numbers multiplied.
void compare(const Run& a, const Run& b, const Units& by, const std::string& where, Findings& findings) {
  if (b.result.outcome.status != MotionStatus::done)
    return findings.say(where + " refused: " + b.result.outcome.reason);
  const double allowed = 1e-9 / std::min(1.0, a.result.mobility.minCoeff());
  const RunResult &here = a.result, &there = b.result;
  const double force =
      largest(here.joint_force) + largest(here.shaking_force) + total_mass(a.mechanism) * a.mechanism.gravity.norm();
  const auto off = [](const Samples& one, const Samples& other, double factor, double scale) {
    return (one * factor - other).cwiseAbs().maxCoeff() / (scale * factor);
  };
  for (long c = 0; c < here.joint_position.cols(); ++c) {
    const bool slide = a.mechanism.coordinates[c].kind == CoordinateKind::length;
    const double unit = slide ? a.length() : 1, factor = slide ? by.length : 1;
    findings.see(where + ": position", off(here.joint_position.col(c), there.joint_position.col(c), factor, unit),
                 allowed);
  }
  for (long c = 0; c < here.torque.cols(); ++c) {
    const bool slide = here.actuator_units[c] == "N";
    findings.see(where + ": effort",
                 off(here.torque.col(c), there.torque.col(c), slide ? by.force() : by.moment(),
                     std::max(force * (slide ? 1 : a.length()), largest(here.torque))),
                 allowed);
  }
  findings.see(where + ": kinetic energy",
               off(here.kinetic_energy, there.kinetic_energy, by.moment(), here.kinetic_energy.maxCoeff() + 1e-300),
               allowed);
}

}  // namespace

void judge_regressor(const Run& run, Findings& findings) {
  if (run.mechanism.space == SpaceKind::planar)
    regress<Planar>(run.mechanism, findings);
  else
    regress<Spatial>(run.mechanism, findings);
}

void judge_elsewhere(const Run& run, Findings& findings) {
  const Experiment here{run.mechanism, run.trajectory};
  std::mt19937 random(static_cast<std::uint32_t>(std::abs(run.result.time[1]) * 1e9));
  const auto power = [&](double most) { return std::pow(10, most * (2 * (random() * 0x1p-32) - 1)); };
  const Units by{power(6), power(9), power(3)};
  Experiment there = scaled(here, by);
  there.trajectory.samples = 11;
  Run few = run;
  const Eigen::ArithmeticSequence rows = Eigen::seqN(0, 11, (run.samples() - 1) / 10);
  for (Samples* array : {&few.result.joint_position, &few.result.torque, &few.result.kinetic_energy})
    *array = Samples((*array)(rows, Eigen::all));
  const Run other = attempt(run.name, there.mechanism, there.trajectory);
  compare(few, other, by, "in other units", findings);
  if (other.result.outcome.status == MotionStatus::done) {
    const double force = largest(run.result.joint_force) + largest(run.result.shaking_force);
    const Samples shake = run.result.shaking_force(rows, Eigen::all);
    findings.see("in other units: shaking force",
                 (shake * by.force() - other.result.shaking_force).cwiseAbs().maxCoeff() / (force * by.force()), 1e-8);
  }
  const bool more_motors = std::any_of(run.result.outcome.notes.begin(), run.result.outcome.notes.end(),
                                       [](const std::string& note) { return note.rfind("over-actuated", 0) == 0; });
  // with a motor to spare the number of actuators does not say which directions are driven
  if (!can_be_displaced(here) || (more_motors && run.trajectory.drive != DriveKind::joints)) return;
  const bool planar = run.mechanism.space == SpaceKind::planar;
  const Matrix3 R = planar ? displacement({}, true, std::vector<double>{0.7}.data()).R
                           : Matrix3(Eigen::Quaterniond(0.5, -0.5, 0.1, 0.7).normalized());
  Experiment moved = displaced(here, R, run.length() * Vector3(0.3, -0.2, planar ? 0 : 0.5));
  moved.trajectory.samples = 11;
  compare(few, attempt(run.name, moved.mechanism, moved.trajectory), {}, "elsewhere", findings);
}

Verdict judge(Kind kind, std::uint32_t seed, const Thoroughness& thoroughness) {
  std::string refusals;
  for (const double reach : {0.4, 0.1, 0.02}) {
    Member one = member(kind, seed, reach);
    one.experiment.trajectory.samples = thoroughness.samples;
    const Run run = attempt(one.experiment.mechanism.name, one.experiment.mechanism, one.experiment.trajectory);
    const MotionOutcome& outcome = run.result.outcome;
    if (outcome.status != MotionStatus::done) {
      refusals = outcome.reason;
      // a centre of mass that does not move in a direction that is asked of it: true of the mechanism, not of the program
      const bool balanced = outcome.reason.find("cannot drive") != std::string::npos;
      const bool known = outcome.status == MotionStatus::not_assembled ||
                         (outcome.status == MotionStatus::mismatch && !balanced) ||
                         outcome.status == MotionStatus::unsolved ||
                         outcome.reason.find("the start pose cannot be reached") != std::string::npos;
      if (known || outcome.reason.empty()) return {Judgement::failed, "wrongly refused: " + outcome.reason};
      continue;
    }
    Findings findings;
    judge_instants(run, thoroughness.instants, findings);
    judge_rates(run, findings);
    judge_regressor(run, findings);
    if (thoroughness.elsewhere) judge_elsewhere(run, findings);
    if (thoroughness.formulations) {
      judge_formulations(run, findings);
      judge_forward(run, findings);
    }
    if (thoroughness.conditions) judge_conditions(run, thoroughness.instants, findings);
    return {findings.none() ? Judgement::passed : Judgement::failed, findings.text()};
  }
  return {Judgement::refused, refusals};
}

}  // namespace laws
