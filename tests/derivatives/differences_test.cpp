// Derivatives of whole runs and of their figures are what differences of runs come to.

#include "../sampling.hpp"
#include "numbers.hpp"

#include "balance/interface/specification/read_spec.hpp"
#include "balance/mechanics/derivatives/run_gradient.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <random>

using namespace balance;
using namespace balance::derivatives;

namespace {

constexpr double step = 3e-4;  // of a number, by its size or the mechanism's length

std::vector<std::string> config_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The runs with one number moved by −2, −1, 1 and 2 steps; nothing if one of them cannot be.
std::optional<std::vector<RunResult>> neighbours(const Mechanism& mechanism, const Trajectory& trajectory,
                                                 const gradients::Number& number) {
  std::vector<RunResult> runs;
  for (const double place : {-2., -1., 1., 2.}) {
    Mechanism other = mechanism;
    number.in(other) += place * step * number.scale;
    runs.push_back(simulate(other, trajectory));
    if (runs.back().outcome.status != MotionStatus::done) return {};
  }
  return runs;
}

/// Fourth-order difference of what `read` reads off a run.
template <class Read>
auto difference(const std::vector<RunResult>& runs, double h, const Read& read) {
  return ((read(runs[0]) - read(runs[3]) + 8 * (read(runs[2]) - read(runs[1]))) / (12 * h));
}

struct Compared {
  const char* name;
  Samples RunResult::*array;
};
constexpr Compared compared[] = {{"torque", &RunResult::torque},
                                 {"shaking_force", &RunResult::shaking_force},
                                 {"shaking_moment", &RunResult::shaking_moment},
                                 {"com_position", &RunResult::com_position},
                                 {"joint_force", &RunResult::joint_force},
                                 {"joint_velocity", &RunResult::joint_velocity},
                                 {"joint_acceleration", &RunResult::joint_acceleration},
                                 {"kinetic_energy", &RunResult::kinetic_energy},
                                 {"potential_energy", &RunResult::potential_energy}};

const Metric& metric_of(const RunResult& run, const std::string& quantity) {
  return *std::find_if(run.metrics.begin(), run.metrics.end(),
                       [&](const Metric& metric) { return metric.quantity == quantity; });
}

/// A peak has a slope where its place does not change from run to run, and where no other is as high: on both sides of a jump the same
/// is often felt.
void check_figures(const std::string& name, const FigureGradients& figures, std::size_t k,
                   const std::vector<RunResult>& runs, double h, bool jumps) {
  for (const FigureGradient& figure : figures.figures) {
    const auto metric = [&](const RunResult& run) -> const Metric& { return metric_of(run, figure.quantity); };
    const double round_off = 1e4 * metric(runs[0]).round_off;
    // a magnitude has a kink where it vanishes, as in a mechanism that is balanced
    const bool kink = std::any_of(runs.begin(), runs.end(), [&](const RunResult& run) {
      return metric(run).rms <= round_off || std::abs(metric(run).rms - figure.rms) > 0.05 * figure.rms;
    });
    if (kink) continue;
    const double rms = difference(runs, h, [&](const RunResult& run) { return metric(run).rms; });
    const double scale = std::max(std::abs(rms), figure.rms);
    CHECK_MESSAGE(std::abs(figure.d_rms[k] - rms) < 1e-5 * scale + round_off / h, name << ": rms " << figure.quantity);
    const bool stays = std::all_of(runs.begin(), runs.end(), [&](const RunResult& run) {
      return metric(run).peak_time == metric(runs[0]).peak_time;
    });
    const double peak = difference(runs, h, [&](const RunResult& run) { return metric(run).peak; });
    if (stays && !jumps && figure.quantity != "mobility")
      CHECK_MESSAGE(std::abs(figure.d_peak[k] - peak) < 1e-4 * std::max(std::abs(peak), figure.peak) + round_off / h,
                    name << ": peak " << figure.quantity << " " << figure.d_peak[k] << " is not " << peak);
  }
}

/// What differences of fourth order leave: h⁴ of the fifth derivative, and round-off of the runs over h. Numbers are moved by some ten-
/// thousandths, so that both are below 1e-7 of the quantity unless the mechanism is near a singularity.
void check_run(const std::string& name, const Mechanism& mechanism, const Trajectory& trajectory,
               std::mt19937& random) {
  const std::vector<gradients::Number> numbers = gradients::some_numbers(mechanism, numerics::dual_width, random);
  MechanismOf<DualNumber> duals = to_dual(mechanism);
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k].in_duals(duals).d[k] += 1;
  const RunGradient gradient = differentiate_run(duals, to_dual(trajectory));
  if (gradient.run.outcome.status != MotionStatus::done) return;
  const FigureGradients figures = differentiate_figures(gradient);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const auto runs = neighbours(mechanism, trajectory, numbers[k]);
    if (!runs) continue;
    const double h = step * numbers[k].scale;
    const std::string which = name + " by " + numbers[k].name;
    for (const auto& [what, array] : compared) {
      const Samples& now = gradient.run.*array;
      if (now.size() == 0) continue;
      const Samples slope =
          difference(*runs, h, [array](const RunResult& run) -> const Samples& { return run.*array; });
      double round_off = 0;  // of a run
      for (Eigen::Index c = 0; c < now.cols(); ++c)
        round_off = std::max(round_off, column_round_off(runs->front(), array, c));
      const double scale = std::max(slope.cwiseAbs().maxCoeff(), now.cwiseAbs().maxCoeff() / numbers[k].scale);
      const double off = (gradient.derivatives[k].*array - slope).cwiseAbs().maxCoeff();
      CHECK_MESSAGE(off <= 1e-5 * scale + 10 * round_off / h,
                    which << ": " << std::string(what) << " off by " << off << " of " << scale);
    }
    check_figures(which, figures, k, *runs, h, !find_acceleration_jumps(trajectory.law).empty());
  }
}

}  // namespace

TEST_CASE("derivatives of a run with respect to numbers of the mechanism are its differences: every config") {
  struct Motion {
    std::string file;
    std::size_t trajectory;
    sampling::Traits traits;
  };
  std::vector<Motion> motions;
  for (const std::string& file : config_names()) {
    const Study study = read_spec_file(file);
    for (std::size_t i = 0; i < study.trajectories.size(); ++i) {
      const Trajectory& t = study.trajectories[i];
      motions.push_back({file, i, sampling::traits_of(file, static_cast<int>(t.law.kind), static_cast<int>(t.drive))});
    }
  }
  std::mt19937 random(7);
  for (const Motion& motion :
       sampling::draw("runs with derivatives", motions, 0.1, [](const Motion& m) { return m.traits; })) {
    const Study study = read_spec_file(motion.file);
    Trajectory trajectory = study.trajectories[motion.trajectory];
    INFO(motion.file << ": " << trajectory.name);
    if (has_velocity_constraints(study.mechanism)) {  // all of the way decides about their motion
      CHECK_THROWS_AS(differentiate_run(to_dual(study.mechanism), to_dual(trajectory)), std::invalid_argument);
      continue;
    }
    trajectory.samples = 11;
    check_run(motion.file + ": " + trajectory.name, study.mechanism, trajectory, random);
  }
}
