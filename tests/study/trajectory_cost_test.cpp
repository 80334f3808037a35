// Figures as functions of the parameters against simulations of mechanisms that have these parameters.

#include "balance/study/trajectory_cost.hpp"

#include "balance/base/rotation.hpp"
#include "balance/read/read_spec.hpp"
#include "balance/study/simulate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

using namespace balance;

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
  const Matrix3 R = rotation_about(Vector3::Random().normalized(), factor(random));
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

double value_of(const Metric& metric, Figure figure) {
  switch (figure) {
    case Figure::peak: return metric.peak;
    case Figure::rms: return metric.rms;
    case Figure::mean: return metric.mean;
    case Figure::range: return metric.range;
  }
  return NAN;
}

constexpr Figure all_figures[] = {Figure::peak, Figure::rms, Figure::mean, Figure::range};

/// Not linear in the parameters.
bool left_out(const std::string& quantity) { return quantity.starts_with("com_") || quantity.starts_with("joint_"); }

/// Largest peak of anything in this unit: what may have cancelled in a quantity that is balanced.
double largest_peak(const Result& result, const std::string& unit) {
  double largest = 0;
  for (const Metric& metric : result.metrics)
    if (metric.unit == unit) largest = std::max(largest, metric.peak);
  return largest;
}

/// Every metric of the result is what the cost says of the parameters. Differences are measured by the quantity's peak, which
/// its range may be far below; of a balanced quantity only round-off is left.
void compare(const TrajectoryCost& cost, const VectorX& parameters, const Result& result) {
  REQUIRE(result.outcome.status == MotionStatus::done);
  for (const Metric& metric : result.metrics)
    for (const Figure figure : all_figures) {
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
const Case cases[] = {
    {"3rrr.yaml", "cycloid"},         {"3rrr.yaml", "tool-bang"},         {"5r.yaml", "cycloid"},
    {"planar-rrr.yaml", "cycloid"},   {"spatial-rrr.yaml", "cycloid"},    {"delta.yaml", "cycloid"},
    {"stewart.yaml", "cycloid"},      {"spring-press.yaml", "bang-bang"}, {"spring-press.yaml", "steady"},
    {"slider-crank.yaml", "cycloid"}, {"scara.yaml", "cycloid"},          {"bricard.yaml", "cycloid"}};

void for_each_case(const std::function<void(const Mechanism&, Trajectory)>& test) {
  for (const Case& c : cases) {
    const Study study = config(c.file);
    INFO(c.file << ": " << c.trajectory);
    test(study.mechanism, find(study, c.trajectory));
  }
}

}  // namespace

TEST_CASE("every figure of other masses and stiffnesses is that of a simulation with them") {
  std::mt19937 random(5);
  for_each_case([&](const Mechanism& mechanism, Trajectory trajectory) {
    trajectory.about = {0.1, -0.2, 0.3};
    for (const long samples : {41, 42}) {  // jumps on samples and between them
      trajectory.samples = samples;
      const TrajectoryCost cost(mechanism, trajectory);
      REQUIRE_MESSAGE(cost.outcome().status == MotionStatus::done, cost.outcome().reason);
      compare(cost, parameter_values(mechanism), simulate(mechanism, trajectory));
      const Mechanism other = other_masses(mechanism, random);
      compare(cost, parameter_values(other), simulate(other, trajectory));
    }
  });
}
