// Nothing drives, nothing rubs: energy stays, momentum stays where nothing takes it, the film runs backwards.

#include "plant_cases.hpp"

#include <cmath>
#include <cstdlib>

using namespace plants;

namespace {

struct Free {
  double drift = 0, closure = 0, span = 0;  ///< relative, scaled, [J]
  MotionOutcome outcome;
};

/// Unforced motion; the drift is measured against the range of the kinetic energy.
Free released(const Mechanism& mechanism, const Known& state, double duration, int looks) {
  PlantOptions options;
  options.relative_tolerance = options.absolute_tolerance = 1e-13;
  Plant plant(mechanism, options);
  Free out;
  out.outcome = plant.start(0, state.q, state.dq);
  const VectorX none = nothing(mechanism);
  double start = 0, least = 1e300, most = -1e300, worst = 0;
  for (int k = 0; k <= looks && out.outcome.status == MotionStatus::done; ++k) {
    if (k > 0) out.outcome = plant.advance(duration * k / looks, none);
    const Sample& seen = plant.observe(none);
    const double energy = seen.kinetic_energy + seen.potential_energy;
    if (k == 0) start = energy;
    worst = std::max(worst, std::abs(energy - start));
    least = std::min(least, seen.kinetic_energy), most = std::max(most, seen.kinetic_energy);
    out.closure = std::max(out.closure, seen.closure_residual);
  }
  out.span = most - least;
  out.drift = worst / most;
  return out;
}

/// How long to look [s]: as long as asked for by a campaign, else as given.
double seconds(double usual) {
  const char* asked = std::getenv("BALANCE_FREE_SECONDS");
  return asked ? std::atof(asked) : usual;
}

void check_energy(const std::string& file, double part, double usual) {
  CAPTURE(file);
  const double duration = seconds(usual);
  const Study study = config(file);
  const Free run = released(conservative(study.mechanism), moment_of(study, part), duration, 50);
  CHECK_MESSAGE(run.outcome.status == MotionStatus::done, run.outcome.reason);
  CHECK(run.drift < 1e-8);
  CHECK(run.closure < 1e-11);
  CHECK(run.span > 0);
  MESSAGE(file << ": energy " << run.drift << ", closure " << run.closure << " over " << duration << " s");
}

}  // namespace

TEST_CASE("unforced motion without friction keeps its energy and its loops closed") {
  check_energy("double-pendulum.yaml", 0.5, 2);
  check_energy("four-bar.yaml", 0.5, 1);
  check_energy("5r.yaml", 0.5, 0.5);
  check_energy("3rrr.yaml", 0.5, 0.3);
  check_energy("bricard.yaml", 0.5, 1);
  check_energy("spatial-rrr.yaml", 0.5, 2);
}

TEST_CASE("every config let go keeps its energy until a singularity, if it meets one, ends the motion") {
  for (const std::string& file : specs()) {
    CAPTURE(file);
    const Study study = config(file);
    const Known state = moment_of(study, 0.3);
    const double length = characteristic_length(study.mechanism);
    double speed = 1e-9;
    for (Eigen::Index c = 0; c < state.dq.size(); ++c)
      if (std::isfinite(state.dq[c]))
        speed = std::max(speed, std::abs(state.dq[c]) /
                                    (study.mechanism.coordinates[c].kind == CoordinateKind::length ? length : 1));
    const Free run = released(conservative(study.mechanism), state, seconds(std::min(0.3, 1 / speed)), 5);
    const bool singular = run.outcome.status == MotionStatus::constraint_singularity;
    CHECK_MESSAGE((run.outcome.status == MotionStatus::done || singular), run.outcome.reason);
    CHECK(run.drift < (singular ? 1e-6 : 1e-8));
    CHECK(run.closure < 1e-11);
    if (singular) MESSAGE(file << ": " << run.outcome.reason);
  }
}
