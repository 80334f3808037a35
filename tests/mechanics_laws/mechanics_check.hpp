#pragma once
/// A random mechanism before the laws of mechanics: everything that a run found, held against bodies walked to from joint to joint.

#include "random_mechanism_classes.hpp"
#include "runs.hpp"

#include <string>
#include <vector>

namespace laws {

enum class Judgement { passed, refused, failed };

/// Laws broken, each with how much and where.
class Findings {
 public:
  /// Not a number is worse than any.
  void see(const std::string& law, double error, double allowed) {
    if (!(error <= allowed)) add(law, error, allowed);
  }
  void say(const std::string& text) { texts_.push_back(text); }
  bool none() const { return texts_.empty(); }
  std::string text() const;

 private:
  void add(const std::string& law, double error, double allowed);
  std::vector<std::string> texts_;
};

struct Verdict {
  Judgement judgement = Judgement::failed;
  std::string reason;  ///< why it was refused, or which laws are broken
};

struct Thoroughness {
  long samples = 201;
  int instants = 9;
  bool elsewhere = true;     ///< run it displaced and in other units too
  bool conditions = true;    ///< balancing conditions against forces
  bool formulations = true;  ///< natural coordinates in the plane, forward dynamics everywhere
};

/// Runs a member, with shorter and shorter ways to go where the motion is refused, and holds it against the laws.
Verdict judge(Kind kind, std::uint32_t seed, const Thoroughness& thoroughness);

/// The laws of one moment: closed loops, free bodies, sums, energies, power, what joints pass on.
/// @param tolerance differences are good to 1e-10; the rest is for levers
void judge_instants(const Run& run, int instants, Findings& findings, double tolerance = 1e-7);
/// Rates of the joint coordinates over the samples.
void judge_rates(const Run& run, Findings& findings);
/// The regressor times the parameters against the recursion.
void judge_regressor(const Run& run, Findings& findings);
/// Displaced, and in other units.
void judge_elsewhere(const Run& run, Findings& findings);
/// The conditions of force and dynamic balance hold exactly for the masses that do not shake along this run.
void judge_conditions(const Run& run, int instants, Findings& findings);

/// The same motion and forces in natural coordinates (in the plane).
void judge_formulations(const Run& run, Findings& findings);
/// Forward dynamics turn the efforts found into the accelerations that they were found from.
void judge_forward(const Run& run, Findings& findings);

}  // namespace laws
