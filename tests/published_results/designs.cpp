#include "designs.hpp"

#include "balance/interface/specification/read_spec.hpp"

#include <doctest/doctest.h>
#include <fmt/format.h>

namespace published {

balance::DesignSpace space_of(const std::string& file) {
  return balance::read_design_space_file(std::string(BALANCE_CONFIGS "/") + file);
}

balance::DesignSpace space_of_text(const std::string& text, const Numbers& numbers) {
  balance::ReadOptions options;
  for (const auto& [name, value] : numbers) options.set.emplace_back(name, fmt::format("{:.17g}", value));
  return balance::read_design_space(text, "test.yaml", options);
}

DesignReport designed(const balance::DesignSpace& space, balance::DesignStudyOptions options) {
  options.compare_trajectories = false;
  return balance::run_design_study(space, options);
}

DesignReport balanced(const balance::DesignSpace& space, const balance::DesignStudyOptions& options) {
  DesignReport report = designed(space, options);
  REQUIRE_MESSAGE(report.outcome.status == DesignStatus::balanced,
                  space.start.mechanism.name << ": " << report.outcome.reason);
  return report;
}

double found(const DesignReport& report, const std::string& path) {
  for (std::size_t k = 0; k < report.free_numbers.size(); ++k)
    if (report.free_numbers[k].key_path == path) return report.outcome.x[static_cast<long>(k)];
  FAIL("no free number " << path);
  return 0;
}

Trajectory wander(const Mechanism& mechanism, const VectorX& home, double reach, std::mt19937& random, long samples) {
  constexpr int values = 8;
  balance::trajectory::TablePath table;
  for (int k = 0; k < values; ++k) {
    table.time.push_back(0.15 * k);
    table.values.emplace_back();
    for (const double angle : home) table.values.back().push_back(angle + reach * draw(random, -1, 1));
  }
  Trajectory t;
  t.name = "wander";
  t.drive = balance::DriveKind::joints;
  t.samples = samples;
  for (std::size_t k = 0; k < mechanism.actuators.size(); ++k)
    t.from.joints.push_back({mechanism.actuators[k], table.values.front()[k]});
  t.path = std::move(table);
  return t;
}

Trajectory wander(const balance::Study& study, const std::string& about, double reach, std::mt19937& random,
                  long samples) {
  const RunResult middle = run(study.mechanism, make_trajectory(study, about, 3));
  VectorX home(static_cast<long>(study.mechanism.actuators.size()));
  for (long k = 0; k < home.size(); ++k)
    home[k] = middle.joint_position(1, study.mechanism.actuators[static_cast<std::size_t>(k)]);
  return wander(study.mechanism, home, reach, random, samples);
}

double largest(const balance::Samples& values) { return values.cwiseAbs().maxCoeff(); }

}  // namespace published
