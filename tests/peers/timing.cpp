#include "timing.hpp"

#include "peer_efforts.hpp"

#include "balance/foundation/base/instruction_set.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace balance::peers {
namespace {

constexpr int rounds = 15;
constexpr double min_round_time = 0.01;  ///< per contender [s]

/// Evaluates every state once, in order or, every second time, backwards: the next state is always near the last.
using Pass = std::function<void(bool backwards)>;

struct Contender {
  std::string name;
  Pass pass;        ///< none: it cannot
  std::string why;  ///< it cannot
  int passes = 2;
  double min_time = 1e300;  ///< per pass [s]
};

/// Processor time of the passes, which others on the machine disturb least.
double measure(Contender& contender) {
  const std::clock_t begin = std::clock();
  for (int k = 0; k < contender.passes; ++k) contender.pass(k % 2 == 1);
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// An even number of passes that takes long enough to be measured.
void set_passes(Contender& contender) {
  while (measure(contender) < min_round_time) contender.passes *= 2;
}

/// Calls evaluate(q, dq, ddq) with every row, in order or backwards.
template <class Evaluate>
void visit_states(const Samples& q, const Samples& dq, const Samples& ddq, bool backwards, Evaluate&& evaluate) {
  const Eigen::Index rows = q.rows();
  VectorX q_row, dq_row, ddq_row;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const Eigen::Index row = backwards ? rows - 1 - k : k;
    q_row = q.row(row);
    dq_row = dq.row(row);
    ddq_row = ddq.row(row);
    evaluate(q_row, dq_row, ddq_row);
  }
}

/// The mechanism's own independent coordinates of all states.
struct States {
  Samples q, dq, ddq;

  States(const RunResult& run, const std::vector<std::string>& independent) {
    const auto count = static_cast<Eigen::Index>(independent.size());
    for (Samples* samples : {&q, &dq, &ddq}) samples->resize(run.time.size(), count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto at = std::find(run.coordinate_names.begin(), run.coordinate_names.end(), independent[k]);
      const Eigen::Index column = at - run.coordinate_names.begin();
      q.col(k) = run.joint_position.col(column);
      dq.col(k) = run.joint_velocity.col(column);
      ddq.col(k) = run.joint_acceleration.col(column);
    }
  }
};

Contender balance_one_by_one(const PeerCase& subject) {
  const auto engine = std::make_shared<InverseDynamics>(subject.mechanism);
  const States states(subject.run, engine->independent());
  return {"balance", [=, effort = VectorX(subject.run.torque.cols())](bool backwards) mutable {
            visit_states(states.q, states.dq, states.ddq, backwards,
                         [&](const VectorX& q, const VectorX& dq, const VectorX& ddq) {
                           if (engine->efforts(q, dq, ddq, effort).status != MotionStatus::done)
                             throw std::runtime_error("balance finds no efforts");
                         });
          }};
}

/// Along the trajectory, the positions found and every quantity of the result file computed.
Contender balance_simulate(const PeerCase& subject) {
  return {"balance simulate", [&subject](bool) {
            if (simulate(subject.mechanism, subject.motion).outcome.status != MotionStatus::done)
              throw std::runtime_error("balance finds no motion");
          }};
}

Contender peer_contender(const PeerCase& subject, const PeerLibrary& library) {
  const std::string name = library.name + " " + library.version;
  if (!library.can_model(subject.tree)) return {name, nullptr, "no loops"};
  std::shared_ptr<Peer> peer;
  std::shared_ptr<PeerEfforts> efforts;
  try {
    peer = library.make(subject.tree);
    efforts =
        std::make_shared<PeerEfforts>(subject.tree, *peer, subject.x.row(0), subject.dx.row(0), subject.ddx.row(0));
  } catch (const NotComparable&) {
    return {name, nullptr, "efforts not unique"};
  } catch (const std::exception&) {
    return {name, nullptr, "refuses it"};
  }
  return {name, [peer, efforts, &subject](bool backwards) {  // the peer is kept alive
            visit_states(
                subject.x, subject.dx, subject.ddx, backwards,
                [&](const VectorX& x, const VectorX& dx, const VectorX& ddx) { efforts->compute(x, dx, ddx); });
          }};
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

void print_machine() {
  std::string sets;
  for (const InstructionSet set : list_instruction_sets())
    sets += (sets.empty() ? "" : ", ") + std::string(instruction_set_name(set));
  fmt::print("{}, {} hardware threads ({}); g++ {}, {}\n\n", processor_name(), std::thread::hardware_concurrency(),
             sets, __VERSION__, BALANCE_BUILD_TYPE);
}

void print_head(const std::vector<Contender>& contenders) {
  fmt::print("| mechanism |");
  for (const Contender& contender : contenders) fmt::print(" {} |", contender.name);
  fmt::print("\n| --- |");
  for (std::size_t k = 0; k < contenders.size(); ++k) fmt::print(" --- |");
  fmt::print("\n");
}

void print_row(const PeerCase& subject, const std::vector<Contender>& contenders) {
  fmt::print("| {} |", subject.name);
  const auto states = static_cast<double>(subject.x.rows());
  for (const Contender& contender : contenders) {
    const double time = 1e6 * contender.min_time / states;
    if (!contender.pass)
      fmt::print(" {} |", contender.why);
    else if (&contender == &contenders.front())
      fmt::print(" {:.3g} |", time);
    else
      fmt::print(" {:.3g} ({:.2g}) |", time, contender.min_time / contenders.front().min_time);
  }
  fmt::print("\n");
}

}  // namespace

void print_times(const std::vector<PeerCase>& subjects, const std::vector<PeerLibrary>& libraries) {
  print_machine();
  for (const PeerCase& subject : subjects) {
    std::vector<Contender> contenders = {balance_one_by_one(subject), balance_simulate(subject)};
    for (const PeerLibrary& library : libraries) contenders.push_back(peer_contender(subject, library));
    for (Contender& contender : contenders)
      if (contender.pass) set_passes(contender);
    for (int round = 0; round < rounds; ++round)  // in turns: what slows the machine for a while slows all alike
      for (Contender& contender : contenders)
        if (contender.pass) contender.min_time = std::min(contender.min_time, measure(contender) / contender.passes);
    if (&subject == &subjects.front()) print_head(contenders);
    print_row(subject, contenders);
  }
}

}  // namespace balance::peers
