#include "balance/synthesis/design/objective_builder.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/dynamics/force_regressor.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/mechanics/results/run_quantities.hpp"
#include "balance/mechanics/trajectory/time_grid.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/geometry_features.hpp"
#include "balance/synthesis/design/order_cost.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/spec_figure_gradients.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"
#include "balance/synthesis/tolerance/robust_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace balance::design {

using dynamics::FreeSprings;
using study::DesignInstance;
using study::FigureLimit;

std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                             const VectorX& start, const FreeSprings& loose, MotionCache& cache) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back(
        {limit.text, build_objective(space, limit.terms, start, loose, cache), limit.is_lower, limit.bound});
  return built;
}

namespace {

/// A minimum, or a size, with the opposite sign: a maximum.
void negate_minimum(AffineFigure& figure) {
  figure.coefficients *= -1;
  for (AffineSeries& series : figure.series) series.rows *= -1;
  figure.figure = Statistic::maximum;
}

/// All samples cost nothing extra for an rms, whereas every sample of a peak is an inequality.
FigureSampling samples_for(const FigureLimit& limit) {
  const bool peak = std::any_of(limit.terms.begin(), limit.terms.end(),
                                [](const ObjectiveTerm& term) { return term.figure != Statistic::rms; });
  return peak ? FigureSampling::coarse : FigureSampling::full;
}

}  // namespace

std::vector<FigureLimit> select_convex_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits) {
  std::vector<FigureLimit> convex;
  std::copy_if(limits.begin(), limits.end(), std::back_inserter(convex), [&](const FigureLimit& limit) {
    return limit.is_lower ? are_concave_in_parameters(space, limit.terms)
                          : are_convex_in_parameters(space, limit.terms);
  });
  return convex;
}

std::optional<std::vector<ConvexLimit>> compute_convex_limits(const DesignSpace& space,
                                                              const std::vector<FigureLimit>& limits,
                                                              const FreeSprings& loose, const VectorX& x,
                                                              MotionCache& cache) {
  std::vector<ConvexLimit> all;
  for (const FigureLimit& limit : limits) {
    auto figures = compute_convex_terms(space, limit.terms, loose, samples_for(limit), x, cache);
    if (!figures) return std::nullopt;
    if (limit.is_lower)
      for (AffineFigure& figure : *figures) negate_minimum(figure);
    all.push_back({std::move(*figures), limit.is_lower ? -limit.bound : limit.bound});
  }
  return all;
}

namespace {

/// One term of the sum.
struct ObjectivePart {
  double weight = 1;
  CostFunction of_parameters;  ///< empty: requires a simulation
  ObjectiveTerm term;
  std::shared_ptr<const RunResult> run =
      {};  ///< nullptr: the free numbers may change the motion, or the figure depends on more than the motion
};

/// A point in general position: each number at a different fraction of its range.
VectorX generic_variables(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  double fraction = 0.41;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = numbers[i].lower + fraction * (numbers[i].upper - numbers[i].lower);
    fraction = std::fmod(fraction + 0.382, 0.8) + 0.1;
  }
  return x;
}

/// Whether the geometry and the motion along the trajectory are the same for both instances.
bool is_same_motion(const DesignInstance& a, const DesignInstance& b, const ObjectiveTerm& term,
                    const FreeSprings& loose) {
  const VectorX geometry_a = collect_geometry(a.mechanism, loose), geometry_b = collect_geometry(b.mechanism, loose);
  if (geometry_a.size() != geometry_b.size() || (geometry_a - geometry_b).norm() > 1e-12 * geometry_a.norm())
    return false;
  const Trajectory &trajectory_a = simulation::find_trajectory(a, term),
                   &trajectory_b = simulation::find_trajectory(b, term);
  if (!is_mass_dependent(trajectory_a) &&
      collect_motion_numbers(a.mechanism, trajectory_a) == collect_motion_numbers(b.mechanism, trajectory_b))
    return true;
  const RunResult first = simulate(a.mechanism, trajectory_a);
  const RunResult second = simulate(b.mechanism, trajectory_b);
  if (first.outcome.status != MotionStatus::done || second.outcome.status != MotionStatus::done) return false;
  const auto is_close = [](const Samples& p, const Samples& q) {
    return p.rows() == q.rows() && (p - q).norm() <= 1e-9 * (1 + p.norm());
  };
  return first.time.isApprox(second.time) && is_close(first.joint_position, second.joint_position) &&
         is_close(first.joint_velocity, second.joint_velocity);
}

/// Whether the motion is the same for all values of the free numbers.
bool is_motion_fixed(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term,
                     const FreeSprings& loose) {
  try {
    return is_same_motion(start, instantiate_checked(space, generic_variables(space.start.free_numbers)), term, loose);
  } catch (const SpecError&) {
    return false;  // an expression of the spec has no value at this point
  } catch (const std::invalid_argument&) {
    return false;  // there is no motion
  }
}

CostFunction make_linear_cost(VectorX coefficients) {
  return [coefficients = std::move(coefficients)](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) *gradient = coefficients;
    return coefficients.dot(parameters);
  };
}

/// Whether the point that a moment is about is the same for all values of the free numbers.
bool is_moment_point_fixed(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term) {
  const std::optional<dynamics::AffineQuantity> quantity =
      dynamics::find_affine_quantity(start.mechanism, term.quantity);
  if (!quantity || !quantity->about) return true;
  const VectorX elsewhere = generic_variables(space.start.free_numbers);
  return dynamics::find_affine_quantity(space.instantiate(elsewhere).mechanism, term.quantity)->about ==
         quantity->about;
}

/// The orders of a single scalar or vector that is affine in the parameters can be computed from its rows.
bool is_affine_order(const DesignInstance& instance, const ObjectiveTerm& term) {
  if (term.run != ObjectiveTerm::RunMeasure::order) return false;
  const std::optional<dynamics::AffineQuantity> quantity =
      dynamics::find_affine_quantity(instance.mechanism, term.quantity);
  const Trajectory& trajectory = simulation::find_trajectory(instance, term);
  return quantity && !quantity->is_combined && !is_mass_dependent(trajectory) && !is_mechanism_dependent(trajectory) &&
         !trajectory.free_motion && (quantity->member.has_value() || !quantity->of_joints()) &&
         (quantity->member.has_value() || !quantity->of_actuators() || instance.mechanism.actuators.size() == 1);
}

/// @return std::nullopt if there is no motion
std::optional<OrderMatrices> find_order_matrices(const DesignInstance& instance, const ObjectiveTerm& term,
                                                 const FreeSprings& loose, MotionCache& cache) {
  const Trajectory& trajectory = simulation::find_trajectory(instance, term);
  const std::shared_ptr<const MotionCache::Series> rows =
      cache.rows(instance.mechanism, trajectory, loose, term.quantity);
  if (!rows || rows->size() != 1) return std::nullopt;
  const results::UniformTurning turning = cache.turning(instance.mechanism, trajectory);
  return project_on_order(rows->front(), term.order, turning, trajectory.samples);
}

/// The order along a fixed motion; empty as below.
CostFunction make_fixed_motion_order(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term,
                                     const FreeSprings& loose, MotionCache& cache) {
  if (!is_affine_order(start, term) || !is_motion_fixed(space, start, term, loose) ||
      !is_moment_point_fixed(space, start, term))
    return {};
  const std::optional<OrderMatrices> matrices = find_order_matrices(start, term, loose, cache);
  return matrices ? make_order_cost(*matrices, term.part) : CostFunction{};
}

/// The figure along a fixed motion; empty if the motion is not fixed or the quantity is not linear in the parameters.
CostFunction make_fixed_motion_cost(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term,
                                    const FreeSprings& loose, MotionCache& cache) {
  const Trajectory& trajectory = simulation::find_trajectory(start, term);
  if (term.run == ObjectiveTerm::RunMeasure::order) return make_fixed_motion_order(space, start, term, loose, cache);
  if (term.deviation_multiple || term.run != ObjectiveTerm::RunMeasure::figure || is_mechanism_dependent(trajectory))
    return {};
  if (is_mass_dependent(trajectory) || !is_motion_fixed(space, start, term, loose)) return {};
  if (!is_moment_point_fixed(space, start, term)) return {};
  return cache.cost(start.mechanism, trajectory, loose, term.figure,
                    dynamics::name_cost_quantity(start.mechanism, term.figure, term.quantity));
}

}  // namespace

bool is_scalar_quantity(const Mechanism& mechanism, const std::string& quantity) {
  std::string mistake;
  const auto described = results::describe_quantity(mechanism, quantity, mistake);
  return described && described->is_scalar;
}

namespace {

/// Whether a figure of an affine quantity is convex. Absolute values and norms are, and so are maxima; the range is if
/// the quantity has a sign.
bool is_convex(const Mechanism& mechanism, const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none) return true;
  return term.figure == Statistic::range ? is_scalar_quantity(mechanism, term.quantity)
                                         : term.figure != Statistic::minimum;
}

/// Masses are linear, and the minimum of an affine quantity is concave.
bool is_concave(const Mechanism& mechanism, const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none) return true;
  return term.figure == Statistic::minimum && is_scalar_quantity(mechanism, term.quantity);
}

/// Magnitudes, distances and masses are not negative.
bool is_non_negative(const Mechanism& mechanism, const ObjectiveTerm& term) {
  if (term.weight < 0) return false;
  const bool is_signed = term.size == ObjectiveTerm::Size::none && term.run == ObjectiveTerm::RunMeasure::figure &&
                         (term.figure == Statistic::minimum || term.figure == Statistic::maximum);
  return !is_signed || !is_scalar_quantity(mechanism, term.quantity);
}

/// A weighted sum of figures: of the parameters if all figures are, else by simulation.
class FigureSum : public DesignFunction {
 public:
  FigureSum(const DesignSpace& space, std::vector<ObjectivePart> parts) : space_(space), parts_(std::move(parts)) {}

  /// The first trajectory of the terms that cannot be followed, and why.
  std::string failure_reason(const VectorX& x) const override {
    const DesignInstance instance = instantiate_checked(space_, x);
    if (!instance.mode_issue.empty()) return instance.mode_issue;
    for (const ObjectivePart& part : parts_) {
      if (part.term.size != ObjectiveTerm::Size::none) continue;
      const RunResult result = simulate(instance.mechanism, simulation::find_trajectory(instance, part.term));
      if (result.outcome.status != MotionStatus::done)
        return fmt::format("'{}' cannot be followed: {}", part.term.trajectory, result.outcome.reason);
    }
    return "";
  }

 protected:
  const DesignSpace space_;
  const std::vector<ObjectivePart> parts_;
};

class ParametricSum final : public FigureSum {
 public:
  using FigureSum::FigureSum;

  Domain domain() const override { return Domain::parameters; }
  double evaluate(const VectorX& parameters, VectorX* gradient) const override {
    double sum = 0;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    VectorX part_gradient;
    for (const ObjectivePart& part : parts_) {
      sum += part.weight * part.of_parameters(parameters, gradient != nullptr ? &part_gradient : nullptr);
      if (gradient != nullptr) *gradient += part.weight * part_gradient;
    }
    return sum;
  }
};

class SimulatedSum final : public FigureSum {
 public:
  SimulatedSum(const DesignSpace& space, std::vector<ObjectivePart> parts, const FreeSprings& loose)
      : FigureSum(space, std::move(parts)), loose_(loose) {
    for (const ObjectivePart& part : parts_) terms_.push_back(part.term);
  }

  Domain domain() const override { return Domain::variables; }
  /// Caches the last few values, because searches evaluate the same points repeatedly.
  double evaluate(const VectorX& x, VectorX* /*gradient*/) const override {
    constexpr std::size_t max_cached_values = 16;
    for (const auto& [at, value] : cache_)
      if (at == x) return value;
    const double value = simulate_sum(x);
    cache_.emplace_front(x, value);
    if (cache_.size() > max_cached_values) cache_.pop_back();
    return value;
  }
  /// Deviations are computed from differences; their gradients would require second derivatives.
  bool has_max_terms() const override {
    return std::none_of(terms_.begin(), terms_.end(),
                        [](const ObjectiveTerm& term) { return term.deviation_multiple.has_value(); });
  }
  std::optional<std::vector<MaxTerm>> max_terms(const VectorX& x) const override {
    return compute_max_terms(space_, terms_, loose_, x);
  }

 private:
  double simulate_sum(const VectorX& x) const {
    const DesignInstance instance = instantiate_checked(space_, x);
    if (!instance.mode_issue.empty()) return std::numeric_limits<double>::quiet_NaN();
    const VectorX parameters = dynamics::parameter_values(instance.mechanism, loose_);
    double sum = 0;
    for (const ObjectivePart& part : parts_)
      sum +=
          part.weight * (part.of_parameters             ? part.of_parameters(parameters, nullptr)
                         : part.term.deviation_multiple ? tolerance::compute_robust_figure(space_, x, part.term).value
                         : part.run ? simulation::compute_run_figure(instance.mechanism, *part.run, part.term)
                                    : simulation::simulate_figure(instance, part.term));
    return sum;
  }

  FreeSprings loose_;
  std::vector<ObjectiveTerm> terms_;
  mutable std::deque<std::pair<VectorX, double>> cache_;
};

/// Checks that the mechanism has the quantity of the term, if this can be decided.
void require_quantity(const DesignInstance& instance, const ObjectiveTerm& term) {
  try {
    simulation::simulate_figure(instance, term);
  } catch (const SpecError&) {
    // There is no motion at this point, but there may be one at others.
  }
}

/// Checks that the run has deviations, and not too many.
void require_deviations(const DesignSpace& space, const VectorX& start, const ObjectiveTerm& term) {
  try {
    tolerance::compute_robust_figure(space, start, term);
  } catch (const SpecError&) {
    // As above.
  }
}

/// The run, if the figure depends only on positions and singularities and the free numbers do not change the motion.
std::shared_ptr<const RunResult> find_fixed_run(const DesignSpace& space, const DesignInstance& start,
                                                const ObjectiveTerm& term, const FreeSprings& loose) {
  std::string mistake;
  const auto described = results::describe_quantity(start.mechanism, term.quantity, mistake);
  const bool of_motion =
      term.run == ObjectiveTerm::RunMeasure::figure
          ? described && described->is_kinematic && !term.deviation_multiple &&
                !is_mechanism_dependent(simulation::find_trajectory(start, term))
          : term.run == ObjectiveTerm::RunMeasure::mobility || term.run == ObjectiveTerm::RunMeasure::clearance;
  if (!of_motion || is_mass_dependent(simulation::find_trajectory(start, term)) ||
      !is_motion_fixed(space, start, term, loose))
    return {};
  return std::make_shared<const RunResult>(simulate(start.mechanism, simulation::find_trajectory(start, term)));
}

/// The figure of such a run if the positions that it refers to do not change either.
std::optional<double> constant_value(const DesignSpace& space, const DesignInstance& start, const ObjectivePart& part) {
  std::optional<double> constant;
  if (is_size_of_parts(part.term.size)) return sum_of_parts(part.term.size, space.start.catalogue_choices);
  if (!part.run) return constant;
  const auto value = [&](const DesignInstance& instance) {
    return simulation::compute_run_figure(instance.mechanism, *part.run, part.term);
  };
  const double start_value = value(start),
               generic_value = value(space.instantiate(generic_variables(space.start.free_numbers)));
  if (start_value == generic_value) constant = start_value;
  return constant;
}

CostFunction make_constant_cost(double value) {
  return [value](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) gradient->setZero(parameters.size());
    return value;
  };
}

/// The fewest samples whose times, at least min_time_steps, are among those of all samples. A peak over them then is at
/// most the peak, so that what it proves holds.
long coarse_sample_count(long samples) {
  for (long steps = trajectory::min_time_steps; steps < samples - 1; ++steps)
    if ((samples - 1) % steps == 0) return steps + 1;
  return samples;
}

bool has_all_samples(const Study& study, const ObjectiveTerm& term, FigureSampling sampling) {
  if (term.size != ObjectiveTerm::Size::none || sampling == FigureSampling::full) return true;
  const Trajectory* trajectory = study::find_by_name(study.trajectories, term.trajectory);
  return trajectory != nullptr && coarse_sample_count(trajectory->samples) == trajectory->samples;
}

/// One term that is no order; std::nullopt if the trajectory cannot be followed.
std::optional<AffineFigure> make_convex_term(const DesignInstance& instance, const ObjectiveTerm& term,
                                             const FreeSprings& loose, FigureSampling samples, MotionCache& cache) {
  AffineFigure figure{term.weight, {}, term.figure, {}};
  if (term.size != ObjectiveTerm::Size::none) {
    figure.coefficients = size_coefficients(term.size, instance.mechanism, loose);
    return figure;
  }
  Trajectory trajectory = simulation::find_trajectory(instance, term);
  if (samples == FigureSampling::coarse) trajectory.samples = coarse_sample_count(trajectory.samples);
  const std::shared_ptr<const MotionCache::Series> rows =
      cache.rows(instance.mechanism, trajectory, loose,
                 dynamics::name_cost_quantity(instance.mechanism, term.figure, term.quantity));
  if (!rows) return std::nullopt;
  figure.series = *rows;
  const bool is_vector = !figure.series.empty() && figure.series.front().components > 1;
  if (figure.figure == Statistic::maximum && is_vector) figure.figure = Statistic::peak;
  return figure;
}

/// Whether the term is one of these figures of a quantity that is affine in the parameters for any motion, or a size.
bool has_affine_quantity(const DesignInstance& instance, const ObjectiveTerm& term,
                         std::initializer_list<Statistic> figures) {
  if (term.size != ObjectiveTerm::Size::none) return term.weight >= 0 && !is_size_of_parts(term.size);
  if (term.deviation_multiple) return false;
  if (term.run == ObjectiveTerm::RunMeasure::order)
    return term.weight >= 0 && std::find(figures.begin(), figures.end(), Statistic::rms) != figures.end() &&
           is_affine_order(instance, term);
  return term.run == ObjectiveTerm::RunMeasure::figure && term.weight >= 0 &&
         std::find(figures.begin(), figures.end(), term.figure) != figures.end() &&
         is_linear_quantity(instance.mechanism,
                            dynamics::name_cost_quantity(instance.mechanism, term.figure, term.quantity)) &&
         !is_mass_dependent(simulation::find_trajectory(instance, term)) &&
         !is_mechanism_dependent(simulation::find_trajectory(instance, term));
}

}  // namespace

bool are_convex_in_parameters(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms) {
  const DesignInstance start = space.instantiate(space.start_values());
  return std::all_of(terms.begin(), terms.end(), [&](const ObjectiveTerm& term) {
    return has_affine_quantity(start, term, {Statistic::rms, Statistic::peak, Statistic::maximum, Statistic::range}) &&
           is_convex(start.mechanism, term);
  });
}

bool are_statistics_of_affine_quantities(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms) {
  using enum Statistic;
  const DesignInstance start = space.instantiate(space.start_values());
  return std::all_of(terms.begin(), terms.end(), [&](const ObjectiveTerm& term) {
    return has_affine_quantity(start, term, {peak, rms, mean, range, minimum, maximum}) &&
           (term.figure != range || is_convex(start.mechanism, term));  // a range is two maxima of scalars
  });
}

bool are_concave_in_parameters(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms) {
  const DesignInstance start = space.instantiate(space.start_values());
  return std::all_of(terms.begin(), terms.end(), [&](const ObjectiveTerm& term) {
    return has_affine_quantity(start, term, {Statistic::minimum}) && is_concave(start.mechanism, term);
  });
}

bool are_samples_complete(const Study& study, const std::vector<ObjectiveTerm>& terms,
                          const std::vector<FigureLimit>& limits) {
  const auto are_complete = [&](const std::vector<ObjectiveTerm>& sum, FigureSampling sampling) {
    return std::all_of(sum.begin(), sum.end(),
                       [&](const ObjectiveTerm& term) { return has_all_samples(study, term, sampling); });
  };
  return are_complete(terms, FigureSampling::coarse) &&
         std::all_of(limits.begin(), limits.end(),
                     [&](const FigureLimit& limit) { return are_complete(limit.terms, samples_for(limit)); });
}

std::optional<std::vector<AffineFigure>> compute_convex_terms(const DesignSpace& space,
                                                              const std::vector<ObjectiveTerm>& terms,
                                                              const FreeSprings& loose, FigureSampling sampling,
                                                              const VectorX& x, MotionCache& cache) {
  std::vector<AffineFigure> figures;
  try {
    const DesignInstance instance = instantiate_checked(space, x);
    if (!instance.mode_issue.empty()) return std::nullopt;
    for (const ObjectiveTerm& term : terms) {
      if (term.size == ObjectiveTerm::Size::none && term.run == ObjectiveTerm::RunMeasure::order) {
        const std::optional<OrderMatrices> matrices = find_order_matrices(instance, term, loose, cache);
        if (!matrices) return std::nullopt;
        for (AffineFigure& figure : make_order_figures(*matrices, term.part, term.weight))
          figures.push_back(std::move(figure));
        continue;
      }
      std::optional<AffineFigure> figure = make_convex_term(instance, term, loose, sampling, cache);
      if (!figure) return std::nullopt;
      if (figure->figure == Statistic::range) {
        figure->figure = Statistic::maximum;
        figures.push_back(*figure);
        negate_minimum(*figure);
      }
      figures.push_back(std::move(*figure));
    }
  } catch (const SpecError&) {
    return std::nullopt;  // an expression of the spec has no value here
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // there is no motion
  }
  return figures;
}

Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const FreeSprings& loose) {
  MotionCache cache;
  return build_objective(space, terms, start, loose, cache);
}

Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const FreeSprings& loose, MotionCache& cache) {
  const DesignInstance start_instance = space.instantiate(start);
  std::vector<ObjectivePart> parts;
  Objective objective;
  objective.is_convex = objective.is_concave = objective.is_secondary = true;
  if (std::all_of(terms.begin(), terms.end(),
                  [&](const ObjectiveTerm& term) { return is_non_negative(start_instance.mechanism, term); }))
    objective.lower_bound = 0;
  for (const ObjectiveTerm& term : terms) {
    const bool is_size = term.size != ObjectiveTerm::Size::none;
    ObjectivePart part{term.weight,
                       is_size ? make_linear_cost(size_coefficients(term.size, start_instance.mechanism, loose))
                               : make_fixed_motion_cost(space, start_instance, term, loose, cache),
                       term};
    if (!part.of_parameters) require_quantity(start_instance, term);  // reports missing quantities immediately
    if (term.deviation_multiple) require_deviations(space, start, term);
    if (!is_size) part.run = find_fixed_run(space, start_instance, term, loose);
    const std::optional<double> constant = constant_value(space, start_instance, part);
    if (constant) part.of_parameters = make_constant_cost(*constant);
    objective.is_constant = constant && terms.size() == 1;
    objective.is_convex =
        objective.is_convex && part.of_parameters && (constant || is_convex(start_instance.mechanism, term));
    objective.is_concave =
        objective.is_concave && part.of_parameters && (constant || is_concave(start_instance.mechanism, term));
    objective.is_secondary = objective.is_secondary && is_size;
    objective.name += (parts.empty() ? "" : " + ") + (term.weight == 1 ? "" : fmt::format("{:g} ", term.weight)) +
                      objective_term_name(term);
    parts.push_back(std::move(part));
  }
  const bool is_parametric =
      std::all_of(parts.begin(), parts.end(), [](const ObjectivePart& p) { return bool(p.of_parameters); });
  if (terms.size() == 1 && terms[0].size != ObjectiveTerm::Size::none)
    objective.unit = simulation::unit_of_term(start_instance.mechanism, terms[0]);
  if (is_parametric)
    objective.function = std::make_shared<const ParametricSum>(space, std::move(parts));
  else
    objective.function = std::make_shared<const SimulatedSum>(space, std::move(parts), loose);
  return objective;
}

VectorX added_parameter_mask(const Mechanism& mechanism, const std::vector<dynamics::Parameter>& parameters) {
  VectorX added(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto index = static_cast<std::size_t>(parameters[p].index);
    const bool counterweight = parameters[p].owner_kind == dynamics::ParameterOwner::attachment &&
                               mechanism.attachments[index].kind == AttachmentKind::counterweight;
    added[static_cast<Eigen::Index>(p)] =
        counterweight || parameters[p].owner_kind == dynamics::ParameterOwner::disc ? 1 : 0;
  }
  return added;
}

VectorX mass_coefficients(const std::vector<dynamics::Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind == dynamics::ParameterKind::mass ? 1 : 0;
  return coefficients;
}

VectorX inertia_coefficients(const std::vector<dynamics::Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind != dynamics::ParameterKind::moment_of_inertia ? 0
                                                 : parameters[p].symbol == "J"                                    ? 1
                                                                                                                  : 0.5;
  return coefficients;
}

VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const FreeSprings& loose) {
  const auto parameters = dynamics::list_parameters(mechanism, loose);
  if (is_size_of_parts(size)) return VectorX::Zero(static_cast<Eigen::Index>(parameters.size()));
  VectorX coefficients =
      size == ObjectiveTerm::Size::added_inertia ? inertia_coefficients(parameters) : mass_coefficients(parameters);
  if (size != ObjectiveTerm::Size::total_mass)
    coefficients.array() *= added_parameter_mask(mechanism, parameters).array();
  return coefficients;
}

// Names of objective terms.
std::string objective_term_name(Statistic figure) {
  switch (figure) {
    case Statistic::peak: return "peak";
    case Statistic::rms: return "rms";
    case Statistic::mean: return "mean";
    case Statistic::range: return "range";
    case Statistic::minimum: return "minimum";
    case Statistic::maximum: return "maximum";
  }
  return "";
}

std::string objective_term_name(const ObjectiveTerm& term) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_mass: return "added mass";
    case ObjectiveTerm::Size::added_inertia: return "added inertia";
    case ObjectiveTerm::Size::total_mass: return "total mass";
    case ObjectiveTerm::Size::part_mass: return "mass of parts";
    case ObjectiveTerm::Size::price: return "price";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::energy: return "energy along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::mobility: return "mobility along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::clearance: return "clearance along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::duration: return "duration of " + term.trajectory;
    case ObjectiveTerm::RunMeasure::fluctuation: return "fluctuation of the speed along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::quality: return "balance quality of " + term.quantity + " along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::order:
      return fmt::format("{} {} of {} along {}", results::name_of(term.part), results::format_order(term.order),
                         term.quantity, term.trajectory);
    case ObjectiveTerm::RunMeasure::figure: break;
  }
  const std::string figure = objective_term_name(term.figure) + "(" + term.quantity + ") along " + term.trajectory;
  return term.deviation_multiple ? fmt::format("mean plus {:g} deviation{} of {}", *term.deviation_multiple,
                                               *term.deviation_multiple == 1 ? "" : "s", figure)
                                 : figure;
}

namespace {

/// Derivatives of the parameters by the free numbers, one column each. Parameters are smooth and cheap functions.
MatrixX parameter_jacobian(const DesignSpace& space, const VectorX& x, const FreeSprings& loose) {
  constexpr double step = 1e-5;  // fraction of the range
  const auto at = [&](const VectorX& there) {
    return dynamics::parameter_values(space.instantiate(there).mechanism, loose);
  };
  MatrixX slopes(at(x).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double step_size = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + step_size, free.upper), down[i] = std::max(x[i] - step_size, free.lower);
    if (up[i] == down[i])
      slopes.col(i).setZero();
    else
      slopes.col(i) = (at(up) - at(down)) / (up[i] - down[i]);
  }
  return slopes;
}

ValueWithGradient size_with_gradient(const DesignSpace& space, const Mechanism& mechanism, const ObjectiveTerm& term,
                                     const FreeSprings& loose, const VectorX& x) {
  const VectorX coefficients = size_coefficients(term.size, mechanism, loose);
  return {coefficients.dot(dynamics::parameter_values(mechanism, loose)),
          parameter_jacobian(space, x, loose).transpose() * coefficients};
}

MaxTerm make_single_term(double weight, const ValueWithGradient& slope) {
  return {weight, VectorX::Constant(1, slope.value), slope.gradient.transpose()};
}

/// The maximum of the values in `up` and of the negated values in `down`.
MaxTerm make_max_term(double weight, const std::vector<ValueWithGradient>& up,
                      const std::vector<ValueWithGradient>& down, Eigen::Index numbers) {
  const auto above = static_cast<Eigen::Index>(up.size()), below = static_cast<Eigen::Index>(down.size());
  MaxTerm term{weight, VectorX(above + below), MatrixX(above + below, numbers)};
  for (Eigen::Index k = 0; k < above + below; ++k) {
    const double sign = k < above ? 1 : -1;
    const ValueWithGradient& slope =
        k < above ? up[static_cast<std::size_t>(k)] : down[static_cast<std::size_t>(k - above)];
    term.values[k] = sign * slope.value;
    term.jacobian.row(k) = sign * slope.gradient.transpose();
  }
  return term;
}

void add_figure(const ObjectiveTerm& term, const SpecFigureGradients& slopes, Eigen::Index numbers,
                std::vector<MaxTerm>& pieces) {
  const double weight = term.weight;
  if (term.run == ObjectiveTerm::RunMeasure::duration)
    return pieces.push_back(make_single_term(weight, slopes.duration));
  if (term.run == ObjectiveTerm::RunMeasure::energy) return pieces.push_back(make_single_term(weight, slopes.energy));
  const QuantityGradients* quantity = find_quantity(slopes, term.quantity);
  if (quantity == nullptr)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  switch (term.figure) {
    case Statistic::rms: return pieces.push_back(make_single_term(weight, quantity->rms));
    case Statistic::mean: return pieces.push_back(make_single_term(weight, quantity->mean));
    case Statistic::peak:
      return pieces.push_back(make_max_term(weight, quantity->segment_maxima, quantity->segment_minima, numbers));
    case Statistic::range:
      pieces.push_back(make_max_term(weight, quantity->segment_maxima, {}, numbers));
      return pieces.push_back(make_max_term(weight, {}, quantity->segment_minima, numbers));
    case Statistic::maximum: return pieces.push_back(make_max_term(weight, quantity->segment_maxima, {}, numbers));
    case Statistic::minimum: {
      const auto& minima = quantity->segment_minima;
      const auto smallest = std::min_element(minima.begin(), minima.end(),
                                             [](const auto& a, const auto& b) { return a.value < b.value; });
      return pieces.push_back(make_single_term(weight, *smallest));
    }
  }
}

/// Whether derivatives take differences: of the path or the law of a motion that is optimised for every mechanism, and
/// of figures that are not in the arrays of a run.
bool needs_differences(const DesignSpace& space, const ObjectiveTerm& term) {
  using Run = ObjectiveTerm::RunMeasure;
  if (term.run == Run::mobility || term.run == Run::clearance || term.run == Run::order ||
      term.run == Run::fluctuation || term.run == Run::quality || has_velocity_constraints(space.start.mechanism))
    return true;
  if (term.run == Run::figure && !results::has_gradients(space.start.mechanism, term.quantity)) return true;
  const Trajectory* trajectory = study::find_by_name(space.start.trajectories, term.trajectory);
  return trajectory != nullptr && is_mechanism_dependent(*trajectory);
}

/// A motion or law that is optimised for every mechanism makes the figure accurate to about 1e-7. Steps of 1e-3 of a
/// number's range then leave an error of about 1e-4 in the derivative by that range.
ValueWithGradient gradient_by_differences(const DesignSpace& space, const ObjectiveTerm& term, const VectorX& x) {
  constexpr double step = 1e-3;
  ValueWithGradient slope{simulation::simulate_figure(instantiate_checked(space, x), term), VectorX(x.size())};
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double step_size = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + step_size, free.upper), down[i] = std::max(x[i] - step_size, free.lower);
    const double high = simulation::simulate_figure(instantiate_checked(space, up), term);
    const double low = simulation::simulate_figure(instantiate_checked(space, down), term);
    // one-sided if the other side has no value
    slope.gradient[i] = std::isfinite(high - low) ? (high - low) / (up[i] - down[i])
                        : std::isfinite(high)     ? (high - slope.value) / (up[i] - x[i])
                                                  : (slope.value - low) / (x[i] - down[i]);
  }
  return slope;
}

}  // namespace

std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const FreeSprings& loose, const VectorX& x) {
  const DesignInstance instance = instantiate_checked(space, x);
  if (!instance.mode_issue.empty()) return std::nullopt;
  std::map<std::string, std::vector<std::string>> quantities;
  for (const ObjectiveTerm& term : terms) {
    if (term.size != ObjectiveTerm::Size::none || needs_differences(space, term)) continue;
    std::vector<std::string>& names = quantities[term.trajectory];
    if (term.run == ObjectiveTerm::RunMeasure::figure) names.push_back(term.quantity);
    if (term.run == ObjectiveTerm::RunMeasure::energy) names.emplace_back("power");
  }
  std::map<std::string, SpecFigureGradients> runs;
  for (auto& [trajectory, names] : quantities) {
    if (names.empty()) names.emplace_back("torque");
    const SpecFigureGradients& run = runs[trajectory] = compute_figure_gradients(space, x, trajectory, names);
    if (run.outcome.status != MotionStatus::done) return std::nullopt;
  }
  std::vector<MaxTerm> pieces;
  for (const ObjectiveTerm& term : terms)
    if (term.size != ObjectiveTerm::Size::none)
      pieces.push_back(make_single_term(term.weight, size_with_gradient(space, instance.mechanism, term, loose, x)));
    else if (needs_differences(space, term))
      pieces.push_back(make_single_term(term.weight, gradient_by_differences(space, term, x)));
    else
      add_figure(term, runs[term.trajectory], x.size(), pieces);
  return pieces;
}

}  // namespace balance::design
