#include "balance/design/discrete.hpp"

#include "balance/design/discrete_search.hpp"
#include "balance/design/figure_of_merit.hpp"
#include "balance/design/least_violation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace balance::designing {

namespace {

using Rank = SizedDesign::Rank;

/// For the solution that a search ends with, where it has used up its time [s].
constexpr double min_final_seconds = 0.2;

std::string several(int n, const char* one, const char* many) { return fmt::format("{} {}", n, n == 1 ? one : many); }

class Discrete {
 public:
  explicit Discrete(const DesignProblem& problem)
      : problem_(problem),
        budget_(problem.search.seconds, problem.watch),
        bounds_(problem_),
        search_(problem_, budget_, bounds_, steps_) {
    problem_.watch = [this](const SearchProgress&) { return !budget_.interrupted(); };
    if (const Conditions* all = bounds_.shared_conditions(Branching(problem_, 0).root()); all != nullptr)
      problem_.derive = [all = *all](const Mechanism&, const std::vector<Goal>&, const ConditionOptions&) {
        return all;
      };
  }

  DesignOutcome run() {
    const int offered = Branching::count_least(problem_);
    Walk walk = offered > 0 ? fewest(offered) : search_.run(Branching(problem_, 0), Wanted::exact);
    if (walk.best && walk.best->rank == Rank::exact) return finished(std::move(walk));
    const bool none = walk.closed && !budget_.stopped;
    std::string why = offered > 0 || problem_.choices.empty() ? "" : count_needed();
    Walk second = compromise(std::move(walk), offered);
    if (!second.best) return without_design();
    return compromised(std::move(second), none, std::move(why));
  }

 private:
  /// The least count with which there is an exact design.
  Walk fewest(int offered) {
    Walk walk;
    chosen_.least_proved = true;
    for (int count = 0; count <= offered; ++count) {
      walk = search_.run(Branching(problem_, count), Wanted::exact);
      if (walk.best && walk.best->rank == Rank::exact) {
        chosen_.least = count;
        return walk;
      }
      chosen_.least_proved = chosen_.least_proved && walk.closed && !budget_.stopped;
      if (budget_.stopped) break;
    }
    return walk;
  }

  /// Some count was asked for that is not enough: how many would be.
  std::string count_needed() {
    DesignProblem free = problem_;
    for (Choice& choice : free.choices) choice.most = -1;
    free.objective.reset();
    const int offered = Branching::count_least(free);
    DiscreteSearch search(free, budget_, bounds_, steps_);
    bool proved = true;
    int asked = 0;
    for (const Choice& choice : problem_.choices) asked += std::max(0, choice.most);
    for (int count = 0; count <= offered && !budget_.spent(); ++count) {
      const Walk walk = search.run(Branching(free, count), Wanted::exact);
      proved = proved && (walk.closed || walk.best) && !budget_.stopped;
      if (!walk.best || walk.best->rank != Rank::exact) continue;
      chosen_.least = count;
      chosen_.least_proved = proved;
      return fmt::format("no choice of {} {}; {} of them do{}", of_kinds(asked), met_by_one(), count,
                         proved ? ", and no fewer" : "");
    }
    return proved && !budget_.stopped ? fmt::format("no choice of {} {}, nor do all {} that are offered",
                                                    of_kinds(asked), met_by_one(), offered)
                                      : "";
  }

  std::string of_kinds(int count) const {
    std::string kinds;
    for (const Choice& choice : problem_.choices) kinds += (kinds.empty() ? "" : " and ") + choice.kind;
    return fmt::format("{} {}", count, kinds);
  }

  const char* met_by_one() const { return problem_.goals.empty() ? "keeps the limits" : "meets the conditions"; }

  /// No exact design: what comes near to one.
  Walk compromise(Walk first, int offered) {
    const Branching branching(problem_, offered);
    if (first.best && first.best->rank == Rank::beyond_limits) return first;
    const Wanted wanted = problem_.objective && !problem_.objective->size ? Wanted::figure : Wanted::residual;
    Walk second = search_.run(branching, wanted);
    if (first.best && (!second.best || first.best->value < second.best->value)) second.best = std::move(first.best);
    return second;
  }

  /// The design once more, with all that is told of one.
  DesignOutcome told(const SizedDesign& design) {
    Branch branch;
    branch.lower = branch.upper = design.outcome.x;
    for (std::size_t i = 0; i < problem_.variables.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const bool held = !problem_.variables[i].sizes.empty() || left_out(design.outcome.x, static_cast<int>(i));
      if (held) continue;
      branch.lower[k] = problem_.variables[i].lower;
      branch.upper[k] = problem_.variables[i].upper;
    }
    DesignProblem part = within(problem_, branch, std::max(min_final_seconds, budget_.left()));
    for (std::size_t i = 0; i < part.variables.size(); ++i)
      part.variables[i].start =
          std::clamp(design.outcome.x[static_cast<Eigen::Index>(i)], part.variables[i].lower, part.variables[i].upper);
    DesignOutcome outcome = solve(part);
    const bool worse = outcome.status != design.outcome.status ||
                       !(outcome.within_limits == design.outcome.within_limits) ||
                       (problem_.objective && outcome.objective > design.outcome.objective);
    if (worse) outcome = design.outcome;
    forget_held(part, outcome.freedom);
    const VectorX start = start_values();
    if (problem_.objective) outcome.objective_start = value_of(problem_, *problem_.objective, start);
    if (std::abs(outcome.objective) <= figure_round_off * std::abs(outcome.objective_start)) outcome.objective = 0;
    return outcome;
  }

  /// Numbers that are held change nothing, which is no freedom.
  static void forget_held(const DesignProblem& part, Freedom& freedom) {
    const auto held = [&](int i) {
      const Variable& variable = part.variables[static_cast<std::size_t>(i)];
      return variable.lower == variable.upper;
    };
    const int count = static_cast<int>(std::count_if(freedom.numbers.begin(), freedom.numbers.end(), held));
    std::erase_if(freedom.numbers, held);
    if (freedom.of_conditions >= 0) freedom.of_conditions = std::max(0, freedom.of_conditions - count);
    if (freedom.left >= 0) freedom.left = std::max(0, freedom.left - count);
  }

  VectorX start_values() const {
    VectorX start(static_cast<Eigen::Index>(problem_.variables.size()));
    for (std::size_t i = 0; i < problem_.variables.size(); ++i)
      start[static_cast<Eigen::Index>(i)] = problem_.variables[i].start;
    return start;
  }

  bool left_out(const VectorX& x, int number) const {
    const auto kept = Branching(problem_, 0).kept(x);
    for (std::size_t c = 0; c < problem_.choices.size(); ++c)
      for (std::size_t k = 0; k < problem_.choices[c].elements.size(); ++k) {
        const std::vector<int>& numbers = problem_.choices[c].elements[k].numbers;
        if (!kept[c][k] && std::find(numbers.begin(), numbers.end(), number) != numbers.end()) return true;
      }
    return false;
  }

  void tell_effort(DesignOutcome& outcome, bool proved, bool asked) const {
    outcome.tried =
        several(steps_.branches, "branch", "branches") + ", " + several(steps_.designs, "design", "designs");
    outcome.effort = {};
    outcome.effort.local_searches = steps_.designs;
    outcome.effort.evaluations = steps_.branches;
    using End = SearchEffort::End;
    outcome.effort.end = proved ? End::proof : budget_.stopped ? End::time : asked ? End::starts : End::met;
    outcome.optimality = !asked            ? Optimality::not_asked
                         : proved          ? Optimality::proved_best
                         : budget_.stopped ? Optimality::stopped
                                           : Optimality::local_best;
    if (problem_.choices.empty()) return;
    outcome.chosen = chosen_;
    outcome.chosen->kept = Branching(problem_, 0).kept(outcome.x);
  }

  DesignOutcome finished(Walk walk) {
    DesignOutcome outcome = told(*walk.best);
    const double value = problem_.objective ? outcome.objective : 0;
    const double bound = std::min(walk.bound, value);
    const bool proved = problem_.objective && bound >= value - bound_falls_short * std::abs(value);
    outcome.lower_bound = problem_.objective && std::isfinite(bound) ? bound : std::numeric_limits<double>::quiet_NaN();
    tell_effort(outcome, proved, problem_.objective.has_value());
    return outcome;
  }

  /// @param none it is shown that there is no exact design
  DesignOutcome compromised(Walk walk, bool none, std::string why) {
    const bool beyond = walk.best->rank == Rank::beyond_limits;
    DesignOutcome outcome = told(*walk.best);
    if (problem_.goals.empty() && !beyond) return finished(std::move(walk));
    const bool by_figure = problem_.objective && !problem_.objective->size;
    const bool proved = !beyond && walk.bound >= walk.best->value - bound_falls_short * std::abs(walk.best->value);
    outcome.lower_bound = by_figure && !beyond && std::isfinite(walk.bound) ? std::min(walk.bound, outcome.objective)
                                                                            : std::numeric_limits<double>::quiet_NaN();
    outcome.status = none ? DesignStatus::impossible : DesignStatus::compromise;
    outcome.proved = none;
    if (!beyond) outcome.reason = reason(none, std::move(why), outcome);
    tell_effort(outcome, proved, true);
    return outcome;
  }

  std::string reason(bool none, std::string why, DesignOutcome& outcome) {
    const Branch all = Branching(problem_, 0).root();
    const DesignOutcome plain = solve(within(problem_, all, std::max(min_final_seconds, budget_.left())));
    if (plain.status == DesignStatus::impossible) {
      outcome.proof = plain.proof;
      return plain.reason;
    }
    outcome.proof.reset();
    if (!why.empty()) return why;
    if (!none) return "no choice was found that meets the conditions";
    return problem_.choices.empty() ? "no choice of the sizes meets the conditions; sizes between them would"
                                    : "no choice of sizes and elements meets the conditions";
  }

  DesignOutcome without_design() {
    DesignOutcome outcome =
        solve(within(problem_, Branching(problem_, 0).root(), std::max(min_final_seconds, budget_.left())));
    if (outcome.status == DesignStatus::unsolved) return outcome;
    outcome.status = DesignStatus::unsolved;
    outcome.reason =
        budget_.stopped ? "the time ran out before a design was found" : "no choice of the sizes is a design";
    return outcome;
  }

  DesignProblem problem_;
  Budget budget_;
  Steps steps_;
  DiscreteBounds bounds_;
  DiscreteSearch search_;
  ChosenElements chosen_;
};

}  // namespace

bool is_discrete(const DesignProblem& problem) {
  return !problem.choices.empty() || std::any_of(problem.variables.begin(), problem.variables.end(),
                                                 [](const Variable& v) { return !v.sizes.empty(); });
}

DesignOutcome solve_discrete(const DesignProblem& problem) { return Discrete(problem).run(); }

}  // namespace balance::designing
