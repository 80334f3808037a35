/// Compares balance with other libraries for multibody dynamics on the same states of the same mechanisms, or times them.
/// The self-test asks that a body whose mass, centre of mass and inertia are slightly wrong is found out by all of them.

#include "agreement.hpp"
#include "timing.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace balance::peers {
namespace {

/// All formulations are exact. Balance closes loops to 1e-12 of the mechanism's size, and a state near a singularity
/// makes up to a hundred times that of it; round-off alone is a thousand times smaller.
constexpr double agreement_tolerance = 1e-9;

struct Count {
  int agree = 0, differ = 0, not_compared = 0;
  double largest = 0;  ///< relative difference of efforts and forces
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

bool is_agreement(const Agreement& found) {
  for (const double difference : {found.efforts, found.ground_force.value_or(0), found.ground_moment.value_or(0),
                                  found.closure, found.closure_rate})
    if (!(difference <= agreement_tolerance)) return false;
  return true;
}

void print_agreement(const PeerLibrary& library, const Agreement& found) {
  fmt::print("  {:8} efforts {:.1e}", library.name, found.efforts);
  if (found.ground_force) fmt::print(", ground force {:.1e}, moment {:.1e}", *found.ground_force, *found.ground_moment);
  fmt::print(", closure {:.1e}, its rate {:.1e}{}\n", found.closure, found.closure_rate,
             is_agreement(found) ? "" : fmt::format("  FAILED: more than {:.0e}", agreement_tolerance));
}

/// Whether a spec took an inertia as given although no body can have it: some libraries refuse it, rightly.
bool has_impossible_inertia(const RigidTree& tree) {
  for (const TreeBody& body : tree.bodies) {
    const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues();
    if (moments[0] + moments[1] < moments[2] * (1 - agreement_tolerance)) return true;
  }
  return false;
}

void compare(const PeerCase& subject, const PeerLibrary& library, Count& count) {
  if (!library.can_model(subject.tree)) return fmt::print("  {:8} no loops\n", library.name);
  try {
    const Agreement found = compare_with_peer(subject, *library.make(subject.tree));
    print_agreement(library, found);
    ++(is_agreement(found) ? count.agree : count.differ);
    count.largest =
        std::max({count.largest, found.efforts, found.ground_force.value_or(0), found.ground_moment.value_or(0)});
  } catch (const NotComparable& reason) {
    fmt::print("  {:8} not compared: the mechanism {}\n", library.name, reason.what());
    ++count.not_compared;
  } catch (const std::exception& refusal) {
    const bool is_right = has_impossible_inertia(subject.tree);
    fmt::print("  {:8} {}: {}\n", library.name, is_right ? "not compared: no body has such an inertia" : "FAILED",
               refusal.what());
    ++(is_right ? count.not_compared : count.differ);
  }
}

/// @param k the body whose numbers change by a millionth
RigidTree disturb(RigidTree tree, std::size_t k) {
  constexpr double millionth = 1e-6;
  TreeBody& body = tree.bodies[k];
  body.mass *= 1 + millionth;
  body.com += millionth * Vector3(1, 2, 3);
  body.inertia *= 1 + millionth;
  return tree;
}

/// Every disturbed body must be found out by every library that agreed without the disturbance.
void test_sensitivity(const PeerCase& subject, const PeerLibrary& library, Count& count) {
  if (!library.can_model(subject.tree)) return;
  for (std::size_t k = 0; k < subject.tree.bodies.size(); ++k) {
    const bool is_found_out = !is_agreement(compare_with_peer(subject, *library.make(disturb(subject.tree, k))));
    if (!is_found_out)
      fmt::print("{}, {}: FAILED: a wrong body {} of the tree is not found out\n", subject.name, library.name, k);
    ++(is_found_out ? count.agree : count.differ);
  }
}

enum class Task { compare, time, self_test };

int run(const std::vector<std::string>& specs, Task task) {
  const std::vector<PeerLibrary> libraries = {mujoco_library(), dart_library(), simbody_library(), kdl_library()};
  std::vector<PeerCase> subjects;
  Count count;
  for (const std::string& spec : specs) {
    if (std::optional<PeerCase> subject = read_case(spec))
      subjects.push_back(std::move(*subject));
    else
      ++count.not_compared;
  }
  if (task == Task::time) {
    print_times(subjects, libraries);
    return count.not_compared == 0 ? 0 : 1;
  }
  for (const PeerCase& subject : subjects) {
    if (task == Task::compare)
      fmt::print("{}, {}: {} states, {} motions, {} cut joints\n", subject.name, subject.motion.name, subject.x.rows(),
                 subject.tree.motion_count(), subject.tree.cut_joints.size());
    for (const PeerLibrary& library : libraries)
      task == Task::compare ? compare(subject, library, count) : test_sensitivity(subject, library, count);
  }
  if (task == Task::compare)
    fmt::print("{} not compared; the largest difference is {:.1e}, of at most {:.0e}\n", count.not_compared,
               count.largest, agreement_tolerance);
  fmt::print("{}{} passed, {} failed\n", task == Task::self_test ? "self-test: " : "", count.agree, count.differ);
  return count.differ == 0 && count.agree > 0 ? 0 : 1;
}

}  // namespace
}  // namespace balance::peers

int main(int argc, char** argv) {
  using balance::peers::Task;
  std::vector<std::string> specs(argv + 1, argv + argc);
  Task task = Task::compare;
  if (!specs.empty() && (specs.front() == "--time" || specs.front() == "--self-test")) {
    task = specs.front() == "--time" ? Task::time : Task::self_test;
    specs.erase(specs.begin());
  }
  if (specs.empty() || specs.front().starts_with('-')) {
    std::fputs("usage: compare_peers [--time | --self-test] SPEC…\n", stderr);
    return 2;
  }
  try {
    return balance::peers::run(specs, task);
  } catch (const std::exception& error) {
    fmt::print(stderr, "compare_peers: {}\n", error.what());
    return 1;
  }
}
