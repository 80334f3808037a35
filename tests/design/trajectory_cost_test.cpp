// Figures as functions of the parameters against simulations of mechanisms that have these parameters.

#include "../sampling.hpp"

#include "balance/synthesis/design/trajectory_cost.hpp"

#include "balance/foundation/base/rotation.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/motion/simulation/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::design;
using namespace balance::dynamics;

namespace {

Study config(const std::string& file) { return read_spec_file(std::string(BALANCE_CONFIGS "/") + file); }

const Trajectory& find(const Study& study, const std::string& name) {
  for (const Trajectory& trajectory : study.trajectories)
    if (trajectory.name == name) return trajectory;
  throw std::invalid_argument("no trajectory " + name);
}

/// A number near one.
double factor(std::mt19937& random) { return 0.5 + static_cast<double>(random() % 1000) / 1000; }

Vector3 shift(const Mechanism& mechanism, std::mt19937& random) {
  const double length = 0.2 * characteristic_length(mechanism);
  const double z = mechanism.space == SpaceKind::planar ? 0 : length * (factor(random) - 1);
  return {length * (factor(random) - 1), length * (factor(random) - 1), z};
}

/// An inertia tensor of another size and, in space, other principal axes.
Matrix3 another(const Matrix3& inertia, bool planar, std::mt19937& random) {
  if (planar) return factor(random) * inertia;
  const Vector3 axis(factor(random) - 1, factor(random) - 1, 1);
  const Matrix3 R = rotation_about(axis.normalized(), factor(random));
  return factor(random) * R * inertia * R.transpose();
}

/// The same mechanism with all masses elsewhere and of other sizes, all springs of other stiffness.
Mechanism other_masses(Mechanism m, std::mt19937& random) {
  const bool planar = m.space == SpaceKind::planar;
  for (std::size_t b = 1; b < m.bodies.size(); ++b) {
    m.bodies[b].mass *= factor(random);
    m.bodies[b].com += shift(m, random);
    m.bodies[b].inertia = another(m.bodies[b].inertia, planar, random);
  }
  for (Attachment& extra : m.attachments) {
    extra.mass = 0.1 + factor(random) * extra.mass;
    extra.position += shift(m, random);
    extra.inertia = another(extra.inertia, planar, random);
  }
  for (Disc& disc : m.discs) disc.mass *= factor(random), disc.inertia *= factor(random);
  for (Spring& spring : m.springs) spring.stiffness *= factor(random);
  return m;
}

double value_of(const Metric& metric, Statistic figure) {
  switch (figure) {
    case Statistic::peak: return metric.peak;
    case Statistic::rms: return metric.rms;
    case Statistic::mean: return metric.mean;
    case Statistic::range: return metric.range;
    case Statistic::minimum: return metric.minimum;
    case Statistic::maximum: return metric.maximum;
  }
  return NAN;
}

using Names = std::vector<std::string>;

constexpr Statistic all_figures[] = {Statistic::peak,  Statistic::rms,     Statistic::mean,
                                     Statistic::range, Statistic::minimum, Statistic::maximum};

/// Not linear in the parameters.
bool left_out(const std::string& quantity) { return quantity.starts_with("com_") || quantity == "shaking_moment_com"; }

/// Largest peak of anything in this unit: what may have cancelled in a quantity that is balanced.
double largest_peak(const RunResult& result, const std::string& unit) {
  double largest = 0;
  for (const Metric& metric : result.metrics)
    if (metric.unit == unit) largest = std::max(largest, metric.peak);
  return largest;
}

/// Of the reactions, which have many more rows than other quantities, one figure stands for all.
std::vector<Statistic> figures_of(const std::string& quantity) {
  if (quantity.starts_with("joint_")) return {Statistic::peak};
  return {std::begin(all_figures), std::end(all_figures)};
}

/// Every metric of the result is what the cost says of the parameters. Differences are measured by the quantity's peak, which
/// its range may be far below; of a balanced quantity only round-off is left.
void compare(const TrajectoryCost& cost, const VectorX& parameters, const RunResult& result) {
  REQUIRE(result.outcome.status == MotionStatus::done);
  for (const Metric& metric : result.metrics)
    for (const Statistic figure : figures_of(metric.quantity)) {
      const auto function = cost.figure(figure, metric.quantity);
      CHECK_MESSAGE(function.has_value() == !left_out(metric.quantity), metric.quantity);
      if (!function) continue;
      const double value = (*function)(parameters, nullptr);
      CHECK_MESSAGE(
          std::abs(value - value_of(metric, figure)) <= 1e-10 * metric.peak + 1e-13 * largest_peak(result, metric.unit),
          metric.quantity << " figure " << static_cast<int>(figure) << ": " << value << " against "
                          << value_of(metric, figure));
    }
}

struct Case {
  std::string file, trajectory;
};

/// Planar and spatial, open and closed, with counterweights, discs, loads, springs, friction, jumps, gravity and without.
const std::vector<Case> cases = {
    {"3rrr.yaml", "cycloid"},         {"3rrr.yaml", "tool-bang"},         {"5r.yaml", "cycloid"},
    {"planar-rrr.yaml", "cycloid"},   {"spatial-rrr.yaml", "cycloid"},    {"delta.yaml", "cycloid"},
    {"stewart.yaml", "cycloid"},      {"spring-press.yaml", "bang-bang"}, {"spring-press.yaml", "steady"},
    {"slider-crank.yaml", "cycloid"}, {"scara.yaml", "cycloid"},          {"bricard.yaml", "cycloid"}};

void for_each_case(const std::string& what, const std::function<void(const Mechanism&, Trajectory)>& test) {
  const auto traits = [](const Case& c) { return sampling::traits_of(std::string(BALANCE_CONFIGS "/") + c.file); };
  for (const Case& c : sampling::draw(what, cases, 0.3, traits)) {
    const Study study = config(c.file);
    INFO(c.file << ": " << c.trajectory);
    test(study.mechanism, find(study, c.trajectory));
  }
}

}  // namespace

TEST_CASE("every figure of other masses and stiffnesses is that of a simulation with them") {
  std::mt19937 random(5);
  for_each_case("figures of other masses", [&](const Mechanism& mechanism, Trajectory trajectory) {
    trajectory.about = {0.1, -0.2, 0.3};
#ifdef BALANCE_SANITIZED
    const std::vector<long> grids = {42};
#else
    const std::vector<long> grids = {41, 42};  // jumps on samples and between them
#endif
    for (const long samples : sampling::draw("grids for " + mechanism.name, grids, 0.5)) {
      trajectory.samples = samples;
      const TrajectoryCost cost(mechanism, trajectory);
      REQUIRE_MESSAGE(cost.outcome().status == MotionStatus::done, cost.outcome().reason);
      compare(cost, parameter_values(mechanism), simulate(mechanism, trajectory));
      const Mechanism other = other_masses(mechanism, random);
      compare(cost, parameter_values(other), simulate(other, trajectory));
    }
  });
}

TEST_CASE("of loose springs the end points may change too") {
  std::mt19937 random(6);
  Study spatial = config("spatial-rrr.yaml");
  spatial.mechanism.springs = {{"s1", 0, 2, {0.1, 0.2, 0.5}, {0.05, -0.1, 0.2}, 300, 0},
                               {"s2", 1, 3, {-0.1, 0.1, 0}, {0.1, 0, 0.1}, 200, 0},
                               {"s3", 0, 3, {0.3, 0, 0.2}, {0, 0.1, 0}, 100, 0.2}};
  for (const Study& study : {config("spring-balancer-two-link.yaml"), spatial}) {
    const Mechanism& mechanism = study.mechanism;
    Trajectory trajectory = find(study, "cycloid");
    trajectory.samples = 41;
    FreeSprings loose;
    for (const Spring& spring : mechanism.springs) loose.push_back(spring.free_length == 0);
    const TrajectoryCost cost(mechanism, trajectory, loose);
    Mechanism other = other_masses(mechanism, random);
    for (std::size_t s = 0; s < loose.size(); ++s) {
      if (!loose[s]) continue;
      other.springs[s].point_first += shift(mechanism, random);
      other.springs[s].point_second += shift(mechanism, random);
    }
    compare(cost, parameter_values(other, loose), simulate(other, trajectory));
  }
}

TEST_CASE("more motors than freedoms share the effort as in a simulation") {
  std::mt19937 random(8);
  const Study study = config("four-bar.yaml");
  Mechanism mechanism = study.mechanism;
  mechanism.actuators = {0, 1};
  Trajectory trajectory = find(study, "cycloid");
  trajectory.samples = 41;
  const TrajectoryCost cost(mechanism, trajectory);
  REQUIRE(cost.outcome().status == MotionStatus::done);
  const Mechanism other = other_masses(mechanism, random);
  compare(cost, parameter_values(other), simulate(other, trajectory));
}

TEST_CASE("where the centre of mass is driven, the figures are those of the mechanism's own masses") {
  const Study study = config("3rrr.yaml");
  Trajectory trajectory = find(study, "bang-bang");
  CHECK(is_mass_dependent(trajectory));
  CHECK_FALSE(is_mass_dependent(find(study, "cycloid")));
  trajectory.samples = 42;
  compare(TrajectoryCost(study.mechanism, trajectory), parameter_values(study.mechanism),
          simulate(study.mechanism, trajectory));
}

TEST_CASE("the gradient is what finite differences say, along random directions") {
  std::mt19937 random(9);
  const auto uniform = [&] { return 2 * factor(random) - 2; };
  for_each_case("gradients of figures", [&](const Mechanism& mechanism, Trajectory trajectory) {
    trajectory.samples = 21;
    const TrajectoryCost cost(mechanism, trajectory);
    const VectorX pi = parameter_values(other_masses(mechanism, random));
    for (const std::string& quantity :
         Names{"torque", "power", "shaking_force", "shaking_moment", "ground_force", "ground_moment", "kinetic_energy"})
      for (const Statistic figure : all_figures) {
        const auto function = cost.figure(figure, quantity);
        if (!function) continue;  // torque and force are no common quantity
        VectorX gradient, direction(pi.size());
        const double value = (*function)(pi, &gradient);
        REQUIRE(gradient.size() == pi.size());
        for (Eigen::Index p = 0; p < pi.size(); ++p) direction[p] = uniform() * (std::abs(pi[p]) + 1e-3);
        // central differences of a smooth function miss by h², and by the round-off of its values over h
        constexpr double h = 1e-5;
        const VectorX ahead = pi + h * direction, behind = pi - h * direction;
        const double forward = ((*function)(ahead, nullptr) - value) / h;
        const double backward = (value - (*function)(behind, nullptr)) / h;
        const double slope = (forward + backward) / 2, along = gradient.dot(direction);
        const double scale = std::abs(value) + gradient.cwiseAbs().dot(direction.cwiseAbs());
        // where another place becomes the peak within h, the gradient is that of one side
        const double beside = std::min(std::abs(along - forward), std::abs(along - backward));
        const bool corner = std::abs(forward - backward) > 1e-3 * scale && beside < 1e-5 * scale;
        CHECK_MESSAGE((corner || std::abs(along - slope) <= 1e-7 * scale),
                      quantity << " figure " << static_cast<int>(figure) << ": " << along << " against " << slope);
      }
  });
}

TEST_CASE("peak and rms are convex") {
  std::mt19937 random(10);
  for_each_case("convex figures", [&](const Mechanism& mechanism, Trajectory trajectory) {
    trajectory.samples = 21;
    const TrajectoryCost cost(mechanism, trajectory);
    const VectorX a = parameter_values(mechanism), b = parameter_values(other_masses(mechanism, random));
    for (const std::string& quantity : Names{"torque", "shaking_force", "ground_moment"})
      for (const Statistic figure : {Statistic::peak, Statistic::rms})
        if (const auto f = cost.figure(figure, quantity)) {
          const double ends = ((*f)(a, nullptr) + (*f)(b, nullptr)) / 2, middle = (*f)((a + b) / 2, nullptr);
          CHECK_MESSAGE(middle <= ends * (1 + 1e-12), quantity);  // round-off
          // strictly where parameters are no multiples; a scalar may have its peak at the same sample all the way
          if (figure == Statistic::rms) CHECK_MESSAGE(middle < ends, quantity);
        }
  });
}

TEST_CASE(
    "a billionth of a counterweight off balance, the force's rms is a billionth of what the counterweight makes") {
  const Study study = config("5r-balanced.yaml");
  const TrajectoryCost cost(study.mechanism, find(study, "cycloid"));
  const CostFunction rms = cost.figure(Statistic::rms, "shaking_force").value();
  VectorX pi = parameter_values(study.mechanism);
  const double scale = cost.figure(Statistic::rms, "ground_force").value()(pi, nullptr);
  CHECK(rms(pi, nullptr) < 1e-13 * scale);
  VectorX without = pi, nearly = pi;
  const Eigen::Index first =
      4 * static_cast<Eigen::Index>(study.mechanism.bodies.size() - 1);  // attachments' parameters
  without.segment(first, 4).setZero();
  nearly.segment(first, 4) *= 1 - 1e-9;
  // 1e-4: round-off of 1e-13 beside 1e-9
  CHECK(rms(nearly, nullptr) == doctest::Approx(1e-9 * rms(without, nullptr)).epsilon(1e-4));
}

TEST_CASE("a trajectory that cannot be followed has a reason and no figures") {
  const Study study = config("planar-rrr.yaml");
  Mechanism mechanism = study.mechanism;
  mechanism.actuators.pop_back();
  const TrajectoryCost cost(mechanism, find(study, "cycloid"));
  CHECK(cost.outcome().status == MotionStatus::mismatch);
  CHECK(cost.outcome().reason == simulate(mechanism, find(study, "cycloid")).outcome.reason);
  CHECK_FALSE(cost.figure(Statistic::rms, "shaking_force").has_value());
}

TEST_CASE("a singularity on the way ends the cost where it ends the simulation") {
  const Study study = config("3rrr.yaml");
  Trajectory trajectory = find(study, "cycloid");
  trajectory.to.tool = Vector3(3, 0, 0);
  const TrajectoryCost cost(study.mechanism, trajectory);
  const MotionOutcome outcome = simulate(study.mechanism, trajectory).outcome;
  CHECK(outcome.status != MotionStatus::done);
  CHECK(cost.outcome().status == outcome.status);
  CHECK(cost.outcome().reason == outcome.reason);
}

TEST_CASE("quantities that do not exist have no figure") {
  const Study arm = config("planar-rrr.yaml"), scara = config("scara.yaml");
  const TrajectoryCost of_arm(arm.mechanism, find(arm, "cycloid"));
  for (const std::string& name :
       Names{"", "torque[", "torque[]", "torque[nobody]", "power[nobody]", "shaking_force[J1]", "noise"})
    CHECK_MESSAGE(!of_arm.figure(Statistic::rms, name), name);
  // torques and forces cannot be compared, powers can
  const TrajectoryCost of_scara(scara.mechanism, find(scara, "cycloid"));
  CHECK_FALSE(of_scara.figure(Statistic::rms, "torque"));
  CHECK(of_scara.figure(Statistic::rms, "power"));
}

TEST_CASE("parameters of another number are refused") {
  const Study arm = config("planar-rrr.yaml");
  const auto function = TrajectoryCost(arm.mechanism, find(arm, "cycloid")).figure(Statistic::rms, "torque").value();
  CHECK_THROWS_AS(function(VectorX::Ones(3), nullptr), std::invalid_argument);
}
