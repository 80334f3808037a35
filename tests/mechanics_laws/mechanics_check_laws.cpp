#include "mechanics_check.hpp"

#include "finite_difference_state.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace laws {

using namespace balance;

namespace {

/// One moment's books.
class Books {
 public:
  Books(const Run& run, const std::vector<Element>& parts, long k, double tolerance, Findings& findings)
      : run_(run), parts_(parts), k_(k), tolerance_(tolerance), now_(instant(run, parts, k)), findings_(findings) {
    const std::size_t bodies = run.mechanism.bodies.size();
    rates_.resize(bodies), weights_.resize(bodies);
    for (std::size_t e = 0; e < parts.size(); ++e) {
      const Moving& f = now_.elements[e];
      const Mass& mass = parts[e].mass;
      const Vector3 g = run.mechanism.gravity, arm = mass.m * f.p + f.R * mass.mc;
      const Total rate = momentum_rate(f, mass), moving = momentum(f, mass);
      rates_[parts[e].body].force += rate.force, rates_[parts[e].body].moment += rate.moment;
      weights_[parts[e].body].force += mass.m * g, weights_[parts[e].body].moment += arm.cross(g);
      com_ += arm, momentum_ += moving.force, mass_ += mass.m;
      energy_ += kinetic_energy(f, mass), energy_rate_ += kinetic_energy_rate(f, mass);
      potential_ -= arm.dot(g), potential_size_ += mass.m * g.norm() * run.length() + std::abs(arm.dot(g));
      force_ = std::max(force_, rate.force.norm() + mass.m * g.norm());
      speed_ = std::max(speed_, mass.m * f.dp.norm());
    }
    loads_ = loads(run, k), springs_ = springs(run, k), joints_ = reactions(run, k);
    for (const auto* all : {&loads_, &springs_, &joints_})
      for (const Total& one : *all) force_ = std::max(force_, one.force.norm());
    length_ = run.length() + run.result.moment_reference.norm();
    // at rest, and where accelerations pass zero, nothing of the moment's own has a size
    force_ += 0.01 * (run.result.joint_force.cwiseAbs().maxCoeff() + run.result.shaking_force.cwiseAbs().maxCoeff());
    force_ += run.result.joint_moment.row(k).cwiseAbs().maxCoeff() / length_ + 1e-9 * mass_ * length_;
  }

  void loops() const {
    const double rate = run_.result.joint_velocity.row(k_).cwiseAbs().maxCoeff() + 1e-3,
                 second = run_.result.joint_acceleration.row(k_).cwiseAbs().maxCoeff() + rate * rate;
    see("closed loops", now_.open.cwiseAbs().maxCoeff() / length_, 1e-10);
    see("loops closed in velocity", now_.open_rate.cwiseAbs().maxCoeff() / (rate * length_), 1e-8);
    see("loops closed in acceleration", now_.open_second_rate.cwiseAbs().maxCoeff() / (second * length_));
  }

  void bodies() const {
    for (std::size_t b = 1; b < rates_.size(); ++b) {
      const Vector3 f = joints_[b].force + springs_[b].force + loads_[b].force + weights_[b].force - rates_[b].force;
      const Vector3 m =
          joints_[b].moment + springs_[b].moment + loads_[b].moment + weights_[b].moment - rates_[b].moment;
      see("forces on " + run_.mechanism.bodies[b].name, in_space(f) / force_);
      see("moments on " + run_.mechanism.bodies[b].name, turning(m) / (force_ * length_));
    }
  }

  void sums() const {
    Total rate, outside;
    for (const Total& one : rates_) rate.force += one.force, rate.moment += one.moment;
    for (const auto* all : {&weights_, &loads_})
      for (const Total& one : *all) outside.force += one.force, outside.moment += one.moment;
    const RunResult& r = run_.result;
    const auto about = [&](const Total& one) { return Vector3(one.moment - r.moment_reference.cross(one.force)); };
    see("shaking force", in_space(rate.force - run_.row(r.shaking_force, k_)) / force_);
    see("shaking moment", turning(about(rate) - run_.moment(r.shaking_moment, k_)) / (force_ * length_));
    const Total felt{outside.force - rate.force, outside.moment - rate.moment};
    see("ground force", in_space(felt.force - run_.row(r.ground_force, k_)) / force_);
    see("ground moment", turning(about(felt) - run_.moment(r.ground_moment, k_)) / (force_ * length_));
    see("centre of mass", (com_ / mass_ - run_.row(r.com_position, k_)).norm() / length_);
    see("velocity of the centre of mass",
        (momentum_ / mass_ - run_.row(r.com_velocity, k_)).norm() * mass_ / (speed_ + 1e-9 * mass_ * length_));
    see("acceleration of the centre of mass",
        (rate.force / mass_ - run_.row(r.com_acceleration, k_)).norm() * mass_ / force_);
  }

  void energies() const {
    const RunResult& r = run_.result;
    const Mechanism& m = run_.mechanism;
    see("kinetic energy", std::abs(energy_ - r.kinetic_energy(k_, 0)) / (r.kinetic_energy.maxCoeff() + 1e-300));
    double stored = potential_, size = potential_size_;
    for (const Spring& spring : m.springs) {
      if (spring.is_joint_spring()) {
        const double q = r.joint_position(k_, spring.coordinate);
        stored += (0.5 * spring.stiffness * q - spring.preload) * q;
        size += 0.5 * spring.stiffness * q * q + std::abs(spring.preload * q);
        continue;
      }
      const Moving &a = now_.bodies[spring.first], &b = now_.bodies[spring.second];
      const double length = (b.p + b.R * spring.point_second - a.p - a.R * spring.point_first).norm();
      stored += 0.5 * spring.stiffness * std::pow(length - spring.free_length, 2);
      size += 0.5 * spring.stiffness * (length * length + spring.free_length * spring.free_length);
    }
    for (const ForceElement& element : m.force_elements) {
      if (element.is_damper()) continue;
      const model::ForceLawOf<double> law(element.table);
      double energy = 0;
      if (element.is_in_joint()) {
        energy = -law.energy(r.joint_position(k_, element.coordinate));
      } else {
        const Moving &a = now_.bodies[element.first], &b = now_.bodies[element.second];
        energy = law.energy((b.p + b.R * element.point_second - a.p - a.R * element.point_first).norm());
      }
      stored += energy, size += std::abs(energy);
    }
    see("potential energy", std::abs(stored - r.potential_energy(k_, 0)) / (size + 1e-300));
    double power = 0, most = std::abs(energy_rate_);
    const auto supply = [&](double p) { power += p, most += std::abs(p); };
    for (std::size_t b = 1; b < now_.bodies.size(); ++b) {
      const Moving& body = now_.bodies[b];
      const Vector3 w = body.angular_velocity(), v = body.dp - w.cross(body.p);
      for (const auto* all : {&weights_, &loads_, &springs_}) supply((*all)[b].force.dot(v) + (*all)[b].moment.dot(w));
    }
    for (std::size_t a = 0; a < m.actuators.size(); ++a)
      supply(r.torque(k_, static_cast<long>(a)) * r.joint_velocity(k_, m.actuators[a]));
    for (const Spring& spring : m.springs)
      if (spring.is_joint_spring())
        supply((spring.preload - spring.stiffness * r.joint_position(k_, spring.coordinate)) *
               r.joint_velocity(k_, spring.coordinate));
    for (const ForceElement& element : m.force_elements)
      if (element.is_in_joint())
        supply(model::ForceLawOf<double>(element.table).force(r.joint_position(k_, element.coordinate)) *
               r.joint_velocity(k_, element.coordinate));
    for (const Friction& friction : m.friction) {
      const double rate = r.joint_velocity(k_, friction.coordinate);
      supply(-friction.viscous * rate * rate - friction.dry_friction(rate < 0 ? -1 : 1) * std::abs(rate));
    }
    // what comes and goes in the whole run: at rest and where nothing accelerates there is nothing to compare with
    const double whole = r.kinetic_energy.maxCoeff() / run_.trajectory.duration;
    see("power balance",
        std::abs(power - energy_rate_) / (most + whole + 1e-9 * force_ * length_ / run_.trajectory.duration));
  }

  /// Along a joint's own motion only its motor, its springs and its friction act.
  void free_motions() const {
    const Mechanism& m = run_.mechanism;
    std::set<int> geared;
    for (const Coupling& coupling : m.couplings) {
      geared.insert(coupling.follower);
      for (const model::CoordinateTerm& term : coupling.leader.terms) geared.insert(term.coordinate);
    }
    for (const Disc& disc : m.discs)
      for (const model::CoordinateTerm& term : disc.follows.terms) geared.insert(term.coordinate);
    const VectorX q = run_.result.joint_position.row(k_).transpose();
    for (int c = 0; c < static_cast<int>(m.coordinates.size()); ++c) {
      if (geared.count(c)) continue;
      const int j = m.coordinates[c].joint;
      double passed = along(m.joints[j], j, c - m.coordinates[c].index, c, q);
      for (std::size_t a = 0; a < m.actuators.size(); ++a)
        if (m.actuators[a] == c) passed -= run_.result.torque(k_, static_cast<long>(a));
      for (const Spring& spring : m.springs)
        if (spring.coordinate == c) passed += spring.stiffness * q[c] - spring.preload;
      for (const ForceElement& element : m.force_elements)
        if (element.coordinate == c) passed -= model::ForceLawOf<double>(element.table).force(q[c]);
      for (const Friction& friction : m.friction) {
        if (friction.coordinate != c) continue;
        const double rate = run_.result.joint_velocity(k_, c);
        const double fastest = run_.result.joint_velocity.row(k_).cwiseAbs().maxCoeff();
        const bool rests = std::abs(rate) <= 1e-10 * std::max(fastest, 1 / run_.trajectory.duration);
        passed += friction.viscous * rate + (rests ? 0 : std::copysign(friction.dry_friction(rate < 0 ? -1 : 1), rate));
      }
      const bool slides = m.coordinates[c].kind == CoordinateKind::length;
      see("effort along " + m.coordinates[c].name, std::abs(passed) / (force_ * (slides ? 1 : length_)));
    }
  }

 private:
  /// Power of the joint's reaction per unit rate of its coordinate c, by differences of the joint's displacement.
  double along(const Joint& joint, int j, int begin, int c, VectorX q) const {
    const bool planar = run_.result.axes == 2;
    constexpr double h = 1e-3;
    const auto at = [&](double x) {
      VectorX there = q;
      there[c] += x;
      return displacement(joint, planar, there.data() + begin);
    };
    const Pose here = at(0), a = at(h), b = at(-h), aa = at(2 * h), bb = at(-2 * h);
    const Vector3 slide = (8 * (a.p - b.p) - (aa.p - bb.p)) / (12 * h);
    const Matrix3 W = (8 * (a.R - b.R) - (aa.R - bb.R)) / (12 * h) * here.R.transpose();
    const Matrix3& R = run_.poses[k_][joint.first].R;
    return run_.row(run_.result.joint_force, k_, j).dot(R * slide) +
           run_.moment(run_.result.joint_moment, k_, j).dot(R * Vector3(W(2, 1), W(0, 2), W(1, 0)));
  }
  double in_space(const Vector3& f) const { return run_.result.axes == 2 ? f.head<2>().norm() : f.norm(); }
  double turning(const Vector3& m) const { return run_.result.axes == 2 ? std::abs(m.z()) : m.norm(); }
  void see(const std::string& law, double error) const { see(law, error, tolerance_); }
  void see(const std::string& law, double error, double allowed) const {
    findings_.see(law + " at sample " + std::to_string(k_), error, std::max(allowed, tolerance_ / 1e3));
  }

  const Run& run_;
  const std::vector<Element>& parts_;
  long k_;
  double tolerance_;
  Instant now_;
  Findings& findings_;
  std::vector<Total> rates_, weights_, loads_, springs_, joints_;
  Vector3 com_ = Vector3::Zero(), momentum_ = Vector3::Zero();
  double mass_ = 0, energy_ = 0, energy_rate_ = 0, potential_ = 0, potential_size_ = 0;
  double force_ = 0, speed_ = 0, length_ = 1;
};

}  // namespace

void judge_instants(const Run& run, int instants, Findings& findings, double tolerance) {
  const std::vector<Element> parts = elements(run.mechanism);
  for (int i = 0; i < instants && findings.none(); ++i) {
    const Books books(run, parts, i * (run.samples() - 1) / std::max(1, instants - 1), tolerance, findings);
    books.loops();
    books.bodies();
    books.sums();
    books.energies();
    books.free_motions();
  }
}

}  // namespace laws
