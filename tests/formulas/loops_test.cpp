#include "reading.hpp"

#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/program_code.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

using namespace reading;

namespace {

/// Round-off of some hundred terms, relative to the largest entry of its kind.
constexpr double tolerance = 1e-10;

/// Values of the steps and formulas of a sheet's equations in independent coordinates.
struct Reduced {
  std::map<std::string, double> values;

  Reduced(const Sheets& s, const std::vector<double>& y) {
    std::map<std::string, double> names = evaluate_names(s.sheet, y);
    for (std::size_t k = 0; k < s.sections.size(); ++k)
      for (const PrintedFormula& formula : s.sections[k].formulas)
        if (s.sections[k].section == SheetSectionKind::reduced)
          values[formula.label] = names[formula.label] = evaluate_text(formula.text, names);
  }
  double operator()(const std::string& label) const {
    const auto known = values.find(label);
    return known == values.end() ? 0 : known->second;
  }
};

double max_entry(const dynamics::IndependentTerms& terms) {
  double size = terms.mass.cwiseAbs().maxCoeff();
  for (const MatrixX& form : terms.velocity) size = std::max(size, form.cwiseAbs().maxCoeff());
  return size;
}

}  // namespace

TEST_CASE("P1 eq. 24, 35, 45: the rows that discs add to C") {
  const auto rows_at = [](const std::string& config, const VectorX& q) {
    const Study study = read_spec_file(std::string(BALANCE_CONFIGS "/") + config);
    dynamics::EquationTerms terms(study.mechanism);
    const auto found = terms.redundant_terms(q);
    REQUIRE(found);
    CHECK(static_cast<std::size_t>(found.value.discs.rows()) == terms.disc_rows().size());
    return found.value.discs;
  };
  const auto number = [](const Sheets& s, const std::string& name) {
    return evaluate_names(s.sheet, {0, 0, 0}).at(name);
  };
  const double t2 = 0.7, t3 = -0.4;
  VectorX q(3);
  q << 0.3, t2, t3;
  const SheetOptions only{{SheetSectionKind::solved}};

  const Sheets planar = sheets("planar-rrr-belts.yaml", {}, only), spatial = sheets("spatial-rrr.yaml", {}, only),
               scara = sheets("scara.yaml", {}, only);
  MatrixX expected(4, 3);
  expected << 1, 1, 0, 1, number(planar, "beta"), 0, 1, 1, 1, 1, 1, number(planar, "gamma");
  CHECK((rows_at("planar-rrr-belts.yaml", q) - expected).cwiseAbs().maxCoeff() < 1e-14);

  const double beta = number(spatial, "beta");
  MatrixX in_space(6, 3);
  in_space << 0, 1, 1, std::sin(t2 + t3), 0, 0, std::cos(t2 + t3), 0, 0, 0, 1, beta, std::sin(t2 + beta * t3), 0, 0,
      std::cos(t2 + beta * t3), 0, 0;
  CHECK((rows_at("spatial-rrr.yaml", q) - in_space).cwiseAbs().maxCoeff() < 1e-14);

  MatrixX of_scara = MatrixX::Zero(6, 3);
  of_scara.row(2) << 1, 1, 0;
  of_scara.row(5) << 1, number(scara, "beta"), 0;
  CHECK((rows_at("scara.yaml", q) - of_scara).cwiseAbs().maxCoeff() < 1e-14);

  for (const auto& [sheet, numbers] : {std::pair{&planar, &expected}, {&spatial, &in_space}, {&scara, &of_scara}})
    for (Eigen::Index row = 0; row < numbers->rows(); ++row)
      for (Eigen::Index column = 0; column < 3; ++column)
        CHECK(sheet->at("C" + std::to_string(row + 4) + std::to_string(column + 1), {0.3, t2, t3}) ==
              doctest::Approx((*numbers)(row, column)).epsilon(1e-13));
}

TEST_CASE("P0 eq. 78-81: a particle on massless carriers has M = diag(m, m), no velocity terms and its weight") {
  const Study study = read_spec_file(BALANCE_CONFIGS "/poses/particle.yaml");
  const double m = 2, g = 9.81;
  dynamics::EquationTerms terms(study.mechanism);
  VectorX q(2);
  q << 0.3, -0.8;
  const auto found = terms.independent_terms(q);
  REQUIRE(found);
  CHECK(found.value.mass == MatrixX(m * MatrixX::Identity(2, 2)));
  for (const MatrixX& form : found.value.velocity) CHECK(form.isZero(0));
  CHECK(found.value.static_terms.sum()[0] == 0);
  CHECK(found.value.static_terms.sum()[1] == doctest::Approx(m * g).epsilon(1e-15));
}

TEST_CASE("P0 eq. 62, 63: the printed equations in independent coordinates are M', D' and z' entry by entry") {
  for (const char* config :
       {"5r.yaml", "slider-crank.yaml", "geared-five-bar.yaml", "whitworth.yaml", "watt-six-bar.yaml",
        "parallelogram.yaml", "spring-press.yaml", "spatial-slider-crank.yaml"}) {
    INFO(config);
    const Sheets s = sheets(config, {}, {{SheetSectionKind::reduced}}, {.max_terms = 100'000});
    const Mechanism& mechanism = s.study.mechanism;
    InverseOptions options;
    const auto coordinate = [&](std::size_t column) { return s.sheet.equations.tree.coordinates[column]; };
    for (const int column : s.sheet.independent)
      options.independent.push_back(mechanism.coordinates[coordinate(static_cast<std::size_t>(column))].name);
    dynamics::EquationTerms terms(mechanism, options);
    VectorX q = VectorX::Zero(terms.degrees_of_freedom());
    for (Eigen::Index i = 0; i < q.size(); ++i)
      for (const CoordinateValue& rough : mechanism.assembly)
        if (rough.coordinate == terms.independent()[static_cast<std::size_t>(i)]) q[i] = rough.value + 0.05;
    const auto pose = terms.assemble(q);
    REQUIRE(pose);
    const auto expected = terms.independent_terms(q);
    REQUIRE(expected);
    std::vector<double> y;
    for (std::size_t c = 0; c < s.sheet.equations.tree.columns.size(); ++c) y.push_back(pose.value[coordinate(c)]);
    const Reduced printed(s, y);
    const auto d = static_cast<std::size_t>(q.size());
    const double scale = max_entry(expected.value);
    for (std::size_t i = 0; i < d; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      CHECK(std::abs(printed("zhat" + index_text({i}, d)) -
                     (expected.value.static_terms.weight + expected.value.static_terms.springs)[row]) <
            tolerance * std::max(scale, 10.0));
      for (std::size_t j = 0; j < d; ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        CHECK(std::abs(printed("Mhat" + index_text({std::min(i, j), std::max(i, j)}, d)) -
                       expected.value.mass(row, column)) < tolerance * scale);
        for (std::size_t k = j; k < d; ++k)
          CHECK(std::abs(printed("Dhat" + index_text({i, j, k}, d)) -
                         expected.value.velocity[i](column, static_cast<Eigen::Index>(k))) < tolerance * scale);
      }
    }
  }
}

TEST_CASE("a wrong sign in any step of the equations in independent coordinates is noticed") {
  const Sheets s = sheets("5r.yaml", {}, {{SheetSectionKind::reduced}});
  int count = 0;
  for (const PrintedSection& section : s.sections)
    for (const PrintedFormula& formula : section.formulas) {
      auto texts = s.texts;
      std::string& text = texts.at(formula.label);
      text = "-(" + text + ")";
      CHECK_FALSE_MESSAGE(check_against_engine(s.sheet, texts, s.study.mechanism).is_consistent, formula.label);
      ++count;
    }
  CHECK(count > 15);
}

TEST_CASE("accelerations follow from the rates whatever symbols were added meanwhile") {
  // so many that a read at the index of a later symbol is outside the samples' memory: for memory checkers
  constexpr int added_symbols = 1900;
  const auto derive_steps = [](const Sheets& s, int added) {
    Ring& ring = *s.sheet.ring;
    const SymbolicEquations& e = s.sheet.equations;
    ClosureElimination elimination(ring, e, choose_independent_columns(ring, s.study.mechanism, e, {}));
    for (int k = 0; k < added; ++k) ring.add_symbol("added" + std::to_string(k), SymbolKind::rate, 0);
    elimination.derive_accelerations();
    std::vector<std::string> steps;
    for (const SheetFormula& step : elimination.acceleration_steps())
      steps.push_back(step.label() + " = " + FormulaPrinter(ring).print_ratio(step.value, step.denominator));
    return steps;
  };
  const SheetOptions only{{SheetSectionKind::closures}};
  const Sheets first = sheets("slider-crank.yaml", {}, only), second = sheets("slider-crank.yaml", {}, only);
  const std::vector<std::string> steps = derive_steps(first, 0);
  CHECK(steps.size() == 2);
  CHECK(derive_steps(second, added_symbols) == steps);
}

TEST_CASE("programs of mechanisms with loops take the independent coordinates or all, and any independent ones") {
  const DesignSpace space = read_design_space_file(BALANCE_CONFIGS "/5r.yaml");
  const auto texts = specification::read_spec_number_texts(space);
  const auto program = [&](ProgramCoordinates coordinates, const std::vector<std::string>& independent) {
    return generate_program(space.start.mechanism, texts, Language::python, nullptr, {coordinates, independent});
  };
  CHECK(program(ProgramCoordinates::independent, {}).find("def close_loops(") != std::string::npos);
  CHECK(program(ProgramCoordinates::all, {}).find("def close_loops(") == std::string::npos);
  CHECK(program(ProgramCoordinates::independent, {"B1", "B2"}).find("FORCE_UNITS") != std::string::npos);
  CHECK_THROWS_AS(program(ProgramCoordinates::independent, {"A1"}), FormulaError);
  CHECK_THROWS_AS(program(ProgramCoordinates::independent, {"nothing"}), FormulaError);
}
