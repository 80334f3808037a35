#include "balance/spec/law.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace balance::specification {

namespace {

struct NamedLaw {
  const char* name;
  MotionLawKind kind;
};

constexpr NamedLaw named_laws[]{{"cycloidal", MotionLawKind::cycloidal},
                                {"cycloid", MotionLawKind::cycloidal},
                                {"bang-bang", MotionLawKind::bang_bang},
                                {"uniform", MotionLawKind::uniform},
                                {"cubic", MotionLawKind::cubic},
                                {"3-4-5", MotionLawKind::polynomial_345},
                                {"poly-345", MotionLawKind::polynomial_345},
                                {"4-5-6-7", MotionLawKind::polynomial_4567},
                                {"poly-4567", MotionLawKind::polynomial_4567},
                                {"harmonic", MotionLawKind::harmonic},
                                {"modified-sine", MotionLawKind::modified_sine},
                                {"modified-trapezoidal", MotionLawKind::modified_trapezoidal},
                                {"trapezoidal-velocity", MotionLawKind::trapezoidal_velocity},
                                {"fastest", MotionLawKind::time_optimal},
                                {"gentlest", MotionLawKind::min_peak},
                                {"steady-momentum", MotionLawKind::constant_momentum}};

}  // namespace

MotionLawKind read_law(const SpecCursor& at) {
  std::vector<std::string> names;
  for (const NamedLaw& law : named_laws) names.emplace_back(law.name);
  return named_laws[at.read_choice("a law of motion", names)].kind;
}

void read_ramps(const SpecCursor& at, StudyBuilder& draft, MotionLawOf<Expression>& law) {
  if (law.kind != MotionLawKind::trapezoidal_velocity)
    at.fail({.expected = "no ramps: only the law 'trapezoidal-velocity' has them"});
  if (at.is_list()) {
    at.items("[ramp up, ramp down]", 2);
    const auto both = read_numbers(at, draft, dimension::dimensionless, "[ramp up, ramp down]");
    law.ramp_up = both[0];
    law.ramp_down = both[1];
  } else {
    law.ramp_up = law.ramp_down = read_number(at, draft, dimension::dimensionless);
  }
  const double up = law.ramp_up.value(), down = law.ramp_down.value();
  if (!(up > 0 && down > 0 && up + down <= 1))
    at.fail({.expected = "ramps > 0 with a sum of at most 1", .found = fmt::format("{} and {}", up, down)});
}

}  // namespace balance::specification
