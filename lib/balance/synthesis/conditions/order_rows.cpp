#include "balance/synthesis/conditions/order_rows.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/force_regressor.hpp"
#include "balance/mechanics/dynamics/tree_motion_source.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/known_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace balance::conditions {

namespace {

constexpr long min_order_samples = 64, max_order_samples = 16'384;
constexpr int samples_per_order = 8;  ///< and turn, at least
/// Relative to a quantity's magnitude: change of a coefficient by doubling the samples that counts as round-off, and the
/// largest that is accepted for loads and friction, whose parts need not be smooth.
constexpr double spectral_tolerance = 1e-12, known_term_tolerance = 1e-3;
constexpr double repetition_tolerance = 1e-9;     ///< of a quantity's magnitude
constexpr double uniform_speed_tolerance = 1e-9;  ///< of the speed
constexpr double whole_turns_tolerance = 1e-9;    ///< of a turn

/// The mechanism with one unit of a single known term and no other; of what a load's table states, the table that makes
/// the term's value 1.
Mechanism keep_known_term(const Mechanism& mechanism, const dynamics::Parameter& term, double value) {
  Mechanism kept = mechanism;
  kept.loads.clear();
  kept.friction.clear();
  if (term.owner_kind == dynamics::ParameterOwner::friction) {
    Friction friction;
    friction.coordinate = mechanism.friction[static_cast<std::size_t>(term.index)].coordinate;
    if (mechanism.friction[static_cast<std::size_t>(term.index)].coulomb_backward) friction.coulomb_backward = 0;
    friction_coefficient(friction, term) = 1;
    kept.friction.push_back(friction);
    return kept;
  }
  Load load = mechanism.loads[static_cast<std::size_t>(term.index)];
  const bool is_planar = mechanism.space == SpaceKind::planar;
  const Eigen::Index component = load_component(term, is_planar) % (is_planar ? 3 : 6), forces = is_planar ? 2 : 3;
  const auto entry_of = [&](Load& one, std::size_t k) -> double& {
    if (component < forces) return one.force[k][component];
    return one.moment[k][is_planar ? 2 : component - forces];
  };
  Load given = load;
  for (std::size_t k = 0; k < load.force.size(); ++k) {
    load.force[k].setZero();
    load.moment[k].setZero();
    entry_of(load, k) = load.is_over_coordinate() ? entry_of(given, k) / value
                        : is_load_change(term)    ? (entry_of(given, k) - entry_of(given, 0)) / value
                                                  : 1;
  }
  kept.loads.push_back(std::move(load));
  return kept;
}

/// Whether a known term is the size of what a load's table states; else a unit of it exists without a table.
bool is_table_value(const Mechanism& mechanism, const dynamics::Parameter& term) {
  return term.owner_kind == dynamics::ParameterOwner::load &&
         (is_load_change(term) || mechanism.loads[static_cast<std::size_t>(term.index)].is_over_coordinate());
}

bool has_known_terms(const dynamics::AffineQuantity& quantity) {
  using Kind = dynamics::AffineQuantity::Kind;
  return quantity.kind != Kind::shaking_force && quantity.kind != Kind::shaking_moment &&
         quantity.kind != Kind::kinetic_energy;
}

/// The goals of one quantity along one motion.
struct QuantityOrders {
  std::string name, unit;
  dynamics::AffineQuantity quantity;
  std::vector<std::size_t> goals;
  std::vector<MatrixX> cosine, sine;            ///< per goal: sums over the samples, rows × terms
  std::vector<MatrixX> even_cosine, even_sine;  ///< of every second sample
  MatrixX first, squares;                       ///< at the start; sum of squares
};

/// Samples of one motion.
template <class S>
class OrderSampler {
 public:
  OrderSampler(const Mechanism& mechanism, const std::vector<Goal>& goals, const Trajectory& trajectory,
               const dynamics::FreeSprings& loose, const VectorX& units)
      : mechanism_(mechanism),
        goals_(goals),
        trajectory_(trajectory),
        loose_(loose),
        units_(units),
        motion_(mechanism, trajectory) {
    motion_out_.trajectory = trajectory.name;
    for (std::size_t g = 0; g < goals.size(); ++g) {
      const study::OrderReference& order = goals[g].order;
      if (goals[g].kind != GoalKind::order || order.trajectory != trajectory.name) continue;
      highest_ = std::max(highest_, order.number);
      const auto known = std::find_if(quantities_.begin(), quantities_.end(),
                                      [&](const QuantityOrders& one) { return one.name == order.quantity; });
      if (known != quantities_.end()) {
        known->goals.push_back(g);
        continue;
      }
      QuantityOrders& of = quantities_.emplace_back();
      of.goals.push_back(g);
      of.name = order.quantity;
      of.quantity = dynamics::find_affine_quantity(mechanism, order.quantity).value();
      std::string mistake;
      if (const auto described = results::describe_quantity(mechanism, order.quantity, mistake))
        of.unit = described->unit;
    }
    list_known_term_mechanisms();
  }

  /// @return why there are no orders; empty: rows are appended
  std::string run(OrderRows& out) {
    for (long samples = min_order_samples;; samples *= 2) {
      if (std::string reason = sample(samples); !reason.empty()) return reason;
      if (static_cast<double>(samples) < samples_per_order * highest_ * motion_out_.turning.turns &&
          samples < max_order_samples)
        continue;
      measure_error();
      const bool is_smooth = motion_out_.spectral_error <= spectral_tolerance;
      if (is_smooth && motion_out_.known_term_error <= spectral_tolerance) break;
      if (samples < max_order_samples) continue;
      if (is_smooth && motion_out_.known_term_error <= known_term_tolerance) break;
      return fmt::format(
          "{} samples do not resolve the orders along '{}': twice as many change them by {:.2g} of the quantity's size",
          samples / 2, trajectory_.name, std::max(motion_out_.spectral_error, motion_out_.known_term_error));
    }
    for (const QuantityOrders& of : quantities_) append_rows(of, out);
    out.motions.push_back(motion_out_);
    return "";
  }

 private:
  Eigen::Index terms() const { return units_.size(); }
  Eigen::Index parameters() const { return terms() - static_cast<Eigen::Index>(known_terms_.size()); }

  void list_known_term_mechanisms() {
    known_terms_ = list_known_terms(mechanism_);
    const VectorX values = known_term_values(mechanism_);
    const bool is_needed = std::any_of(quantities_.begin(), quantities_.end(),
                                       [](const QuantityOrders& of) { return has_known_terms(of.quantity); });
    for (std::size_t k = 0; k < known_terms_.size() && is_needed; ++k) {
      const double value = values[static_cast<Eigen::Index>(k)];
      if (value == 0 && is_table_value(mechanism_, known_terms_[k])) continue;
      known_term_mechanisms_.emplace_back(k, keep_known_term(mechanism_, known_terms_[k], value));
    }
  }

  /// Follows the motion through evenly spaced moments. @return why it cannot be followed, or is not periodic
  std::string sample(long samples) {
    const bool needs_efforts = std::any_of(quantities_.begin(), quantities_.end(), [](const QuantityOrders& of) {
      return of.quantity.of_actuators() || of.quantity.of_joints();
    });
    const bool needs_velocities = std::any_of(quantities_.begin(), quantities_.end(), [](const QuantityOrders& of) {
      return of.quantity.kind == dynamics::AffineQuantity::Kind::kinetic_energy;
    });
    dynamics::TreeMotionSource<S> source(mechanism_, motion_, trajectory_.about,
                                         needs_velocities ? dynamics::Detail::all
                                         : needs_efforts  ? dynamics::Detail::forces
                                                          : dynamics::Detail::kinematics);
    const auto explain = [&] {
      return fmt::format("'{}' cannot be followed: {}", trajectory_.name, source.outcome().reason);
    };
    if (source.outcome().status != MotionStatus::done) return explain();
    dynamics::ForceRegressor<S> forces(mechanism_, source.tree(), motion_.plan.freedoms, trajectory_.about, loose_);
    std::deque<dynamics::ForceRegressor<S>> known_forces;
    for (const auto& [term, mechanism] : known_term_mechanisms_)
      known_forces.emplace_back(mechanism, source.tree(), motion_.plan.freedoms, trajectory_.about, loose_);
    const double duration = source.prescribed_motion().duration();
    const auto coordinates = static_cast<Eigen::Index>(mechanism_.coordinates.size());
    MatrixX angles(samples + 1, coordinates), rates(samples + 1, coordinates);
    std::vector<std::vector<MatrixX>> values(quantities_.size());
    for (long k = 0; k <= samples; ++k) {
      const double time = k == samples ? duration : duration * static_cast<double>(k) / static_cast<double>(samples);
      if (!(k == 0 ? source.begin() : source.advance(time)) || !source.evaluate()) return explain();
      angles.row(k) = source.sample().position.transpose();
      rates.row(k) = source.sample().velocity.transpose();
      for (std::size_t q = 0; q < quantities_.size(); ++q) {
        MatrixX rows;
        if (!evaluate(source, quantities_[q].quantity, forces, known_forces, rows)) {
          source.stop_at_actuation_singularity();
          return explain();
        }
        values[q].push_back(std::move(rows));
      }
    }
    const std::optional<CoordinateId> turning = find_turning(angles, rates);
    if (!turning)
      return fmt::format(
          "along '{}' no joint makes whole turns at constant speed, so that there are no orders: use a "
          "motion with 'speed' and 'turns', such as {{drive: joints, speed: {{A: 100}}}}",
          trajectory_.name);
    for (const QuantityOrders& of : quantities_)
      for (const std::size_t g : of.goals)
        if (!results::has_order(goals_[g].order.number, motion_out_.turning.turns))
          return fmt::format("'{}' with {} of {} has no order {}", trajectory_.name,
                             count_noun(motion_out_.turning.turns, "turn", "turns"), motion_out_.turning.coordinate,
                             results::format_order(goals_[g].order.number));
    for (std::size_t q = 0; q < quantities_.size(); ++q) {
      sum(values[q], angles.col(static_cast<Eigen::Index>(static_cast<std::size_t>(*turning))), quantities_[q]);
      if (!repeats(values[q], quantities_[q]))
        return fmt::format("the motion '{}' does not repeat after {} of {}: {} differs; more turns may make a period",
                           trajectory_.name, count_noun(motion_out_.turning.turns, "turn", "turns"),
                           motion_out_.turning.coordinate, quantities_[q].name);
    }
    motion_out_.samples = samples;
    return "";
  }

  /// @param rows per unit of all terms
  bool evaluate(dynamics::TreeMotionSource<S>& source, const dynamics::AffineQuantity& quantity,
                dynamics::ForceRegressor<S>& forces, std::deque<dynamics::ForceRegressor<S>>& known_forces,
                MatrixX& rows) const {
    MatrixX own;
    if (!forces.evaluate(source.stepper(), quantity, own)) return false;
    rows.setZero(own.rows(), terms());
    rows.leftCols(parameters()) = own.leftCols(parameters());
    if (!has_known_terms(quantity)) return true;
    for (std::size_t k = 0; k < known_forces.size(); ++k) {
      if (!known_forces[k].evaluate(source.stepper(), quantity, own)) return false;
      rows.col(parameters() + static_cast<Eigen::Index>(known_term_mechanisms_[k].first)) = own.rightCols(1);
    }
    return true;
  }

  /// The first actuated coordinate that turns uniformly by whole turns; else the first one of all.
  std::optional<CoordinateId> find_turning(const MatrixX& angles, const MatrixX& rates) {
    std::vector<CoordinateId> candidates = mechanism_.actuators;
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) candidates.emplace_back(static_cast<int>(c));
    for (const CoordinateId c : candidates) {
      if (is_length_coordinate(mechanism_, c)) continue;
      const auto column = static_cast<Eigen::Index>(static_cast<std::size_t>(c));
      const double speed = rates(0, column),
                   turns = (angles(angles.rows() - 1, column) - angles(0, column)) / (2 * std::numbers::pi);
      const double whole = std::round(std::abs(turns));
      if (whole < 1 || std::abs(std::abs(turns) - whole) > whole_turns_tolerance * (1 + whole)) continue;
      if (numerics::max_abs((rates.col(column).array() - speed).matrix()) > uniform_speed_tolerance * std::abs(speed))
        continue;
      motion_out_.turning = {mechanism_.coordinates[static_cast<std::size_t>(c)].name, speed, static_cast<int>(whole)};
      return c;
    }
    return std::nullopt;
  }

  void sum(const std::vector<MatrixX>& values, const VectorX& angle, QuantityOrders& of) const {
    const auto samples = static_cast<long>(values.size()) - 1;
    const MatrixX zero = MatrixX::Zero(values.front().rows(), terms());
    of.first = values.front();
    of.squares = zero;
    of.cosine.assign(of.goals.size(), zero);
    of.sine = of.even_cosine = of.even_sine = of.cosine;
    const double weight = 1 / static_cast<double>(samples);
    for (long k = 0; k < samples; ++k) of.squares += weight * values[static_cast<std::size_t>(k)].cwiseAbs2();
    for (std::size_t g = 0; g < of.goals.size(); ++g) {
      const results::Harmonic harmonic(angle, goals_[of.goals[g]].order.number);
      for (long k = 0; k < samples; ++k) {
        const MatrixX& rows = values[static_cast<std::size_t>(k)];
        of.cosine[g] += 2 * weight * harmonic.cosine[k] * rows;
        of.sine[g] += 2 * weight * harmonic.sine[k] * rows;
        if (k % 2 != 0) continue;
        of.even_cosine[g] += 4 * weight * harmonic.cosine[k] * rows;
        of.even_sine[g] += 4 * weight * harmonic.sine[k] * rows;
      }
    }
  }

  /// Root mean square of the largest coefficient, in natural units.
  double magnitude(const QuantityOrders& of) const {
    return numerics::max_abs(of.squares.cwiseSqrt() * units_.asDiagonal());
  }

  /// Loads over time need not repeat.
  bool repeats(const std::vector<MatrixX>& values, const QuantityOrders& of) const {
    const MatrixX difference = (values.back() - of.first) * units_.asDiagonal();
    return numerics::max_abs(difference) <= repetition_tolerance * magnitude(of);
  }

  void measure_error() {
    motion_out_.spectral_error = motion_out_.known_term_error = 0;
    for (const QuantityOrders& of : quantities_) {
      const double size = magnitude(of);
      if (size == 0) continue;
      const auto add = [&](const MatrixX& fine, const MatrixX& coarse) {
        const MatrixX change = (fine - coarse) * units_.asDiagonal() / size;
        motion_out_.spectral_error =
            std::max(motion_out_.spectral_error, numerics::max_abs(change.leftCols(parameters())));
        motion_out_.known_term_error =
            std::max(motion_out_.known_term_error, numerics::max_abs(change.rightCols(terms() - parameters())));
      };
      for (std::size_t g = 0; g < of.goals.size(); ++g) {
        add(of.cosine[g], of.even_cosine[g]);
        add(of.sine[g], of.even_sine[g]);
      }
    }
  }

  void append_rows(const QuantityOrders& of, OrderRows& out) const {
    const std::vector<std::string> names = dynamics::list_row_names(mechanism_, of.quantity, of.name);
    const double size = magnitude(of);
    for (std::size_t g = 0; g < of.goals.size(); ++g) {
      const MatrixX &a = of.cosine[g], &b = of.sine[g];
      const auto append = [&](const std::string& name, const VectorX& cosine, const VectorX& sine) {
        out.rows.push_back({of.goals[g], name, false, of.unit, cosine, size});
        out.rows.push_back({of.goals[g], name, true, of.unit, sine, size});
      };
      const results::OrderPart part = goals_[of.goals[g]].order.part;
      if (part == results::OrderPart::whole) {
        for (Eigen::Index r = 0; r < a.rows(); ++r)
          append(names[static_cast<std::size_t>(r)], a.row(r).transpose(), b.row(r).transpose());
        continue;
      }
      // x + i y = Σ (c + i s) exp(± i n θ)
      const double sign = part == results::OrderPart::forward ? 1 : -1;
      for (Eigen::Index r = 0; r + 1 < a.rows(); r += 2)
        append(of.name, (a.row(r) + sign * b.row(r + 1)).transpose() / 2,
               (a.row(r + 1) - sign * b.row(r)).transpose() / 2);
    }
  }

  const Mechanism& mechanism_;
  const std::vector<Goal>& goals_;
  const Trajectory& trajectory_;
  const dynamics::FreeSprings& loose_;
  const VectorX& units_;
  kinematics::CompiledMotion<S> motion_;
  double highest_ = 0;
  std::vector<QuantityOrders> quantities_;
  std::vector<dynamics::Parameter> known_terms_;
  std::vector<std::pair<std::size_t, Mechanism>> known_term_mechanisms_;  ///< index of the term
  OrderMotion motion_out_;
};

}  // namespace

OrderRows compute_order_rows(const Mechanism& mechanism, const std::vector<Goal>& goals,
                             const std::vector<Trajectory>& motions, const dynamics::FreeSprings& loose,
                             const VectorX& units) {
  OrderRows out;
  for (const Goal& goal : goals)
    if (const auto mistake = study::find_motion_mistake(goal, motions)) {
      out.mismatch = "the goal " + goal_name(goal) + ": " + mistake->sentence();
      return out;
    }
  try {
    for (const Trajectory& trajectory : study::select_goal_motions(goals, motions)) {
      kinematics::dispatch_space(mechanism.space, [&]<class S>(S) {
        out.mismatch = OrderSampler<S>(mechanism, goals, trajectory, loose, units).run(out);
      });
      if (!out.mismatch.empty()) return out;
    }
  } catch (const std::invalid_argument& error) {
    out.mismatch = error.what();
  }
  return out;
}

}  // namespace balance::conditions
