#include "balance/mechanics/results/orders.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/results/round_off.hpp"
#include "balance/mechanics/results/run_quantities.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace balance::results {

namespace {

constexpr double uniform_speed_tolerance = 1e-9;  ///< of the speed: smaller changes are round-off
constexpr double whole_turns_tolerance = 1e-9;    ///< of a turn
constexpr double repetition_tolerance = 1e-9;     ///< of a quantity's range
constexpr int min_samples_per_period = 4;         ///< of the highest order

std::string format_short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string format_percentage(double fraction) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", 100 * fraction);
  return text;
}

/// Whole turns of a coordinate that turns uniformly from the first sample to the last; 0 if it does not.
int count_turns(const RunResult& run, Eigen::Index coordinate) {
  const auto rates = run.joint_velocity.col(coordinate);
  const double speed = rates[0],
               angle = run.joint_position(run.time.size() - 1, coordinate) - run.joint_position(0, coordinate);
  if (speed == 0 || numerics::max_abs((rates.array() - speed).matrix()) > uniform_speed_tolerance * std::abs(speed))
    return 0;
  const double turns = std::abs(angle) / (2 * std::numbers::pi);
  const double whole = std::round(turns);
  return std::abs(turns - whole) <= whole_turns_tolerance * (1 + turns) ? static_cast<int>(whole) : 0;
}

Eigen::Index coordinate_index(const RunResult& run, const std::string& name) {
  return std::find(run.coordinate_names.begin(), run.coordinate_names.end(), name) - run.coordinate_names.begin();
}

/// Quantities of the run itself, which are no numbers of its computation and no rotations.
bool is_physical(const RunQuantity& quantity) {
  return quantity.array != nullptr && quantity.array != &RunResult::mobility &&
         quantity.array != &RunResult::saturation && quantity.components.size() < 4;
}

/// The samples of a quantity but for the last one, which repeats the first.
using PeriodSamples = Eigen::Ref<const Samples, 0, Eigen::OuterStride<>>;

PeriodSamples period_of(const RunResult& run, const MetricSeries& series) {
  return (run.*series.array).block(0, series.first, run.time.size() - 1, series.count);
}

/// Of a quantity whose last sample differs from the first one: by how much, as a part of its range. 0: it repeats.
double find_repetition_error(const RunResult& run, const MetricSeries& series, double round_off) {
  const auto samples = (run.*series.array).middleCols(series.first, series.count);
  double range = 0, difference = 0;
  for (Eigen::Index c = 0; c < samples.cols(); ++c) {
    range = std::max(range, numerics::max_coefficient(samples.col(c)) - numerics::min_coefficient(samples.col(c)));
    difference = std::max(difference, std::abs(samples(samples.rows() - 1, c) - samples(0, c)));
  }
  return difference <= std::max(round_off, repetition_tolerance * range) ? 0 : difference / range;
}

/// Quantities that show whether a motion is periodic; positions of turning joints may grow.
bool must_repeat(const MetricSeries& series) {
  return series.array == &RunResult::torque || series.array == &RunResult::shaking_force ||
         series.array == &RunResult::shaking_moment || series.array == &RunResult::ground_force ||
         series.array == &RunResult::kinetic_energy;
}

void require_repetition(const RunResult& run, const MetricSeries& series, double round_off,
                        const UniformTurning& turning) {
  const double error = find_repetition_error(run, series, round_off);
  if (error > 0)
    throw std::invalid_argument("the motion does not repeat after " + count_noun(turning.turns, "turn", "turns") +
                                " of " + turning.coordinate + ": " + series.quantity + " differs by " +
                                format_percentage(error) + " % of its range; more turns may make a period");
}

void require_samples(const RunResult& run, double order, int turns) {
  const long needed = count_needed_samples(order, turns);
  if (run.time.size() < needed)
    throw std::invalid_argument("order " + format_order(order) + " needs at least " + std::to_string(needed) +
                                " samples");
}

/// Mean and variance, without any order yet.
QuantityOrders begin_orders(const PeriodSamples& samples, std::size_t orders) {
  QuantityOrders result;
  result.mean = samples.colwise().mean().transpose();
  result.variance = (samples.rowwise() - result.mean.transpose()).squaredNorm() / static_cast<double>(samples.rows());
  result.cosine.setZero(static_cast<Eigen::Index>(orders), samples.cols());
  result.sine = result.cosine;
  return result;
}

void fit_order(const Harmonic& harmonic, Eigen::Index order, const PeriodSamples& samples, QuantityOrders& result) {
  const double weight = 2 / static_cast<double>(samples.rows());
  const MatrixX deviation = samples.rowwise() - result.mean.transpose();
  result.cosine.row(order) = weight * harmonic.cosine.transpose() * deviation;
  result.sine.row(order) = weight * harmonic.sine.transpose() * deviation;
}

}  // namespace

const char* name_of(OrderPart part) {
  switch (part) {
    case OrderPart::forward: return "forward order";
    case OrderPart::backward: return "backward order";
    case OrderPart::whole: break;
  }
  return "order";
}

bool has_order(double order, int turns) {
  const double multiple = order * turns;
  return order > 0 && std::abs(multiple - std::round(multiple)) <= whole_turns_tolerance * multiple;
}

long count_needed_samples(double order, int turns) {
  return static_cast<long>(std::ceil(min_samples_per_period * order * turns)) + 1;
}

std::string format_order(double order) { return format_short(order); }

double QuantityOrders::amplitude(Eigen::Index order, Eigen::Index component) const {
  return std::hypot(cosine(order, component), sine(order, component));
}

double QuantityOrders::peak(Eigen::Index order) const {
  // the larger singular value of [a b]
  const double a = cosine.row(order).squaredNorm(), b = sine.row(order).squaredNorm(),
               product = cosine.row(order).dot(sine.row(order));
  return std::sqrt((a + b) / 2 + std::hypot((a - b) / 2, product));
}

double QuantityOrders::share(Eigen::Index order) const {
  const double square = (cosine.row(order).squaredNorm() + sine.row(order).squaredNorm()) / 2;
  return variance > 0 ? std::min(1.0, square / variance) : 0;
}

UniformTurning find_uniform_turning(const RunResult& run) {
  std::vector<std::string> names = run.actuator_names;
  names.insert(names.end(), run.coordinate_names.begin(), run.coordinate_names.end());
  for (const std::string& name : names) {
    const Eigen::Index c = coordinate_index(run, name);
    if (c == run.joint_position.cols() || run.coordinate_units[static_cast<std::size_t>(c)] != "rad") continue;
    if (const int turns = count_turns(run, c); turns > 0) return {name, run.joint_velocity(0, c), turns};
  }
  throw std::invalid_argument(
      "orders are those of a motion in which a joint makes whole turns at constant speed, such as 'law: uniform' with "
      "'turns: 1': in this one no joint does");
}

Harmonic::Harmonic(const VectorX& angle, double order) : cosine(angle.size() - 1), sine(angle.size() - 1) {
  for (Eigen::Index k = 0; k < cosine.size(); ++k) {
    cosine[k] = elementary::cos(order * angle[k]);
    sine[k] = elementary::sin(order * angle[k]);
  }
}

OrderAnalysis analyse_orders(const RunResult& run, int highest, std::optional<double> stated) {
  if (highest < 1) throw std::invalid_argument("the highest order is 1 or more");
  OrderAnalysis analysis;
  analysis.turning = find_uniform_turning(run);
  const int turns = analysis.turning.turns;
  require_samples(run, highest, turns);
  for (int k = 1; k <= highest * turns; ++k) analysis.orders.push_back(static_cast<double>(k) / turns);
  const RunQuantities quantities(&run, nullptr);
  std::vector<PeriodSamples> periods;
  for (const RunQuantity& quantity : quantities.list()) {
    if (!is_physical(quantity)) continue;
    const int count = std::max(1, static_cast<int>(quantity.components.size()));
    const MetricSeries series{quantity.name, quantity.unit, quantity.array, quantity.first, count, ""};
    const double round_off = column_round_off(run, series.array, series.first);
    if (must_repeat(series))
      require_repetition(run, series, round_off, analysis.turning);
    else if (find_repetition_error(run, series, round_off) > 0)
      continue;
    periods.push_back(period_of(run, series));
    QuantityOrders orders = begin_orders(periods.back(), analysis.orders.size());
    orders.quantity = quantity.name, orders.unit = quantity.unit, orders.round_off = round_off;
    if (count > 1) orders.components = quantity.components;
    analysis.quantities.push_back(std::move(orders));
  }
  const VectorX angle = run.joint_position.col(coordinate_index(run, analysis.turning.coordinate));
  for (std::size_t n = 0; n < analysis.orders.size(); ++n) {
    const Harmonic harmonic(angle, analysis.orders[n]);
    for (std::size_t q = 0; q < periods.size(); ++q)
      fit_order(harmonic, static_cast<Eigen::Index>(n), periods[q], analysis.quantities[q]);
  }
  analysis.fluctuation = analyse_speed_fluctuation(run, analysis.turning, stated);
  return analysis;
}

double compute_order_peak(const RunResult& run, const MetricSeries& series, double order, OrderPart part) {
  if (part != OrderPart::whole && series.count != 2)
    throw std::invalid_argument(std::string("only a vector in the plane has a ") + name_of(part));
  const UniformTurning turning = find_uniform_turning(run);
  if (!has_order(order, turning.turns))
    throw std::invalid_argument("a run of " + count_noun(turning.turns, "turn", "turns") + " has no order " +
                                format_short(order));
  require_samples(run, order, turning.turns);
  const double round_off = column_round_off(run, series.array, series.first);
  require_repetition(run, series, round_off, turning);
  const VectorX angle = run.joint_position.col(coordinate_index(run, turning.coordinate));
  QuantityOrders orders = begin_orders(period_of(run, series), 1);
  fit_order(Harmonic(angle, order), 0, period_of(run, series), orders);
  const RotatingParts parts = part == OrderPart::whole ? RotatingParts{} : split_rotation(orders, 0);
  return suppress_round_off(round_off, part == OrderPart::whole     ? orders.peak(0)
                                       : part == OrderPart::forward ? parts.forward
                                                                    : parts.backward);
}

RotatingParts split_rotation(const QuantityOrders& orders, Eigen::Index order) {
  const double ax = orders.cosine(order, 0), bx = orders.sine(order, 0), ay = orders.cosine(order, 1),
               by = orders.sine(order, 1);
  // x + i y = forward · exp(i n θ) + backward · exp(−i n θ)
  return {std::hypot(ax + by, ay - bx) / 2, std::hypot(ax - by, ay + bx) / 2};
}

}  // namespace balance::results
