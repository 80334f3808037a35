#include "balance/spec/law.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace balance::read {

namespace {

struct NamedLaw {
  const char* name;
  LawKind kind;
};

constexpr NamedLaw laws[]{{"cycloidal", LawKind::cycloidal},
                          {"cycloid", LawKind::cycloidal},
                          {"bang-bang", LawKind::bang_bang},
                          {"uniform", LawKind::uniform},
                          {"cubic", LawKind::cubic},
                          {"3-4-5", LawKind::polynomial_345},
                          {"poly-345", LawKind::polynomial_345},
                          {"4-5-6-7", LawKind::polynomial_4567},
                          {"poly-4567", LawKind::polynomial_4567},
                          {"harmonic", LawKind::harmonic},
                          {"modified-sine", LawKind::modified_sine},
                          {"modified-trapezoidal", LawKind::modified_trapezoidal},
                          {"trapezoidal-velocity", LawKind::trapezoidal_velocity},
                          {"fastest", LawKind::fastest},
                          {"gentlest", LawKind::gentlest},
                          {"steady-momentum", LawKind::steady_momentum}};

}  // namespace

LawKind read_law(const Cursor& at) {
  std::vector<std::string> names;
  for (const NamedLaw& law : laws) names.emplace_back(law.name);
  return laws[at.choice("a law of motion", names)].kind;
}

void read_ramps(const Cursor& at, Draft& draft, LawOf<Expression>& law) {
  if (law.kind != LawKind::trapezoidal_velocity)
    at.fail({.expected = "no ramps: only the law 'trapezoidal-velocity' has them"});
  if (at.is_list()) {
    at.items("[ramp up, ramp down]", 2);
    const auto both = read_numbers(at, draft, dimension::none, "[ramp up, ramp down]");
    law.ramp_up = both[0];
    law.ramp_down = both[1];
  } else {
    law.ramp_up = law.ramp_down = read_number(at, draft, dimension::none);
  }
  const double up = law.ramp_up.value(), down = law.ramp_down.value();
  if (!(up > 0 && down > 0 && up + down <= 1))
    at.fail({.expected = "ramps > 0 with a sum of at most 1", .found = fmt::format("{} and {}", up, down)});
}

}  // namespace balance::read
