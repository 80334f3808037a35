#include "plot_runs.hpp"

#include "failure.hpp"
#include "simulate_options.hpp"

#include "balance/base/error.hpp"
#include "balance/simulation/simulate.hpp"

#include <optional>
#include <stdexcept>

namespace balance::app {
namespace {

struct SpecRun {
  std::string spec, trajectory;
};

/// Nothing if the name is none of a spec.
std::optional<SpecRun> spec_run_of(const std::string& name) {
  for (const std::string suffix : {".yaml", ".yml"}) {
    if (name.ends_with(suffix)) return SpecRun{name, ""};
    if (const std::size_t at = name.rfind(suffix + ":"); at != std::string::npos)
      return SpecRun{name.substr(0, at + suffix.size()), name.substr(at + suffix.size() + 1)};
  }
  return std::nullopt;
}

RunFile run(const SpecRun& wanted) {
  SimulateOptions options;
  options.spec.spec = wanted.spec;
  options.trajectory = wanted.trajectory;
  const Study study = read_study(options.spec);
  const Trajectory trajectory = choose_trajectory(options, study);
  RunFile run{.path = wanted.spec, .group = trajectory.name, .title = study.mechanism.name};
  try {
    run.result = simulate(study.mechanism, trajectory);
  } catch (const std::invalid_argument& error) {
    throw SpecError(
        {.place = {.file = study.spec_file, .key = "trajectories." + trajectory.name}, .message = error.what()});
  }
  if (run.result.outcome.status != MotionStatus::done) throw MotionFailure(run.result.outcome);
  return run;
}

}  // namespace

RunFile read_or_run(const std::string& name) {
  const std::optional<SpecRun> spec = spec_run_of(name);
  return spec ? run(*spec) : read_result_file(name);
}

}  // namespace balance::app
