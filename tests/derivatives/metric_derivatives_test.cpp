// Derivatives of figures by the free numbers of a spec are what differences of its runs come to.

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/spec_figure_gradients.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>

using namespace balance;

namespace {

std::vector<std::string> config_files() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(BALANCE_CONFIGS))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The same with few samples, but so many that no places between them are needed.
DesignSpace coarse(DesignSpace space) {
  const auto recording = std::make_shared<study::Recording>(*space.recording);
  for (auto& trajectory : recording->trajectories) trajectory.samples = 41;
  for (Trajectory& trajectory : space.start.trajectories) trajectory.samples = 41;
  space.recording = recording;
  return space;
}

/// In general position, near the start where lengths are free: the mechanism must reach its motion.
VectorX somewhere(const DesignSpace& space, std::mt19937& random) {
  VectorX x = space.start_values();
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& number = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double target = std::uniform_real_distribution(number.lower, number.upper)(random);
    x[i] += 0.3 * (target - x[i]);
  }
  return x;
}

struct Differences {
  std::vector<RunResult> runs;  ///< moved by −2, −1, 1 and 2 steps
  double h = 0;
  bool done = true;

  template <class Read>
  double of(const Read& read) const {
    return (read(runs[0]) - read(runs[3]) + 8 * (read(runs[2]) - read(runs[1]))) / (12 * h);
  }
};

Differences moved(const DesignSpace& space, const VectorX& x, std::size_t trajectory, Eigen::Index number) {
  const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(number)];
  Differences out{{}, 2e-4 * (free.upper - free.lower)};
  for (const double place : {-2., -1., 1., 2.}) {
    VectorX there = x;
    there[number] += place * out.h;
    const study::DesignInstance trial = space.instantiate(there);
    out.runs.push_back(simulate(trial.mechanism, trial.trajectories[trajectory]));
    out.done = out.done && out.runs.back().outcome.status == MotionStatus::done;
  }
  return out;
}

/// Steps are a five-thousandth of a number's range: what fourth order leaves is below 1e-6 of a derivative, unless it has a kink there (a magnitude
/// that vanishes, another member that becomes the worst).
int compare(const std::string& name, const design::QuantityGradients& found, std::size_t q, Eigen::Index number,
            const Differences& near, bool jumps) {
  const auto metric = [q](const RunResult& run) -> const Metric& { return run.metrics[q]; };
  const double round_off = 1e4 * metric(near.runs[0]).round_off / near.h;
  INFO(name << ": " << found.quantity);
  REQUIRE(metric(near.runs[0]).quantity == found.quantity);
  const double rms = near.of([&](const RunResult& run) { return metric(run).rms; });
  const bool kink = std::any_of(near.runs.begin(), near.runs.end(), [&](const RunResult& run) {
    return metric(run).rms <= 1e4 * metric(run).round_off ||
           std::abs(metric(run).rms - found.rms.value) > 0.02 * found.rms.value;
  });
  if (kink) return 0;
  const double size = found.rms.value / near.h;
  CHECK(std::abs(found.rms.gradient[number] - rms) <= 1e-6 * std::abs(rms) + 1e-10 * size + round_off);
  const double peak = near.of([&](const RunResult& run) { return metric(run).peak; });
  const bool stays = std::all_of(near.runs.begin(), near.runs.end(), [&](const RunResult& run) {
    return metric(run).peak_time == metric(near.runs[0]).peak_time;
  });
  if (stays && !jumps && found.quantity != "mobility" && found.quantity.find('[') != std::string::npos)
    CHECK(std::abs(found.peak.gradient[number] - peak) <=
          1e-5 * std::abs(peak) + 1e-9 * found.peak.value / near.h + round_off);
  return 1;
}

constexpr double at_rest_energy =
    1e-12;  // of the torque times a radian: poses of a workspace are at rest but for round-off

/// The energy is a sum of magnitudes of powers and has a kink where one of them vanishes at a place: differences of two widths then
/// disagree.
bool kink_of_energy(const Differences& near) {
  const auto slope = [&](std::size_t a, std::size_t b) {
    return (near.runs[b].energy - near.runs[a].energy) / (a == 0 ? 4 : 2) / near.h;
  };
  const double wide = slope(0, 3), narrow = slope(1, 2);
  return std::abs(wide - narrow) > 1e-5 * std::abs(narrow) + 1e-10 * near.runs[0].energy / near.h;
}

int compare_all(const std::string& name, const DesignSpace& space, const VectorX& x, std::size_t trajectory) {
  const design::SpecFigureGradients slopes =
      design::compute_figure_gradients(space, x, space.start.trajectories[trajectory].name);
  if (slopes.outcome.status != MotionStatus::done) return 0;
  // on both sides of a jump the same peak is often felt
  const bool jumps = !balance::trajectory::find_acceleration_jumps(space.start.trajectories[trajectory].law).empty();
  int compared = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Differences near = moved(space, x, trajectory, i);
    if (!near.done) continue;
    const std::string which = name + ", " + slopes.quantities[0].quantity + " by " +
                              space.start.free_numbers[static_cast<std::size_t>(i)].key_path;
    for (std::size_t q = 0; q < slopes.quantities.size(); ++q)
      compared += compare(which, slopes.quantities[q], q, i, near, jumps);
    if (kink_of_energy(near)) continue;
    if (slopes.energy.value <= at_rest_energy * balance::numerics::max_abs(near.runs[0].torque)) continue;
    const double energy = near.of([](const RunResult& run) { return run.energy; });
    // samples whose power changes its sign from one step to the next are kinks as well, of the size of one sample's part of the sum
    CHECK_MESSAGE(
        std::abs(slopes.energy.gradient[i] - energy) <= 1e-4 * std::abs(energy) + 1e-9 * slopes.energy.value / near.h,
        which << ": energy " << slopes.energy.gradient[i] << " is not " << energy);
  }
  return compared;
}

/// The starter's four-bar with free lengths, weight per length and duration.
std::string free_four_bar() {
  std::string text = text_of(BALANCE_CONFIGS "/starters/four-bar.yaml");
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
  };
  replace("crank: 0.1 ", "crank: {free: [0.08, 0.12]} ");
  replace("coupler: 0.35", "coupler: {free: [0.3, 0.4]}");
  replace("rho: 4 ", "rho: {free: [2, 6]} ");
  replace("duration: 0.5", "duration: {free: [0.4, 0.6]}");
  return text;
}

}  // namespace

TEST_CASE("figures change with the free numbers of every config as their derivatives say") {
  std::mt19937 random(11);
  int compared = 0;
  for (const std::string& file : config_files()) {
    const DesignSpace space = coarse(read_design_space_file(file));
    if (space.start.free_numbers.empty()) continue;
    const VectorX x = somewhere(space, random);
    for (std::size_t t = 0; t < space.start.trajectories.size(); ++t)
      if (!is_mechanism_dependent(space.start.trajectories[t].law.kind))
        compared += compare_all(file + " " + space.start.trajectories[t].name, space, x, t);
  }
  CHECK(compared > 1000);
}

TEST_CASE("lengths, expressions over them and numbers of the motion have derivatives, too") {
  const DesignSpace space = coarse(read_design_space(free_four_bar(), "four-bar.yaml"));
  REQUIRE(space.start.free_numbers.size() == 8);
  std::mt19937 random(2);
  // what is a difference itself is right to 1e-8 of the figure's change over the range
  CHECK(compare_all("four-bar", space, somewhere(space, random), 0) > 100);
}

TEST_CASE("what cannot be differentiated is refused or says why") {
  const DesignSpace space = read_design_space_file(BALANCE_CONFIGS "/starters/four-bar.yaml");
  const VectorX x = space.start_values();
  CHECK_THROWS_AS(design::compute_figure_gradients(space, x, "elsewhere"), std::invalid_argument);
  CHECK_THROWS_AS(design::compute_figure_gradients(space, VectorX::Zero(2), "cycloid"), std::invalid_argument);
}
