// Mechanisms that nobody designed obey the laws of mechanics, or are refused with a reason.

#include "mechanics_check.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

using namespace laws;

namespace {

/// How many seeds per kind; the soak runs more, from another first seed.
std::uint32_t wanted(const char* name, std::uint32_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

/// The kind of refusal: the reason without its numbers.
std::string kind_of(const std::string& reason) {
  const std::size_t from = reason.rfind("at t = ", 0) == 0 ? reason.find(": ") + 2 : 0;
  return reason.substr(from, reason.find_first_of(":;(", from) - from);
}

}  // namespace

TEST_CASE(
    "random trees and loops, in the plane and in space, obey the laws of mechanics or are refused with a reason") {
  const std::uint32_t first = wanted("BALANCE_FIRST_SEED", 1), seeds = wanted("BALANCE_SEEDS", 30 / fewer);
  const bool reporting = std::getenv("BALANCE_SEEDS") != nullptr;
  for (const Kind kind : kinds) {
    std::map<Judgement, int> count;
    std::map<std::string, int> refusals;
    for (std::uint32_t seed = first; seed < first + seeds; ++seed) {
      Thoroughness thoroughness;
      thoroughness.conditions = reporting || seed % 4 == 0;
      thoroughness.elsewhere = reporting || seed % 4 != 0;
      thoroughness.formulations = reporting || seed % 2 == 0;
      const Verdict verdict = judge(kind, seed, thoroughness);
      ++count[verdict.judgement];
      if (verdict.judgement == Judgement::refused) ++refusals[kind_of(verdict.reason)];
      CHECK_MESSAGE(verdict.judgement != Judgement::failed, name_of(kind) << " " << seed << ": " << verdict.reason);
    }
    CHECK(20 * count[Judgement::refused] <= 3 * static_cast<int>(seeds) + 20);  // else the generator shows little
    if (!reporting) continue;
    std::printf("%-14s %6d passed %5d refused %4d failed\n", name_of(kind).c_str(), count[Judgement::passed],
                count[Judgement::refused], count[Judgement::failed]);
    for (const auto& [reason, times] : refusals) std::printf("    %5d  %s\n", times, reason.c_str());
  }
}

TEST_CASE("random mechanisms that once were wrong") {
  struct Case {
    Kind kind;
    std::uint32_t seed;
    const char* what;
  };
  for (const Case& one : {Case{Kind::planar_loop, 20, "singular vectors that were never set"},
                          Case{Kind::planar_loop, 42, "least norm of torques and forces added up as they are"},
                          Case{Kind::spatial_tree, 32, "the same without loops"},
                          Case{Kind::spatial_loop, 18, "round-off grew from pivot to pivot of the conditions"},
                          Case{Kind::spatial_tree, 303, "turns geared to slides while the tool's rotation is driven"},
                          Case{Kind::spatial_tree, 315, "the same with a leader that slides"},
                          Case{Kind::planar_loops, 119, "loops that are ill-conditioned everywhere cannot be sampled"},
                          Case{Kind::spatial_loop, 181, "a joint's axis that points nearly against the body's z"},
                          Case{Kind::flat_in_space, 115, "the same with redundant loops"}}) {
    const Verdict verdict = judge(one.kind, one.seed, {});
    CHECK_MESSAGE(verdict.judgement == Judgement::passed, one.what << ": " << verdict.reason);
  }
}
