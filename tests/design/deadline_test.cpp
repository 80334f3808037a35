// Nothing is followed beyond a deadline, and nothing is left of one behind its scope.

#include "balance/foundation/base/cpu_time.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "load_cases.hpp"

using namespace load_cases;
using balance::Deadline;
using balance::DeadlineExceeded;
using balance::MotionStatus;

namespace {

DesignSpace read_config(const std::string& name) { return balance::read_design_space(file_text(name), name); }

MotionStatus simulated(const DesignSpace& space) {
  return balance::simulate(space.start.mechanism, space.start.trajectories.front()).outcome.status;
}

}  // namespace

TEST_CASE("a motion with loops ends at the deadline, and the earliest of several counts") {
  const DesignSpace space = read_config("5r-design.yaml");
  {
    const Deadline late(1e6);
    CHECK(simulated(space) == MotionStatus::done);
    {
      const Deadline over(0), later(1e6);
      CHECK_THROWS_AS(simulated(space), DeadlineExceeded);
    }
    CHECK(simulated(space) == MotionStatus::done);
  }
  CHECK(simulated(space) == MotionStatus::done);
}

TEST_CASE("a design whose motions cannot be tried in time says so instead of taking them for impossible") {
  const DesignSpace space = read_config("5r-design.yaml");
  const Deadline over(0);
  CHECK_THROWS_AS(find_design(space), DeadlineExceeded);
}
