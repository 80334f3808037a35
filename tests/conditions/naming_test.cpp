#include "balance/synthesis/conditions/coefficient_names.hpp"

#include <doctest/doctest.h>

#include <cmath>

namespace naming_test {

using namespace balance;
using namespace balance::conditions;

namespace {

dynamics::Parameter parameter(const std::string& owner, const std::string& symbol) {
  dynamics::Parameter p;
  p.owner = owner;
  p.symbol = symbol;
  p.name = owner + "." + symbol;
  return p;
}

/// An arm of two links whose second joint is at `length` on the first link and whose point C is at (a, b) on the second.
Mechanism arm(double length = 0.5, double a = 0.4, double b = 0.15) {
  Mechanism m;
  m.gravity = Vector3(0, -9.81, 0);
  m.bodies.resize(3);
  m.bodies[1] = {"link1", 1, {}, {}, {{"A", Vector3::Zero()}, {"B", Vector3(length, 0, 0)}}};
  m.bodies[2] = {"link2", 1, {}, {}, {{"B", Vector3::Zero()}, {"C", Vector3(a, b, 0)}}};
  m.joints.resize(2);
  m.joints[0] = {"J1", JointType::revolute, 0, 1};
  m.joints[1] = {"J2", JointType::revolute, 1, 2, Vector3(length, 0, 0), Vector3::Zero()};
  m.tool = Tool{2, "C", Vector3(a, b, 0)};
  return m;
}

using Coefficients = std::vector<std::vector<double>>;

/// Made-up conditions in four parameters whose first is every row's pivot's place.
Conditions conditions(const Coefficients& rows) {
  Conditions c;
  c.status = ConditionsStatus::done;
  for (const char* name : {"p", "q", "r", "s"}) c.parameters.push_back(parameter(name, "m"));
  c.matrix.resize(static_cast<Eigen::Index>(rows.size()), 4);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k)
      c.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = rows[i][k];
    c.pivots.push_back(static_cast<int>(i));
  }
  c.rank = static_cast<int>(rows.size());
  return c;
}

double length(const Mechanism& m) { return m.joints[1].point_first.x(); }
double a(const Mechanism& m) { return m.tool->position.x(); }
double b(const Mechanism& m) { return m.tool->position.y(); }

std::string named(const std::function<Conditions(const Mechanism&)>& derive, int row = 0) {
  const Mechanism m = arm();
  const Conditions c = derive(m);
  return condition_text(c, row, name_coefficients(m, c, list_geometric_symbols(m), derive));
}

}  // namespace

TEST_CASE("the geometry lists every named point once, with all its places") {
  const auto numbers = list_geometric_parameters(arm());
  const auto find = [&](const std::string& label) {
    for (const auto& number : numbers)
      if (number.label == label) return number;
    FAIL("no ", label);
    return numbers.front();
  };
  const Mechanism larger = scale_geometric_parameter(arm(), find("link1.B.x"), 2);
  CHECK(larger.joints[1].point_first.x() == 1);
  CHECK(larger.bodies[1].points[1].position.x() == 1);
  CHECK(scale_geometric_parameter(arm(), find("link2.C.y"), 2).tool->position.y() == 0.3);
  CHECK(scale_geometric_parameter(arm(), find("g"), 2).gravity.y() == -19.62);
  CHECK(find("link2.C.x").unit == "m");
}

TEST_CASE("coefficients that follow a product of powers get its name, with small whole ratios in front") {
  CHECK(named([](const Mechanism& m) { return conditions({{1, length(m), 0, 0}}); }) == "p.m + link1.B.x q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, -length(m) * length(m) / 2, 0, 0}});
        }) == "p.m - (link1.B.x^2/2) q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, -3 * length(m) / a(m), 2 / a(m), 0.5}});
        }) == "p.m - (3 link1.B.x/link2.C.x) q.m + (2/link2.C.x) r.m + 0.5 s.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, 1 / (2 * a(m) * b(m)), 1.0 / 3, 0}});
        }) == "p.m + (1/(2 link2.C.x link2.C.y)) q.m + (1/3) r.m = 0");
}

TEST_CASE("coefficients that are sums of two products get both names") {
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, a(m) - length(m), 0, 0}});
        }) == "p.m + (link2.C.x - link1.B.x) q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, length(m) * (a(m) * a(m) + b(m) * b(m)), 0, 0}});
        }) == "p.m + link1.B.x (link2.C.x^2 + link2.C.y^2) q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, a(m) / length(m) - 1, -1 - b(m), 0}});
        }) == "p.m + (link2.C.x/link1.B.x - 1) q.m - (link2.C.y + 1) r.m = 0");
}

TEST_CASE("what is no product and no sum of two stays a number of six digits") {
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, std::sin(length(m)), 0, 0}});
        }) == "p.m + 0.479426 q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, 0.7310585 * length(m), 0, 0}});
        }) == "p.m + 0.365529 q.m = 0");
  CHECK(named([](const Mechanism& m) {
          return conditions({{1, std::sqrt(length(m)), 0, 0}});
        }) == "p.m + 0.707107 q.m = 0");
}

TEST_CASE("a formula's value is the coefficient that it names") {
  const Mechanism m = arm();
  const auto derive = [](const Mechanism& at) {
    return conditions({{1, 0, length(at) * (a(at) - b(at)), 2 * a(at) / b(at)}, {0, 1, -b(at) / 3, 4}});
  };
  const Conditions c = derive(m);
  const ConditionNames names = name_coefficients(m, c, list_geometric_symbols(m), derive);
  VectorX values(static_cast<Eigen::Index>(names.symbols.size()));
  for (Eigen::Index s = 0; s < values.size(); ++s) values[s] = names.symbols[static_cast<std::size_t>(s)].value;
  for (int row = 0; row < 2; ++row) {
    for (int p = 0; p < 4; ++p) {
      const CoefficientFormula* formula = names.find(row, p);
      CHECK((formula != nullptr) == (c.matrix(row, p) != 0));
      // Formulas are accepted within 1e-7.
      if (formula != nullptr) CHECK(formula->value(values) == doctest::Approx(c.matrix(row, p)).epsilon(1e-7));
    }
  }
  CHECK(names.symbols.size() == 3);
}

TEST_CASE("noise of a derivation does not hide a name, nor make one") {
  const auto perturbation = [](const Mechanism& m) {
    return 1e-10 * std::sin(1e6 * length(m) + 1e5 * a(m) + 1e4 * b(m));
  };
  CHECK(named([&](const Mechanism& m) {
          return conditions({{1, length(m) / a(m) + perturbation(m), length(m) - b(m) + perturbation(m),
                              0.123456 + perturbation(m)}});
        }) == "p.m + (link1.B.x/link2.C.x) q.m + (link1.B.x - link2.C.y) r.m + 0.123456 s.m = 0");
}

TEST_CASE("a symbol that changes which conditions there are is left out, the others still count") {
  const auto derive = [](const Mechanism& m) {
    return length(m) == 0.5 ? conditions({{1, a(m), b(m), 0}}) : conditions({{1, 0, 0, 0}, {0, 1, 0, 0}});
  };
  CHECK(named(derive) == "p.m + link2.C.x q.m + link2.C.y r.m = 0");
}

TEST_CASE("several numbers that one symbol governs change together") {
  const Mechanism m = arm(0.4, 0.4);
  const auto numbers = list_geometric_parameters(m);
  GeometricSymbol l{"l", "m", 0.2, {}};
  for (const auto& number : numbers)
    if (number.label == "link1.B.x" || number.label == "link2.C.x") l.uses.push_back({number, 1});
  const auto derive = [](const Mechanism& at) { return conditions({{1, length(at) * a(at), 0, 0}}); };
  const Conditions c = derive(m);
  CHECK(condition_text(c, 0, name_coefficients(m, c, {l}, derive)) == "p.m + 4 l^2 q.m = 0");
}

TEST_CASE("mechanisms beyond the limits keep their numbers and say so") {
  const Mechanism m = arm();
  const auto derive = [](const Mechanism& at) { return conditions({{1, length(at), 0, 0}}); };
  const Conditions c = derive(m);
  const ConditionNames names = name_coefficients(m, c, list_geometric_symbols(m), derive, {.max_parameters = 3});
  CHECK(condition_text(c, 0, names) == "p.m + 0.5 q.m = 0");
  CHECK(names.notes.size() == 1);
}

}  // namespace naming_test
