#include "reading.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace reading;

namespace {

/// Parameters drawn at random, by name, and the same as overrides.
struct Drawn {
  std::map<std::string, double> value;
  std::vector<std::pair<std::string, std::string>> set;

  double operator[](const std::string& name) const { return value.at(name); }
};

Drawn draw(const std::vector<std::string>& names, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(0.2, 1.2);
  Drawn drawn;
  for (const std::string& name : names) {
    // four digits, so that the text is the number
    const std::string text = std::to_string(static_cast<int>(any(random) * 1e4)) + "e-4";
    drawn.set.emplace_back(name, text);
    drawn.value[name] = std::stod(text);
  }
  return drawn;
}

const std::vector<std::vector<double>> poses{{0.3, -1.1, 0.7}, {-2.1, 0.4, 1.9}, {1.2, 2.8, -0.6}};

doctest::Approx near(double value) { return doctest::Approx(value).epsilon(1e-12); }

double square(double x) { return x * x; }

/// The terms of a sum, in any order.
std::vector<std::string> terms_of(const std::string& sum) {
  std::vector<std::string> terms(1);
  int depth = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    depth += sum[i] == '(' ? 1 : sum[i] == ')' ? -1 : 0;
    if (depth == 0 && sum.compare(i, 3, " + ") == 0)
      terms.emplace_back(), i += 2;
    else
      terms.back() += sum[i];
  }
  std::sort(terms.begin(), terms.end());
  return terms;
}

}  // namespace

// P1 eq. 20–28 with the discs' own masses explicit (see the config).
TEST_CASE("a planar arm that is balanced as the paper says has constant, decoupled inertias for any numbers") {
  for (const unsigned seed : {1U, 2U}) {
    const Drawn p = draw({"l1", "l2", "m1", "m2", "m3", "m6", "m7", "J2", "J3", "J4", "J5", "J6", "J7"}, seed);
    const Sheets s = sheets("planar-rrr.yaml", p.set, {.expressions = ParameterExpressions::inlined});
    for (const char* label : {"D1", "D2", "D3", "D111", "D112", "D122", "D211", "D223", "D311", "D322"})
      CHECK_MESSAGE(s.is_zero(label), label);  // as a polynomial, not only at some poses
    const double carried = p["m2"] + p["m3"] + p["m6"] + p["m7"], shift = square(p["l2"] * p["m3"]) / p["m2"];
    const double arm2 = p["J2"] + p["J3"] + p["J4"] + p["J6"] + p["J7"] + p["m3"] * square(p["l2"]) + shift;
    const double arm3 = p["J3"] + p["J6"];
    const double k1 = 0.08 + p["J2"] + p["J3"] + p["J4"] + p["J5"] + p["J6"] + p["J7"] + carried * square(p["l1"]) +
                      p["m3"] * square(p["l2"]) + square(p["l1"] * carried) / p["m1"] + shift;
    for (const auto& q : poses) {
      CHECK(s.at("D11", q) == near(k1));
      CHECK(s.at("D22", q) == near(arm2 + square(arm2) / p["J5"]));
      CHECK(s.at("D33", q) == near(arm3 + square(arm3) / p["J7"]));
      for (const char* label : {"D12", "D13", "D23"}) CHECK(std::abs(s.at(label, q)) < 1e-12 * k1);
    }
  }
}

TEST_CASE("the inertias that the motors of the balanced planar arm feel are those of its description") {
  const Sheets s = sheets("planar-rrr.yaml");
  CHECK(s.at("D11", poses[0]) == doctest::Approx(2.537333).epsilon(1e-6));
  CHECK(s.at("D22", poses[0]) == doctest::Approx(4.3168).epsilon(1e-6));
  CHECK(s.at("D33", poses[0]) == doctest::Approx(0.0715).epsilon(1e-6));
}

// P1 eq. 31, 36–39 as corrected in docs/errata.md.
TEST_CASE("a spatial arm that is balanced as the paper says has constant, decoupled inertias for any numbers") {
  const Sheets s = sheets("spatial-rrr.yaml", {}, {.expressions = ParameterExpressions::inlined});
  for (const unsigned seed : {3U, 4U}) {
    Drawn p = draw({"l1", "l2", "m2", "m3", "Jx3", "Jx4", "Jx5", "Jz2", "Jz1", "Jx2", "Jy3", "m_d4", "m_d5"}, seed);
    p.value["Jz3"] = p["Jy3"];  // eq. 37
    p.value["beta"] = -(p["Jx3"] + p["Jx4"]) / p["Jx5"];
    const double shift = p["m3"] * square(p["l2"]) * (1 + p["m3"] / p["m2"]);
    for (const auto& q : poses) {
      const auto n = evaluate_names(s.sheet, q);
      const double k1 = p["Jz1"] + p["Jz2"] + p["Jz3"] + (p["m2"] + p["m3"] + p["m_d4"] + p["m_d5"]) * square(p["l1"]) +
                        shift + n.at("Jt_d4") + n.at("Jt_d5");
      CHECK(s.at("D11", q, p.value) == near(k1));
      CHECK(s.at("D22", q, p.value) == near(p["Jx2"] + p["Jx3"] + p["Jx4"] + p["Jx5"] + shift));
      CHECK(s.at("D33", q, p.value) == near(p["Jx3"] + p["Jx4"] + square(p["Jx3"] + p["Jx4"]) / p["Jx5"]));
      for (const char* label : {"D2", "D12", "D13", "D23", "D112", "D113", "D211", "D311"})
        CHECK(std::abs(s.at(label, q, p.value)) < 1e-12);
    }
  }
}

// P1 eq. 42, 46–49 with the terms of the slider's offset (docs/errata.md).
TEST_CASE("a SCARA arm that is balanced as the paper says has constant, decoupled inertias for any numbers") {
  const Sheets s = sheets("scara.yaml", {}, {.expressions = ParameterExpressions::inlined});
  for (const char* label : {"D1", "D2", "D112", "D122", "D211", "D13", "D23"}) CHECK_MESSAGE(s.is_zero(label), label);
  Drawn p = draw({"l1", "l2", "m1", "m2", "m3", "J2", "J3", "J4", "J5", "Jz1"}, 5);
  const double shift = p["m3"] * square(p["l2"]) * (1 + p["m3"] / p["m2"]);
  const double arm2 = p["J2"] + p["J3"] + p["J4"] + shift, carried = p["m2"] + p["m3"];
  p.value["beta"] = -arm2 / p["J5"];
  const double k1 = p["Jz1"] + arm2 + p["J5"] + carried * square(p["l1"]) + square(p["l1"] * carried) / p["m1"];
  for (const auto& q : poses) {
    CHECK(s.at("D11", q, p.value) == near(k1));
    CHECK(s.at("D22", q, p.value) == near(arm2 + square(arm2) / p["J5"]));
    CHECK(s.at("D33", q, p.value) == near(p["m3"]));
    CHECK(std::abs(s.at("D12", q, p.value)) < 1e-12 * k1);
  }
}

TEST_CASE(
    "P1 eq. 25: the printed inertias of the planar arm with its discs on the base, for any ratios of their belts") {
  const Sheets s = sheets("planar-rrr-belts.yaml", {}, {.expressions = ParameterExpressions::inlined});
  for (const char* label : {"D1", "D2", "D3", "D111", "D112", "D122", "D211", "D223", "D311", "D322"})
    CHECK_MESSAGE(s.is_zero(label), label);
  Drawn p = draw({"l1", "l2", "m1", "m2", "m3", "J2", "J3", "J4", "J5", "J6", "J7", "beta", "gamma"}, 6);
  const double beta = p.value["beta"] *= -7, gamma = p.value["gamma"] *= -9;
  const double shift = square(p["l2"] * p["m3"]) / p["m2"], both = p["m2"] + p["m3"];
  const double D22 = p["J2"] + p["J3"] + p["m3"] * square(p["l2"]) + shift;  // eq. 21
  const double D11 = 0.08 + D22 + both * square(p["l1"]) + square(p["l1"] * both) / p["m1"];
  for (const auto& q : poses) {
    CHECK(s.at("D11", q, p.value) == near(D11 + p["J4"] + p["J5"] + p["J6"] + p["J7"]));
    CHECK(s.at("D22", q, p.value) == near(D22 + p["J4"] + p["J5"] * square(beta) + p["J6"] + p["J7"]));
    CHECK(s.at("D33", q, p.value) == near(p["J3"] + p["J6"] + p["J7"] * square(gamma)));
    CHECK(s.at("D12", q, p.value) == near(D22 + p["J4"] + p["J5"] * beta + p["J6"] + p["J7"]));
    CHECK(s.at("D13", q, p.value) == near(p["J3"] + p["J6"] + p["J7"] * gamma));
    CHECK(s.at("D23", q, p.value) == near(p["J3"] + p["J6"] + p["J7"] * gamma));
  }
}

TEST_CASE("P1 eq. 31: the printed inertias and velocity terms of the spatial arm that is balanced statically only") {
  const Sheets s = sheets("spatial-rrr.yaml", {{"Jy2", "0.26"}}, {.expressions = ParameterExpressions::inlined});
  Drawn p = draw({"l1", "l2", "m2", "m3", "Jx2", "Jy2", "Jz1", "Jz2", "Jx3", "Jy3", "Jz3"}, 7);
  for (const char* disc : {"Jx4", "Jx5", "m_d4", "m_d5", "Jt_d4", "Jt_d5"}) p.value[disc] = 0;
  const double m3l2 = p["m3"] * p["l2"], shift = m3l2 * p["l2"] * (1 + p["m3"] / p["m2"]);
  for (const auto& q : poses) {
    const double s2 = std::sin(q[1]), c2 = std::cos(q[1]), s23 = std::sin(q[1] + q[2]), c23 = std::cos(q[1] + q[2]);
    const double D11 = p["Jy2"] * square(s2) + p["Jy3"] * square(s23) + p["Jz1"] + p["Jz2"] * square(c2) +
                       p["Jz3"] * square(c23) + p["m3"] * square(p["l1"] + p["l2"] * c2) +
                       square(p["m2"] * p["l1"] - m3l2 * c2) / p["m2"];
    const double D311 = -(p["Jy3"] - p["Jz3"]) * s23 * c23, D211 = -(p["Jy2"] - p["Jz2"] - shift) * s2 * c2 + D311;
    CHECK(s.at("D11", q, p.value) == near(D11));
    CHECK(s.at("D22", q, p.value) == near(p["Jx2"] + p["Jx3"] + shift));
    CHECK(s.at("D33", q, p.value) == near(p["Jx3"]));
    CHECK(s.at("D23", q, p.value) == near(p["Jx3"]));
    CHECK(s.at("D211", q, p.value) == near(D211));
    CHECK(s.at("D112", q, p.value) == near(-D211));
    CHECK(s.at("D311", q, p.value) == near(D311));
    CHECK(s.at("D113", q, p.value) == near(-D311));
  }
  for (const char* label : {"D1", "D2", "D3", "D12", "D13", "D111", "D122", "D123", "D222", "D233", "D322"})
    CHECK_MESSAGE(s.is_zero(label), label);
}

TEST_CASE("P1 eq. 42: the printed inertias of the SCARA that is balanced statically only") {
  const Sheets s = sheets("scara.yaml", {}, {.expressions = ParameterExpressions::inlined});
  Drawn p = draw({"l1", "m1", "m2", "m3", "J2", "J3", "Jz1"}, 8);
  for (const char* none : {"J4", "J5", "l2"}) p.value[none] = 0;  // no discs, the slider on the axis of joint 2
  const double carried = p["m2"] + p["m3"], D22 = p["J2"] + p["J3"];
  for (const auto& q : poses) {
    CHECK(s.at("D11", q, p.value) ==
          near(p["Jz1"] + D22 + carried * square(p["l1"]) + square(p["l1"] * carried) / p["m1"]));
    CHECK(s.at("D22", q, p.value) == near(D22));
    CHECK(s.at("D12", q, p.value) == near(D22));
    CHECK(s.at("D33", q, p.value) == near(p["m3"]));
  }
  for (const char* label : {"D1", "D2", "D3", "D13", "D23", "D112", "D122", "D211", "D311"})
    CHECK_MESSAGE(s.is_zero(label), label);
}

// Two ways to the same torques: polynomials in inertias about the origins, and the recursion with unit parameters.
TEST_CASE("every printed column of the regressor is the engine's, and one that is not is found out") {
  for (const std::string config : {"planar-rrr-belts.yaml", "scara.yaml", "5r.yaml", "spatial-rrr.yaml"}) {
    const Sheets s = sheets(config, {},
                            {.only = {SheetSectionKind::inertia, SheetSectionKind::velocity, SheetSectionKind::gravity,
                                      SheetSectionKind::closures, SheetSectionKind::regressor}},
                            {.max_terms = 100'000});
    const FormulaCheck check = check_against_engine(s.sheet, s.texts, s.study.mechanism);
    CHECK_MESSAGE(check.is_consistent, config << ": " << check.reason << " " << check.error);
    CHECK(check.error < 1e-11);
    Sheets wrong = sheets(config, {}, {.only = {SheetSectionKind::regressor}});
    for (auto& [label, text] : wrong.texts)
      if (label.starts_with("Y1_") && text != "0") text = "1.001 (" + text + ")";
    CHECK_FALSE(check_against_engine(wrong.sheet, wrong.texts, wrong.study.mechanism).is_consistent);
  }
}

// P1 eq. 31: the form in which people write it.
TEST_CASE("squares of sines, cosines and sums are recognised") {
  const Sheets s = sheets("spatial-rrr.yaml");
  std::vector<std::string> terms = terms_of(s.texts.at("D11"));
  for (const char* term : {"Jz1", "Jy2 sin(theta2)^2", "Jz2 cos(theta2)^2", "Jy3 sin(theta2 + theta3)^2",
                           "Jz3 cos(theta2 + theta3)^2", "m2 (l1 + lg2 cos(theta2))^2", "m3 (l1 + l2 cos(theta2))^2"})
    CHECK_MESSAGE(std::find(terms.begin(), terms.end(), term) != terms.end(), term);
}

TEST_CASE("conditions keep symbols for lengths") {
  const Sheets arm = sheets("planar-rrr.yaml");
  std::vector<std::string> conditions;
  for (const PrintedSection& section : arm.sections)
    if (section.heading.ends_with("static"))
      for (const PrintedFormula& formula : section.formulas) conditions.push_back(formula.text);
  CHECK(conditions == std::vector<std::string>{"m2 lg2 + m3 l2", "m1 lg1 + l1 (m2 + m3 + m6 + m7)"});
}

// P0 eq. 103–105: rates of the passive joints of a five-bar.
TEST_CASE("the closures of a five-bar are solved in the angle of the joint that closes it") {
  const Sheets s = sheets("5r.yaml");
  CHECK(s.texts.at("C21") == "-1 - a11 sin(B1 + P)/(a12 sin(P))");
  const std::vector<double> q{2.3, -1.5, 0.8, 1.4};
  const double P = q[2] + q[3] - q[0] - q[1];
  CHECK(s.at("C21", q) == near(-1 - 0.3 * std::sin(q[1] + P) / (0.45 * std::sin(P))));
  CHECK(s.at("C22", q) == near(0.32 * std::sin(q[3]) / (0.45 * std::sin(P))));
}
