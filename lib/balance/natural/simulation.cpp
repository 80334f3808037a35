#include "balance/natural/simulation.hpp"

#include "balance/motion/wording.hpp"

#include <stdexcept>

namespace balance::natural {

struct Simulation::Parts {
  Mechanism mechanism, carrying;  ///< as stated; as it is in the present stretch
  Model model;
  Plan plan;
  std::optional<Stepper> stepper;
  std::optional<Observer> observer;
  Vector3 about = Vector3::Zero();
};

Simulation::Simulation(const Mechanism& mechanism, const Trajectory& trajectory, const Start& start)
    : parts_(std::make_unique<Parts>()) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (binds_rates(mechanism)) throw std::invalid_argument("natural coordinates know no constraints on speeds");
  Parts& p = *parts_;
  p.mechanism = mechanism;
  p.model =
      build_model(p.mechanism, prescribed_coordinates(trajectory), speaks_of_tool_angle(mechanism, trajectory), start);
  p.plan = make_plan(p.mechanism, p.model, trajectory);
  outcome_ = p.plan.outcome;
  if (outcome_.status != MotionStatus::done) return;
  p.about = trajectory.about;
  p.observer.emplace(p.mechanism, p.model, p.plan.freedoms, p.about);
  if (!p.observer->mismatch().empty()) {
    outcome_ = {MotionStatus::mismatch, 0, p.observer->mismatch(), {}};
    return;
  }
  p.stepper.emplace(p.model, drive_rows(p.mechanism, p.model, p.plan.quantities), *p.plan.schedule, p.plan.freedoms);
}

Simulation::~Simulation() = default;

const Schedule& Simulation::schedule() const { return parts_->plan.schedule.value(); }

int Simulation::freedoms() const { return parts_->plan.freedoms; }

const std::vector<std::string>& Simulation::notes() const { return parts_->observer.value().notes(); }

bool Simulation::begin() {
  const Parts& p = *parts_;
  parts_->stepper.value().watch(
      [&p](const Coordinates& position) { return p.observer->held(p.stepper->equations(), position); });
  if (parts_->stepper->begin(p.plan.start)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

bool Simulation::advance(double time) {
  if (parts_->stepper.value().advance(time)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

double Simulation::time() const { return parts_->stepper.value().time(); }

void Simulation::accelerate(Side side) { parts_->stepper.value().accelerate(side); }

/// The mass matrix is constant within a stretch.
void Simulation::carry(const PayloadStretches& stretches, int stretch) {
  Parts& p = *parts_;
  if (!has_passing_payloads(p.mechanism)) return;
  p.carrying = within(p.mechanism, stretches, stretch);
  p.model.mass.clear();
  p.model.rotors.clear();
  p.model.resting_moment = 0;
  add_masses(p.carrying, p.model);
  p.observer.emplace(p.carrying, p.model, p.plan.freedoms, p.about);
}

double Simulation::speed_of(BodyId body, const Vector3& place) const {
  const Model& model = parts_->model;
  const Form form = model.bodies[static_cast<std::size_t>(body)].place(planar(place, model.length()));
  return model.length() * std::abs(form.rate(parts_->stepper.value().state().velocity));
}

double Simulation::turning_of(BodyId body) const { return std::abs(parts_->stepper.value().spin(body)); }

bool Simulation::observe() {
  Parts& p = *parts_;
  if (p.observer.value().observe(p.stepper.value())) return true;
  outcome_ = no_longer_held(time(), "");
  return false;
}

const Sample& Simulation::last() const { return parts_->observer.value().last(); }

int Simulation::iterations() const { return parts_->stepper.value().iterations(); }

}  // namespace balance::natural
