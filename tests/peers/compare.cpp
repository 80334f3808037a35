/// Compares balance with other libraries for multibody dynamics on the same states of the same mechanisms, or times them.

#include "agreement.hpp"
#include "timing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <optional>
#include <string>
#include <vector>

namespace balance::peers {
namespace {

/// All formulations are exact. Balance closes loops to 1e-12 of the mechanism's size, and a state near a singularity
/// makes more of that; round-off alone is a thousand times smaller.
constexpr double agreement_tolerance = 1e-10;

struct Count {
  int agree = 0, differ = 0, not_compared = 0;
};

/// @return nothing if the case is not compared, with its reason printed
std::optional<PeerCase> read_case(const std::string& path) {
  try {
    return read_peer_case(path);
  } catch (const NotComparable& reason) {
    fmt::print("{}: not compared: {}\n", path, reason.what());
    return {};
  }
}

bool is_within(double difference) { return std::isnan(difference) || difference <= agreement_tolerance; }

void print_agreement(const PeerLibrary& library, const Agreement& found, bool agrees) {
  fmt::print("  {:8} efforts {:.1e}", library.name, found.efforts);
  if (!std::isnan(found.ground_force))
    fmt::print(", ground force {:.1e}, moment {:.1e}", found.ground_force, found.ground_moment);
  fmt::print(", closure {:.1e}, its rate {:.1e}{}\n", found.closure, found.closure_rate,
             agrees ? "" : fmt::format("  FAILED: more than {:.0e}", agreement_tolerance));
}

void compare(const PeerCase& subject, const std::vector<PeerLibrary>& libraries, Count& count) {
  fmt::print("{}, {}: {} states, {} motions, {} cut joints\n", subject.name, subject.motion.name, subject.x.rows(),
             subject.tree.motion_count(), subject.tree.cut_joints.size());
  for (const PeerLibrary& library : libraries) {
    if (!library.has_loops && !subject.tree.cut_joints.empty()) {
      fmt::print("  {:8} no loops\n", library.name);
      continue;
    }
    try {
      const Agreement found = compare_with_peer(subject, *library.make(subject.tree));
      const bool agrees = !std::isnan(found.efforts) && is_within(found.efforts) && is_within(found.ground_force) &&
                          is_within(found.ground_moment) && is_within(found.closure) && is_within(found.closure_rate);
      print_agreement(library, found, agrees);
      ++(agrees ? count.agree : count.differ);
    } catch (const NotComparable& reason) {
      fmt::print("  {:8} not compared: the mechanism {}\n", library.name, reason.what());
      ++count.not_compared;
    } catch (const std::exception& refusal) {
      fmt::print("  {:8} FAILED: {}\n", library.name, refusal.what());
      ++count.differ;
    }
  }
}

int run(const std::vector<std::string>& specs, bool is_timed) {
  const std::vector<PeerLibrary> libraries = {mujoco_library(), dart_library(), simbody_library(), kdl_library()};
  std::vector<PeerCase> subjects;
  Count count;
  for (const std::string& spec : specs) {
    std::optional<PeerCase> subject = read_case(spec);
    if (!subject)
      ++count.not_compared;
    else if (is_timed)
      subjects.push_back(std::move(*subject));
    else
      compare(*subject, libraries, count);
  }
  if (is_timed) {
    print_times(subjects, libraries);
    return count.not_compared == 0 ? 0 : 1;
  }
  fmt::print("{} not compared\n{} passed, {} failed\n", count.not_compared, count.agree, count.differ);
  return count.differ == 0 && count.agree > 0 ? 0 : 1;
}

}  // namespace
}  // namespace balance::peers

int main(int argc, char** argv) {
  std::vector<std::string> specs(argv + 1, argv + argc);
  const bool is_timed = !specs.empty() && specs.front() == "--time";
  if (is_timed) specs.erase(specs.begin());
  if (specs.empty() || specs.front().starts_with('-')) {
    std::fputs("usage: compare_peers [--time] SPEC…\n", stderr);
    return 2;
  }
  try {
    return balance::peers::run(specs, is_timed);
  } catch (const std::exception& error) {
    fmt::print(stderr, "compare_peers: {}\n", error.what());
    return 1;
  }
}
