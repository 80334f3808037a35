#include "balance/synthesis/design/status_names.hpp"

#include <algorithm>

namespace balance::design {

const char* name_of(ConditionsStatus status) {
  switch (status) {
    case ConditionsStatus::unsolved: return "unsolved";
    case ConditionsStatus::done: return "done";
    case ConditionsStatus::not_assembled: return "not-assembled";
    case ConditionsStatus::mismatch: return "mismatch";
    case ConditionsStatus::rank_unclear: return "rank-unclear";
  }
  return "";
}

const char* name_of(DesignStatus status) {
  switch (status) {
    case DesignStatus::unsolved: return "unsolved";
    case DesignStatus::balanced: return "balanced";
    case DesignStatus::compromise: return "compromise";
    case DesignStatus::infeasible: return "impossible";
    case DesignStatus::no_feasible_start: return "not-found";
    case DesignStatus::no_goal: return "not-asked";
  }
  return "";
}

const char* name_of(Optimality optimality) {
  switch (optimality) {
    case Optimality::not_optimised: return "not-asked";
    case Optimality::proved_global: return "proved-best";
    case Optimality::local_optimum: return "local-best";
    case Optimality::budget_exhausted: return "stopped";
  }
  return "";
}

const char* name_of(DesignMethod method) {
  switch (method) {
    case DesignMethod::none: return "nothing-to-do";
    case DesignMethod::affine: return "affine";
    case DesignMethod::polynomial: return "polynomial";
    case DesignMethod::geometric: return "geometric";
  }
  return "";
}

const std::vector<std::string>& design_verdict_words() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> all;
    using enum DesignStatus;
    for (const DesignStatus status : {balanced, compromise, infeasible, no_feasible_start, no_goal, unsolved})
      all.emplace_back(name_of(status));
    using enum Optimality;
    for (const Optimality optimality : {proved_global, local_optimum, budget_exhausted, not_optimised})
      if (std::find(all.begin(), all.end(), name_of(optimality)) == all.end()) all.emplace_back(name_of(optimality));
    return all;
  }();
  return words;
}

}  // namespace balance::design
