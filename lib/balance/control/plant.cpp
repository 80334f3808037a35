#include "balance/control/plant.hpp"

#include "balance/control/plant_engine.hpp"

#include <stdexcept>

namespace balance {

void PlantOptions::validate() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw std::invalid_argument(what);
  };
  require(relative_tolerance > 0 && relative_tolerance <= 1e-2, "relative_tolerance must lie in (0, 0.01]");
  require(absolute_tolerance > 0, "absolute_tolerance must be positive");
  require(max_step > 0, "longest_step must be positive");
  require(max_steps > 0, "most_steps must be positive");
  dynamics.validate();
}

Plant::Plant(const Mechanism& mechanism, const PlantOptions& options, const Vector3& about) {
  options.validate();
  dispatch_space(mechanism.space, [&]<class S>(S) { engine_ = make_plant<S>(mechanism, options, about); });
}

Plant::~Plant() = default;
Plant::Plant(Plant&&) noexcept = default;
Plant& Plant::operator=(Plant&&) noexcept = default;

MotionOutcome Plant::start(double time, const VectorX& position, const VectorX& velocity) {
  return engine_->start(time, position, velocity);
}
MotionOutcome Plant::advance(double time, const VectorX& efforts) { return engine_->advance(time, efforts); }
MotionOutcome Plant::advance(double time, const EffortProfile& course) { return engine_->advance(time, course); }
int Plant::freedoms() const { return engine_->freedoms(); }
const std::vector<CoordinateId>& Plant::independent() const { return engine_->independent(); }
double Plant::time() const { return engine_->time(); }
const VectorX& Plant::position() const { return engine_->position(); }
const VectorX& Plant::velocity() const { return engine_->velocity(); }
VectorX Plant::acceleration(const VectorX& efforts) { return engine_->acceleration(efforts); }
EquationOfMotion Plant::equation() { return engine_->equation(); }
const Sample& Plant::observe(const VectorX& efforts) { return engine_->observe(efforts); }
const TermMagnitudes& Plant::term_sizes() const { return engine_->term_sizes(); }
const TermMagnitudes& Plant::term_sizes_over_mobility() const { return engine_->term_sizes_over_mobility(); }
const PlantCost& Plant::cost() const { return engine_->cost(); }
const std::vector<std::string>& Plant::notes() const { return engine_->notes(); }

}  // namespace balance
