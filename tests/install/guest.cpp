// Reads a spec, moves the mechanism and prints its peak shaking force: the library as a stranger uses it.
#include <balance/foundation/base/version.hpp>
#include <balance/interface/specification/read_spec.hpp>
#include <balance/motion/simulation/simulate.hpp>

#include <cstdio>

int main(int, char** arguments) {
  const balance::Study study = balance::read_spec_file(arguments[1]);
  const balance::RunResult result = balance::simulate(study.mechanism, study.trajectories.at(0));
  std::printf("balance %s, %s: %ld samples, peak shaking force %.4f N\n", balance::version(),
              study.mechanism.name.c_str(), static_cast<long>(result.time.size()),
              result.shaking_force.rowwise().norm().maxCoeff());
  return result.outcome.status == balance::MotionStatus::done ? 0 : 1;
}
