#include "balance/present/names.hpp"

namespace balance {

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
    case DesignStatus::impossible: return "impossible";
    case DesignStatus::not_found: return "not-found";
    case DesignStatus::not_asked: return "not-asked";
  }
  return "";
}

const char* name_of(Optimality optimality) {
  switch (optimality) {
    case Optimality::not_asked: return "not-asked";
    case Optimality::proved_best: return "proved-best";
    case Optimality::local_best: return "local-best";
    case Optimality::stopped: return "stopped";
  }
  return "";
}

const char* name_of(DesignMethod method) {
  switch (method) {
    case DesignMethod::nothing_to_do: return "nothing-to-do";
    case DesignMethod::affine: return "affine";
    case DesignMethod::polynomial: return "polynomial";
    case DesignMethod::geometric: return "geometric";
  }
  return "";
}

}  // namespace balance
