#include "balance/natural/simulation.hpp"

#include "balance/motion/wording.hpp"

#include <stdexcept>

namespace balance::natural {

struct NaturalSimulation::Parts {
  Mechanism mechanism, carrying;  ///< as stated; as it is in the present stretch
  NaturalModel model;
  NaturalCompiledTrajectory plan;
  std::optional<NaturalStepper> stepper;
  std::optional<NaturalSampleEvaluator> observer;
  Vector3 about = Vector3::Zero();
};

NaturalSimulation::NaturalSimulation(const Mechanism& mechanism, const Trajectory& trajectory,
                                     const InitialCoordinates& start)
    : parts_(std::make_unique<Parts>()) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  if (has_velocity_constraints(mechanism))
    throw std::invalid_argument("natural coordinates know no constraints on speeds");
  Parts& p = *parts_;
  p.mechanism = mechanism;
  p.model = build_model(p.mechanism, prescribed_coordinates(trajectory), has_tool_angle(mechanism, trajectory), start);
  p.plan = compile_natural_trajectory(p.mechanism, p.model, trajectory);
  outcome_ = p.plan.outcome;
  if (outcome_.status != MotionStatus::done) return;
  p.about = trajectory.about;
  p.observer.emplace(p.mechanism, p.model, p.plan.freedoms, p.about);
  if (!p.observer->mismatch().empty()) {
    outcome_ = {MotionStatus::mismatch, 0, p.observer->mismatch(), {}};
    return;
  }
  p.stepper.emplace(p.model, make_drive_rows(p.mechanism, p.model, p.plan.quantities), *p.plan.schedule,
                    p.plan.freedoms);
}

NaturalSimulation::~NaturalSimulation() = default;

const PrescribedMotion& NaturalSimulation::schedule() const { return parts_->plan.schedule.value(); }

int NaturalSimulation::freedoms() const { return parts_->plan.freedoms; }

const std::vector<std::string>& NaturalSimulation::notes() const { return parts_->observer.value().notes(); }

bool NaturalSimulation::begin() {
  const Parts& p = *parts_;
  parts_->stepper.value().set_actuation_matrix([&p](const NaturalCoordinates& position) {
    return p.observer->actuation_matrix(p.stepper->equations(), position);
  });
  if (parts_->stepper->begin(p.plan.start)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

bool NaturalSimulation::advance(double time) {
  if (parts_->stepper.value().advance(time)) return true;
  outcome_ = parts_->stepper->outcome();
  return false;
}

double NaturalSimulation::time() const { return parts_->stepper.value().time(); }

void NaturalSimulation::update_accelerations(Side side) { parts_->stepper.value().accelerate(side); }

/// The mass matrix is constant within a stretch.
void NaturalSimulation::apply_payloads(const PayloadIntervals& stretches, int stretch) {
  Parts& p = *parts_;
  if (!has_temporary_payloads(p.mechanism)) return;
  p.carrying = mechanism_in_interval(p.mechanism, stretches, stretch);
  p.model.mass.clear();
  p.model.rotors.clear();
  p.model.ground_disc_moment = 0;
  add_masses(p.carrying, p.model);
  p.observer.emplace(p.carrying, p.model, p.plan.freedoms, p.about);
}

double NaturalSimulation::speed_of(BodyId body, const Vector3& place) const {
  const NaturalModel& model = parts_->model;
  const AffineForm form = model.bodies[static_cast<std::size_t>(body)].place(to_complex(place, model.length()));
  return model.length() * std::abs(form.rate(parts_->stepper.value().state().velocity));
}

double NaturalSimulation::angular_speed_of(BodyId body) const {
  return std::abs(parts_->stepper.value().angular_velocity(body));
}

bool NaturalSimulation::observe() {
  Parts& p = *parts_;
  if (p.observer.value().observe(p.stepper.value())) return true;
  outcome_ = make_actuation_singularity_outcome(time(), "");
  return false;
}

const Sample& NaturalSimulation::last() const { return parts_->observer.value().last(); }

int NaturalSimulation::iterations() const { return parts_->stepper.value().iterations(); }

}  // namespace balance::natural
