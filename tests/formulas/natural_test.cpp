#include "reading.hpp"

#include <doctest/doctest.h>

#include <complex>
#include <random>

using namespace reading;

namespace {

const SheetOptions natural{.only = {SheetSectionKind::natural}};

/// P3's mechanism with a number of its own for everything: bodies 1, 3, 5 are cranks, 2, 4, 6 couplers, 7 the platform.
std::string general_3rrr() {
  std::string bodies, joints;
  for (int leg = 0; leg < 3; ++leg) {
    const std::string crank = std::to_string(2 * leg + 1), coupler = std::to_string(2 * leg + 2);
    const std::string n = std::to_string(leg + 1);
    for (const std::string& b : {crank, coupler})
      bodies += "  b" + b + ": {mass: m" + b + ", com: [x" + b + ", y" + b + "], inertia: J" + b +
                ", points: {A: [0, 0], B: [l" + b + ", 0]}}\n";
    joints += "  A" + n + ": {type: revolute, connects: [ground.A" + n + ", b" + crank + ".A]}\n";
    joints += "  B" + n + ": {type: revolute, connects: [b" + crank + ".B, b" + coupler + ".A]}\n";
    joints += "  C" + n + ": {type: revolute, connects: [b" + coupler + ".B, b7.C" + n + "]}\n";
  }
  std::string numbers;
  for (const char* b : {"1", "2", "3", "4", "5", "6", "7"})
    numbers += "m" + std::string(b) + ": 1." + b + ", x" + b + ": 0.0" + b + ", y" + b + ": 0.01" + b + ", J" + b +
               ": 0.00" + b + ", l" + b + ": 0." + (std::string(b) == "7" ? "15" : "18" + std::string(b)) + ", ";
  return "name: general\nspace: planar\ngravity: [0, 0]\nparameters: {" + numbers +
         "k7: 0.07, h7: 0.13}\nground:\n  points: {A1: [-0.21651, -0.125], A2: [0.21651, -0.125], A3: [0, "
         "0.25]}\nbodies:\n" +
         bodies +
         "  b7: {mass: m7, com: [x7, y7], inertia: J7, points: {C1: [0, 0], C2: [l7, 0], C3: [k7, h7]}}\njoints:\n" +
         joints + "actuators: [A1, A2, A3]\nassembly: {A1: 0, A2: 2, A3: -2, B1: 1, B2: 1, B3: 1}\n";
}

Sheets general_sheets() {
  const DesignSpace space = read_design_space(general_3rrr(), "general.yaml", {});
  Sheets found{space.start, {}, {}, {}};
  found.sheet = make_sheet(found.study.mechanism, specification::read_spec_number_texts(space), natural);
  found.sections = print_sheet(found.sheet, {});
  found.texts = texts_by_label(found.sections);
  return found;
}

/// Number of a point, as formulas have it.
std::string number_of(const Sheets& s, const std::string& point) {
  const auto& points = s.sheet.natural->points;
  return std::to_string(std::find(points.begin(), points.end(), point) - points.begin() + 1);
}

}  // namespace

TEST_CASE("P3 eq. 35, 37-46 as corrected are what is printed, for random parameters") {
  const Sheets s = general_sheets();
  const std::vector<double> pose(s.sheet.equations.M.size(), 0.1);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0.1, 1);
  std::map<std::string, double> v;
  for (const char* letter : {"m", "x", "y", "J", "l"})
    for (int b = 1; b <= 7; ++b) v[letter + std::to_string(b)] = any(random);
  v["k7"] = any(random), v["h7"] = any(random);
  const auto of = [&](const char* letter, int b) { return v.at(letter + std::to_string(b)); };
  const auto C = [&](const std::string& point) {
    const std::string n = number_of(s, point);
    return std::complex<double>(s.at("Cre" + n, pose, v), s.at("Cim" + n, pose, v));
  };
  const auto end = [&](int b) { return of("m", b) / of("l", b) * std::complex<double>(of("x", b), of("y", b)); };
  const auto start = [&](int b) { return of("m", b) - end(b); };
  const auto is = [](std::complex<double> a, std::complex<double> b) { return std::abs(a - b) < 1e-12 * std::abs(b); };
  for (const int crank : {1, 3, 5}) {
    CHECK(is(C("b" + std::to_string(crank) + ".B"), end(crank) + start(crank + 1)));  // eq. 39, 42, 45
    CHECK(is(C("ground.A" + std::to_string(crank / 2 + 1)), start(crank)));           // eq. 38, 41, 44
    const auto about_a = [&](int b) {
      return of("J", b) + of("m", b) * (of("x", b) * of("x", b) + of("y", b) * of("y", b));
    };
    const std::string B = number_of(s, "b" + std::to_string(crank) + ".B");
    const double l = of("l", crank), next = of("l", crank + 1);
    const double M4 = about_a(crank) / (l * l);
    const double M1 = of("m", crank + 1) * (1 - 2 * of("x", crank + 1) / next) + about_a(crank + 1) / (next * next);
    CHECK(is(s.at("Mre" + B + B, pose, v), M4 + M1));  // eq. 35
  }
  const double m = of("m", 7), x = of("x", 7), y = of("y", 7), l = of("l", 7), k = v["k7"], h = v["h7"];
  CHECK(is(C("b2.B"), m + (k * y / (h * l) - x / l - y / h) * m + end(2)));  // eq. 40
  CHECK(is(C("b4.B"), (x / l - y * k / (h * l)) * m + end(4)));              // eq. 43
  CHECK(is(C("b6.B"), y / h * m + end(6)));                                  // eq. 46
}

TEST_CASE(
    "formulas in natural coordinates are those of the second formulation, with sliders, belts and what bodies carry") {
  for (const char* config : {"3rrr-force-balance.yaml", "watt-six-bar.yaml", "whitworth.yaml", "scotch-yoke.yaml",
                             "slider-crank.yaml", "geared-five-bar.yaml", "rr-balanced.yaml", "squeezer.yaml"})
    for (const bool numbers : {false, true}) {
      const Sheets s = sheets(config, {}, natural, {.with_values = numbers});
      const FormulaCheck check =
          check_against_engine(s.sheet, s.texts, s.study.mechanism, {.with_perturbed_parameters = !numbers});
      CHECK_MESSAGE(check.is_consistent, config << ": " << check.reason << " " << check.error);
    }
}

TEST_CASE("a wrong sign in natural coordinates is noticed, wherever it stands") {
  const Sheets s = general_sheets();
  CHECK(check_against_engine(s.sheet, s.texts, s.study.mechanism).is_consistent);
  for (const char* label : {"Mre11", "Mim12", "Mre46", "Cre1", "Cim2", "Phi1", "Phi9", "G1_1"}) {
    auto texts = s.texts;
    std::string& text = texts.at(label);
    text = "-(" + text + ") + 0.01";
    CHECK_MESSAGE(!check_against_engine(s.sheet, texts, s.study.mechanism).is_consistent, label);
  }
}

TEST_CASE("natural coordinates are refused in space") {
  CHECK_THROWS_AS(sheets("spatial-rrr.yaml", {}, natural), FormulaError);
}
