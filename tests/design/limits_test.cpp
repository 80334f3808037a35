#include "mechanisms.hpp"
#include "objectives.hpp"

#include "balance/synthesis/design/derived_problems.hpp"
#include "balance/synthesis/design/problem_functions.hpp"

#include <doctest/doctest.h>

#include <stdexcept>

using namespace design_tests;

namespace {

/// Counterweight of free mass at x and y on one link of 2 kg whose CoM lies at 0.25.
DesignProblem one_counterweight(double x, double y, double most) {
  return problem(
      {{"cw.mass", 0, most, 0}},
      [x, y](const VectorX& mass) {
        Mechanism m = planar_arm({0.5}, {2});
        m.attachments = {counterweight("cw", 1, x, y, mass[0])};
        return m;
      },
      GoalKind::statics);
}

/// Two links; only the first one's CoM is free.
DesignProblem upper_arm_alone() {
  return problem(
      {{"com1", -0.6, 0.6, 0.2}},
      [](const VectorX& x) {
        Mechanism m = planar_arm({0.5, 0.4}, {3, 1});
        m.bodies[1].com[0] = x[0];
        return m;
      },
      GoalKind::statics);
}

class UnassembledModel final : public DesignModelDecorator {
 public:
  using DesignModelDecorator::DesignModelDecorator;
  Conditions derive_conditions(const Mechanism& /*mechanism*/, const std::vector<Goal>& /*goals*/,
                               const ConditionOptions& /*options*/) const override {
    Conditions conditions;
    conditions.status = ConditionsStatus::not_assembled;
    conditions.reason = "the loops cannot be closed";
    return conditions;
  }
};

/// weight · max(x₀, x₁²) as by a simulation that knows its slopes.
class SteepFunction final : public DesignFunction {
 public:
  explicit SteepFunction(double weight) : weight_(weight) {}
  Domain domain() const override { return Domain::variables; }
  double evaluate(const VectorX& x, VectorX* /*gradient*/) const override {
    return weight_ * std::max(x[0], x[1] * x[1]);
  }
  bool has_max_terms() const override { return true; }
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& x) const override {
    return std::vector<MaxTerm>{{weight_, VectorX{{x[0], x[1] * x[1]}}, MatrixX{{1, 0}, {0, 2 * x[1]}}}};
  }

 private:
  double weight_;
};

DesignLimit steep_limit(double weight, double bound) {
  Objective figure;
  figure.name = "steep";
  figure.function = std::make_shared<const SteepFunction>(weight);
  return {"steep", figure, false, bound};
}

}  // namespace

TEST_CASE("too small a counterweight is used in full, and the bounds are named as the reason") {
  const auto design = one_counterweight(-0.2, 0, 1.5);  // 2.5 kg are needed
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::infeasible);
  REQUIRE(outcome.certificate);
  CHECK(outcome.certificate->kind == conditions::InfeasibilityCertificate::Kind::bounds);
  CHECK(outcome.x[0] == 1.5);
  CHECK(outcome.unmet_conditions.size() == 1);
  CHECK(std::abs(outcome.residuals_after[outcome.unmet_conditions[0]]) <
        std::abs(outcome.residuals_before[outcome.unmet_conditions[0]]));
  CHECK_FALSE(outcome.reason.empty());
}

TEST_CASE("the best compromise between two conditions is the least-squares one") {
  // a counterweight off the link's line cannot meet mx and my at once
  const auto design = one_counterweight(-0.2, 0.1, 10);
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::infeasible);
  const Conditions conditions = derive_conditions(design.model->build_mechanism(outcome.x), design.goals);
  const auto sum = [&](double mass) {
    return scaled_residuals(conditions,
                            dynamics::parameter_values(design.model->build_mechanism(VectorX::Constant(1, mass))))
        .squaredNorm();
  };
  CHECK(sum(outcome.x[0]) < sum(outcome.x[0] + 0.01));
  CHECK(sum(outcome.x[0]) < sum(outcome.x[0] - 0.01));
}

TEST_CASE("a condition without a free number is named, and the others are met all the same") {
  const auto design = upper_arm_alone();
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::infeasible);
  REQUIRE(outcome.unmet_fixed_conditions.size() == 1);
  const int fixed = outcome.unmet_fixed_conditions[0];
  CHECK(outcome.condition_variables[static_cast<std::size_t>(fixed)].empty());
  CHECK(outcome.unmet_conditions == outcome.unmet_fixed_conditions);
  CHECK(outcome.reason.find("link2.mx") != std::string::npos);
  // link1.mx + 0.5 link2.m = 0
  CHECK(outcome.x[0] == doctest::Approx(-0.5 / 3).epsilon(1e-13));
}

TEST_CASE("without free numbers every condition is fixed") {
  auto design = upper_arm_alone();
  design.variables.clear();
  design.model = model_of([](const VectorX&) { return planar_arm({0.5, 0.4}, {3, 1}); });
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::infeasible);
  CHECK(outcome.unmet_fixed_conditions.size() == 2);  // link1.mx + 0.5 link2.m and link2.mx; my vanishes as it is
  CHECK(outcome.x.size() == 0);
}

TEST_CASE("a balanced mechanism stays as it is") {
  auto design = upper_arm_alone();
  design.model = model_of([](const VectorX& x) {
    Mechanism m = planar_arm({0.5}, {3});
    m.bodies[1].com[0] = 0;
    m.bodies[1].inertia(2, 2) = 0.1 + x[0] * x[0];
    return m;
  });
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::balanced);
  CHECK(outcome.method == DesignMethod::none);
  CHECK(outcome.x[0] == 0.2);
}

TEST_CASE("a goal without conditions is met by every mechanism") {
  auto design = upper_arm_alone();
  design.model = model_of([with_weight = design.model](const VectorX& x) {
    Mechanism m = with_weight->build_mechanism(x);
    m.gravity.setZero();
    return m;
  });
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.conditions.rank == 0);
  CHECK(outcome.status == DesignStatus::balanced);
}

TEST_CASE("conditions that cannot be derived leave the design unsolved, with their reason") {
  auto design = upper_arm_alone();
  design.model = std::make_shared<const UnassembledModel>(design.model);
  const DesignOutcome outcome = solve_design(design);
  CHECK(outcome.status == DesignStatus::unsolved);
  CHECK(outcome.reason == "the loops cannot be closed");
  CHECK(outcome.conditions.status == ConditionsStatus::not_assembled);
}

TEST_CASE("a compromise by a figure of the motion is that figure's least value, with a proof") {
  // (m - 0.7)^2 over masses of at most 1.5 kg, of which none balances
  auto design = one_counterweight(-0.2, 0, 1.5);
  Objective figure;
  figure.name = "figure";
  figure.is_convex = true;
  figure.function = of_parameters([](const VectorX& p, VectorX* gradient) {
    const double off = p[4] - 0.7;  // the counterweight's mass: the link has the first four parameters
    if (gradient != nullptr) *gradient = VectorX::Unit(p.size(), 4) * (2 * off);
    return off * off + 1;
  });
  design.objective = figure;
  for (const bool convex : {true, false}) {
    design.objective->is_convex = convex;
    const DesignOutcome outcome = solve_design(design);
    CHECK(outcome.status == DesignStatus::infeasible);
    CHECK(outcome.x[0] == doctest::Approx(0.7).epsilon(1e-5));
    CHECK((outcome.optimality == Optimality::proved_global) == convex);
  }
}

TEST_CASE("a compromise by simulation keeps the bounds and improves the figure, whatever the search") {
  auto design = one_counterweight(-0.2, 0, 1.5);
  Objective figure;
  figure.name = "figure";
  figure.function = of_variables([](const VectorX& x) { return x[0] > 1.4 ? NAN : std::abs(x[0] - 0.7) + 1; });
  design.objective = figure;
  design.search.max_evaluations = 300;
  for (const std::string global : {"direct", "crs", "isres", "esch", "mlsl"}) {
    CAPTURE(global);
    design.search.global = global;
    const DesignOutcome outcome = solve_design(design), again = solve_design(design);
    CHECK(outcome.status == DesignStatus::infeasible);
    CHECK(outcome.x[0] == doctest::Approx(0.7).epsilon(1e-3));
    CHECK(outcome.x == again.x);
  }
}

TEST_CASE("an objective along the conditions is minimised by simulation too") {
  auto design = two_counterweights();
  Objective figure;
  figure.name = "figure";
  figure.function = of_variables([](const VectorX& x) { return x.squaredNorm(); });
  design.objective = figure;
  for (const std::string method : {"auto", "cobyla", "bobyqa", "sbplx", "slsqp"}) {
    CAPTURE(method);
    design.search.local = method;
    const DesignOutcome outcome = solve_design(design);
    REQUIRE(outcome.status == DesignStatus::balanced);
    CHECK(outcome.objective == doctest::Approx(1.25).epsilon(1e-6));
    CHECK(outcome.residuals_after.cwiseAbs().maxCoeff() < 1e-14);
  }
}

TEST_CASE("a limit's slope is its own figure's, whatever the objective's, and so is that of the largest violation") {
  auto design = two_counterweights({"a", 0, 2, 0.5}, {"b", 0, 3, 0.5});
  design.objective = steep_limit(7, 1).figure;
  design.limits = {steep_limit(3, 2), steep_limit(-5, -4)};
  for (const VectorX& u : {VectorX{{0.2, -0.6}}, VectorX{{-0.4, 0.5}}}) {
    const auto central_difference = [&](const auto& f) {
      constexpr double step = 1e-6;
      VectorX slope(2);
      for (Eigen::Index i = 0; i < 2; ++i)
        slope[i] = (f(u + step * VectorX::Unit(2, i)) - f(u - step * VectorX::Unit(2, i))) / (2 * step);
      return slope;
    };
    for (const DesignProblem& asked : {design, design::make_phase_one_problem(design)}) {
      design::SearchBudget budget(10);
      const design::SolverContext context(asked, budget);
      const design::ScaledObjective objective(context, *asked.objective);
      VectorX slope, g;
      MatrixX jacobian;
      objective(u, &slope);
      CHECK((slope - central_difference([&](const VectorX& v) { return objective(v, nullptr); })).norm() < 1e-8);
      context.limits->evaluate(u, g, &jacobian);
      for (Eigen::Index k = 0; k < g.size(); ++k) {
        const auto value = [&](const VectorX& v) {
          VectorX there;
          context.limits->evaluate(v, there, nullptr);
          return there[k];
        };
        CHECK((jacobian.row(k).transpose() - central_difference(value)).norm() < 1e-8);
      }
    }
  }
}

TEST_CASE("trouble inside an objective reaches the caller") {
  auto design = one_counterweight(-0.2, 0, 1.5);
  Objective figure;
  figure.function = of_variables([](const VectorX&) -> double { throw std::runtime_error("the disk is full"); });
  design.objective = figure;
  CHECK_THROWS_WITH_AS(solve_design(design), "the disk is full", std::runtime_error);
}

TEST_CASE("search options out of range are refused") {
  const auto refused = [](auto change) {
    study::SearchOptions options;
    change(options);
    CHECK_THROWS_AS(options.validate(), std::invalid_argument);
  };
  CHECK_NOTHROW(study::SearchOptions{}.validate());
  refused([](study::SearchOptions& o) { o.global = "annealing"; });
  refused([](study::SearchOptions& o) { o.local = "newton"; });
  refused([](study::SearchOptions& o) { o.max_restarts = 0; });
  refused([](study::SearchOptions& o) { o.max_restarts = 10001; });
  refused([](study::SearchOptions& o) { o.max_evaluations = 0; });
  refused([](study::SearchOptions& o) { o.max_time = 0; });
  refused([](study::SearchOptions& o) { o.max_time = NAN; });
}

TEST_CASE("a free number needs finite bounds around its start") {
  auto design = one_counterweight(-0.2, 0, 1.5);
  for (const DesignVariable& wrong :
       {DesignVariable{"v", 0, 1, 2}, DesignVariable{"v", 1, 0, 0.5}, DesignVariable{"v", 0, INFINITY, 1}}) {
    design.variables = {wrong};
    CHECK_THROWS_AS(solve_design(design), std::invalid_argument);
  }
}
