#include "balance/synthesis/design/objective_builder.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "balance/motion/simulation/run_figure.hpp"
#include "balance/motion/simulation/simulate.hpp"
#include "balance/synthesis/design/geometry_features.hpp"
#include "balance/synthesis/design/required_motions.hpp"
#include "balance/synthesis/design/spec_figure_gradients.hpp"
#include "balance/synthesis/design/trajectory_cost.hpp"
#include "balance/synthesis/tolerance/robust_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace balance {

std::vector<DesignLimit> build_design_limits(const DesignSpace& space, const std::vector<FigureLimit>& limits,
                                             const VectorX& start, const FreeSprings& loose) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back({limit.text, build_objective(space, limit.terms, start, loose), limit.is_lower, limit.bound});
  return built;
}

namespace {

/// A root of a mean square is as cheap from all samples; of a peak each is an inequality.
FigureSampling samples_for(const FigureLimit& limit) {
  const bool peak = std::any_of(limit.terms.begin(), limit.terms.end(),
                                [](const ObjectiveTerm& term) { return term.figure == Statistic::peak; });
  return peak ? FigureSampling::coarse : FigureSampling::full;
}

}  // namespace

std::function<std::optional<std::vector<ConvexLimit>>(const VectorX& x)> build_convex_limits(
    const DesignSpace& space, const std::vector<FigureLimit>& limits, const FreeSprings& loose, int& known) {
  using Figures = std::function<std::optional<std::vector<AffineFigure>>(const VectorX&)>;
  std::vector<std::pair<Figures, double>> built;
  for (const FigureLimit& limit : limits)
    if (!limit.is_lower)
      if (Figures figures = build_convex_terms(space, limit.terms, loose, samples_for(limit)))
        built.emplace_back(std::move(figures), limit.bound);
  known = static_cast<int>(built.size());
  if (built.empty()) return {};
  return [built](const VectorX& x) -> std::optional<std::vector<ConvexLimit>> {
    std::vector<ConvexLimit> all;
    for (const auto& [figures_at, bound] : built) {
      auto figures = figures_at(x);
      if (!figures) return std::nullopt;
      all.push_back({std::move(*figures), bound});
    }
    return all;
  };
}

namespace {

/// One term of the sum.
struct ObjectivePart {
  double weight = 1;
  CostFunction of_parameters;  ///< empty: by simulation
  ObjectiveTerm term;
  std::shared_ptr<const RunResult> run =
      {};  ///< null: the free numbers may change the motion, or more than the motion counts
};

/// A point in general position: no two numbers at the same part of their bounds.
VectorX generic_variables(const std::vector<FreeNumber>& numbers) {
  VectorX x(static_cast<Eigen::Index>(numbers.size()));
  double part = 0.41;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    x[static_cast<Eigen::Index>(i)] = numbers[i].lower + part * (numbers[i].upper - numbers[i].lower);
    part = std::fmod(part + 0.382, 0.8) + 0.1;
  }
  return x;
}

/// The free numbers change neither the places of joints, discs and springs nor the motion along the trajectory.
bool is_same_motion(const DesignInstance& a, const DesignInstance& b, const ObjectiveTerm& term,
                    const FreeSprings& loose) {
  const VectorX one = design::collect_geometry(a.mechanism, loose),
                other = design::collect_geometry(b.mechanism, loose);
  if (one.size() != other.size() || (one - other).norm() > 1e-12 * one.norm()) return false;
  const RunResult first = simulate(a.mechanism, find_trajectory(a, term));
  const RunResult second = simulate(b.mechanism, find_trajectory(b, term));
  if (first.outcome.status != MotionStatus::done || second.outcome.status != MotionStatus::done) return false;
  const auto alike = [](const Samples& p, const Samples& q) {
    return p.rows() == q.rows() && (p - q).norm() <= 1e-9 * (1 + p.norm());
  };
  return first.time.isApprox(second.time) && alike(first.joint_position, second.joint_position) &&
         alike(first.joint_velocity, second.joint_velocity);
}

/// Whatever the free numbers are.
bool is_motion_fixed(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term,
                     const FreeSprings& loose) {
  try {
    return is_same_motion(start, instantiate_checked(space, generic_variables(space.start.free_numbers)), term, loose);
  } catch (const SpecError&) {
    return false;  // with these numbers an expression of the spec has no value
  } catch (const std::invalid_argument&) {
    return false;  // or there is no motion
  }
}

CostFunction make_linear_cost(VectorX coefficients) {
  return [coefficients = std::move(coefficients)](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) *gradient = coefficients;
    return coefficients.dot(parameters);
  };
}

/// Along a motion that stays the same; empty if it does not, or if the quantity is not linear in the parameters.
CostFunction make_fixed_motion_cost(const DesignSpace& space, const DesignInstance& start, const ObjectiveTerm& term,
                                    const FreeSprings& loose) {
  const Trajectory& trajectory = find_trajectory(start, term);
  if (term.deviation_multiple || term.run != ObjectiveTerm::RunMeasure::figure || is_mechanism_dependent(trajectory))
    return {};
  if (is_mass_dependent(trajectory) || !is_motion_fixed(space, start, term, loose)) return {};
  const TrajectoryCost cost(start.mechanism, trajectory, loose);
  return cost.figure(term.figure, term.quantity).value_or(CostFunction{});
}

/// Absolute values and norms of affine functions are convex; how far values lie apart is, too; a minimum is not.
bool is_convex(const ObjectiveTerm& term) {
  return term.size != ObjectiveTerm::Size::none || term.figure != Statistic::range ||
         effort_array_name(term.quantity).starts_with("torque");
}

std::function<double(const VectorX&, VectorX*)> sum_of_parameters(std::vector<ObjectivePart> parts) {
  return [parts = std::move(parts)](const VectorX& parameters, VectorX* gradient) {
    double sum = 0;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    VectorX own;
    for (const ObjectivePart& part : parts) {
      sum += part.weight * part.of_parameters(parameters, gradient != nullptr ? &own : nullptr);
      if (gradient != nullptr) *gradient += part.weight * own;
    }
    return sum;
  };
}

/// A search asks for a simulated figure at the same numbers again and again: the last few values are kept.
std::function<double(const VectorX&)> memoize(std::function<double(const VectorX&)> figure) {
  constexpr std::size_t max_cached_values = 16;
  using Cache = std::deque<std::pair<VectorX, double>>;
  return [figure = std::move(figure), known = std::make_shared<Cache>()](const VectorX& x) {
    for (const auto& [at, value] : *known)
      if (at == x) return value;
    const double value = figure(x);
    known->emplace_front(x, value);
    if (known->size() > max_cached_values) known->pop_back();
    return value;
  };
}

std::function<double(const VectorX&)> sum_of_variables(const DesignSpace& space, std::vector<ObjectivePart> parts,
                                                       const FreeSprings& loose) {
  return memoize([space, parts = std::move(parts), loose](const VectorX& x) {
    const DesignInstance trial = instantiate_checked(space, x);
    const VectorX parameters = parameter_values(trial.mechanism, loose);
    double sum = 0;
    for (const ObjectivePart& part : parts)
      sum += part.weight * (part.of_parameters             ? part.of_parameters(parameters, nullptr)
                            : part.term.deviation_multiple ? compute_robust_figure(space, x, part.term).value
                            : part.run                     ? compute_run_figure(trial.mechanism, *part.run, part.term)
                                                           : simulate_figure(trial, part.term));
    return sum;
  });
}

/// The first trajectory of the terms that cannot be followed, and why.
std::function<std::string(const VectorX&)> make_failure_reason(const DesignSpace& space,
                                                               std::vector<ObjectiveTerm> terms) {
  return [space, terms = std::move(terms)](const VectorX& x) -> std::string {
    const DesignInstance trial = instantiate_checked(space, x);
    for (const ObjectiveTerm& term : terms) {
      if (term.size != ObjectiveTerm::Size::none) continue;
      const RunResult result = simulate(trial.mechanism, find_trajectory(trial, term));
      if (result.outcome.status != MotionStatus::done)
        return fmt::format("'{}' cannot be followed: {}", term.trajectory, result.outcome.reason);
    }
    return "";
  };
}

/// Whether the mechanism has the term's quantity at all, where it can be told.
void require_quantity(const DesignInstance& trial, const ObjectiveTerm& term) {
  try {
    simulate_figure(trial, term);
  } catch (const SpecError&) {
    // there is no motion with these numbers; with others there may be
  }
}

/// Whether the run has deviations, and few enough of them.
void require_deviations(const DesignSpace& space, const VectorX& start, const ObjectiveTerm& term) {
  try {
    compute_robust_figure(space, start, term);
  } catch (const SpecError&) {
    // as above
  }
}

/// Where places and singularities are all that counts, and the free numbers do not change the motion: the run.
std::shared_ptr<const RunResult> find_fixed_run(const DesignSpace& space, const DesignInstance& start,
                                                const ObjectiveTerm& term, const FreeSprings& loose) {
  const bool of_motion =
      term.run == ObjectiveTerm::RunMeasure::mobility || term.run == ObjectiveTerm::RunMeasure::clearance;
  if (!of_motion || is_mass_dependent(find_trajectory(start, term)) || !is_motion_fixed(space, start, term, loose))
    return {};
  return std::make_shared<const RunResult>(simulate(start.mechanism, find_trajectory(start, term)));
}

/// The figure of such a run where the places that it is of do not change either.
std::optional<double> constant_value(const DesignSpace& space, const DesignInstance& start, const ObjectivePart& part) {
  std::optional<double> constant;
  if (!part.run) return constant;
  const auto value = [&](const DesignInstance& trial) {
    return compute_run_figure(trial.mechanism, *part.run, part.term);
  };
  const double here = value(start), elsewhere = value(space.instantiate(generic_variables(space.start.free_numbers)));
  if (here == elsewhere) constant = here;
  return constant;
}

CostFunction make_constant_cost(double value) {
  return [value](const VectorX& parameters, VectorX* gradient) {
    if (gradient != nullptr) gradient->setZero(parameters.size());
    return value;
  };
}

constexpr long max_coarse_samples = 201;

/// One term; nothing where the trajectory cannot be followed.
std::optional<AffineFigure> make_convex_term(const DesignInstance& trial, const ObjectiveTerm& term,
                                             const FreeSprings& loose, FigureSampling samples) {
  AffineFigure figure{term.weight, {}, term.figure, {}};
  if (term.size != ObjectiveTerm::Size::none) {
    figure.coefficients = size_coefficients(term.size, trial.mechanism, loose);
    return figure;
  }
  Trajectory trajectory = find_trajectory(trial, term);
  if (samples == FigureSampling::coarse) trajectory.samples = std::min(trajectory.samples, max_coarse_samples);
  auto series = TrajectoryCost(trial.mechanism, trajectory, loose).rows(term.quantity);
  if (!series) return std::nullopt;
  figure.series = std::move(*series);
  return figure;
}

/// A convex function of the parameters, whatever the motion is.
bool is_convex_in_parameters(const DesignInstance& trial, const ObjectiveTerm& term) {
  if (term.size != ObjectiveTerm::Size::none) return term.weight >= 0;
  if (term.deviation_multiple) return false;
  return term.run == ObjectiveTerm::RunMeasure::figure && term.weight >= 0 &&
         (term.figure == Statistic::rms || term.figure == Statistic::peak) &&
         is_linear_quantity(trial.mechanism, term.quantity) && !is_mass_dependent(find_trajectory(trial, term)) &&
         !is_mechanism_dependent(find_trajectory(trial, term));
}

}  // namespace

std::function<std::optional<std::vector<AffineFigure>>(const VectorX& x)> build_convex_terms(
    const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const FreeSprings& loose,
    FigureSampling samples) {
  const DesignInstance start = space.instantiate(space.start_values());
  const auto all = [&](const ObjectiveTerm& term) { return is_convex_in_parameters(start, term); };
  if (!std::all_of(terms.begin(), terms.end(), all)) return {};
  return [space, terms, loose, samples](const VectorX& x) -> std::optional<std::vector<AffineFigure>> {
    std::vector<AffineFigure> figures;
    try {
      const DesignInstance trial = instantiate_checked(space, x);
      for (const ObjectiveTerm& term : terms) {
        std::optional<AffineFigure> figure = make_convex_term(trial, term, loose, samples);
        if (!figure) return std::nullopt;
        figures.push_back(std::move(*figure));
      }
    } catch (const SpecError&) {
      return std::nullopt;  // an expression of the spec has no value here
    } catch (const std::invalid_argument&) {
      return std::nullopt;  // nor is there a motion
    }
    return figures;
  };
}

Objective build_objective(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms, const VectorX& start,
                          const FreeSprings& loose) {
  const DesignInstance before = space.instantiate(start);
  std::vector<ObjectivePart> parts;
  Objective objective;
  objective.is_convex = objective.is_secondary = true;
  // magnitudes, distances and masses
  if (std::all_of(terms.begin(), terms.end(), [](const ObjectiveTerm& term) { return term.weight >= 0; }))
    objective.lower_bound = 0;
  for (const ObjectiveTerm& term : terms) {
    const bool size = term.size != ObjectiveTerm::Size::none;
    ObjectivePart part{term.weight,
                       size ? make_linear_cost(size_coefficients(term.size, before.mechanism, loose))
                            : make_fixed_motion_cost(space, before, term, loose),
                       term};
    if (!part.of_parameters) require_quantity(before, term);  // says now what does not exist
    if (term.deviation_multiple) require_deviations(space, start, term);
    if (!size) part.run = find_fixed_run(space, before, term, loose);
    const std::optional<double> fixed = constant_value(space, before, part);
    if (fixed) part.of_parameters = make_constant_cost(*fixed);
    objective.is_constant = fixed && terms.size() == 1;
    objective.is_convex = objective.is_convex && part.of_parameters && is_convex(term);
    objective.is_secondary = objective.is_secondary && size;
    objective.name += (parts.empty() ? "" : " + ") + (term.weight == 1 ? "" : fmt::format("{:g} ", term.weight)) +
                      objective_term_name(term);
    parts.push_back(std::move(part));
  }
  const bool cheap =
      std::all_of(parts.begin(), parts.end(), [](const ObjectivePart& p) { return bool(p.of_parameters); });
  if (terms.size() == 1 && terms[0].size != ObjectiveTerm::Size::none)
    objective.unit = terms[0].size == ObjectiveTerm::Size::added_inertia ? "kg m^2" : "kg";
  if (cheap)
    objective.of_parameters = sum_of_parameters(std::move(parts));
  else
    objective.of_variables = sum_of_variables(space, std::move(parts), loose);
  objective.failure_reason = make_failure_reason(space, terms);
  return objective;
}

VectorX added_parameter_mask(const Mechanism& mechanism, const std::vector<Parameter>& parameters) {
  VectorX added(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto index = static_cast<std::size_t>(parameters[p].index);
    const bool counterweight = parameters[p].owner_kind == ParameterOwner::attachment &&
                               mechanism.attachments[index].kind == AttachmentKind::counterweight;
    added[static_cast<Eigen::Index>(p)] = counterweight || parameters[p].owner_kind == ParameterOwner::disc ? 1 : 0;
  }
  return added;
}

VectorX mass_coefficients(const std::vector<Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind == ParameterKind::mass ? 1 : 0;
  return coefficients;
}

VectorX inertia_coefficients(const std::vector<Parameter>& parameters) {
  VectorX coefficients(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t p = 0; p < parameters.size(); ++p)
    coefficients[static_cast<Eigen::Index>(p)] = parameters[p].kind != ParameterKind::moment_of_inertia ? 0
                                                 : parameters[p].symbol == "J"                          ? 1
                                                                                                        : 0.5;
  return coefficients;
}

VectorX size_coefficients(ObjectiveTerm::Size size, const Mechanism& mechanism, const FreeSprings& loose) {
  const auto parameters = list_parameters(mechanism, loose);
  VectorX coefficients =
      size == ObjectiveTerm::Size::added_inertia ? inertia_coefficients(parameters) : mass_coefficients(parameters);
  if (size != ObjectiveTerm::Size::total_mass)
    coefficients.array() *= added_parameter_mask(mechanism, parameters).array();
  return coefficients;
}

// What terms of objectives are called.
std::string objective_term_name(Statistic figure) {
  switch (figure) {
    case Statistic::peak: return "peak";
    case Statistic::rms: return "rms";
    case Statistic::mean: return "mean";
    case Statistic::range: return "range";
  }
  return "";
}

std::string objective_term_name(const ObjectiveTerm& term) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_mass: return "added mass";
    case ObjectiveTerm::Size::added_inertia: return "added inertia";
    case ObjectiveTerm::Size::total_mass: return "total mass";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::energy: return "energy along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::mobility: return "mobility along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::clearance: return "clearance along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::duration: return "duration of " + term.trajectory;
    case ObjectiveTerm::RunMeasure::figure: break;
  }
  const std::string figure = objective_term_name(term.figure) + "(" + term.quantity + ") along " + term.trajectory;
  return term.deviation_multiple ? fmt::format("mean plus {:g} deviation{} of {}", *term.deviation_multiple,
                                               *term.deviation_multiple == 1 ? "" : "s", figure)
                                 : figure;
}

namespace {

/// What parameters change by with every number, one column each: they are smooth, and cheap.
MatrixX parameter_jacobian(const DesignSpace& space, const VectorX& x, const FreeSprings& loose) {
  constexpr double step = 1e-5;  // of a number's range
  const auto at = [&](const VectorX& there) { return parameter_values(space.instantiate(there).mechanism, loose); };
  MatrixX slopes(at(x).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double reach = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + reach, free.upper), down[i] = std::max(x[i] - reach, free.lower);
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
  return {coefficients.dot(parameter_values(mechanism, loose)),
          parameter_jacobian(space, x, loose).transpose() * coefficients};
}

MaxTerm make_single_term(double weight, const ValueWithGradient& slope) {
  return {weight, VectorX::Constant(1, slope.value), slope.gradient.transpose()};
}

/// The largest of the slopes and of the negative ones.
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
  const QuantityGradients* found = find_quantity(slopes, term.quantity);
  if (found == nullptr)
    throw std::invalid_argument("a run along '" + term.trajectory + "' has no quantity '" + term.quantity + "'");
  switch (term.figure) {
    case Statistic::rms: return pieces.push_back(make_single_term(weight, found->rms));
    case Statistic::mean: return pieces.push_back(make_single_term(weight, found->mean));
    case Statistic::peak:
      return pieces.push_back(make_max_term(weight, found->segment_maxima, found->segment_minima, numbers));
    case Statistic::range:
      pieces.push_back(make_max_term(weight, found->segment_maxima, {}, numbers));
      pieces.push_back(make_max_term(weight, {}, found->segment_minima, numbers));
  }
}

bool has_optimised_motion(const DesignSpace& space, const ObjectiveTerm& term) {
  using Run = ObjectiveTerm::RunMeasure;
  if ((term.run != Run::figure && term.run != Run::duration) || has_velocity_constraints(space.start.mechanism))
    return true;
  const auto& all = space.start.trajectories;
  return std::any_of(all.begin(), all.end(), [&](const Trajectory& trajectory) {
    return trajectory.name == term.trajectory && is_mechanism_dependent(trajectory);
  });
}

/// Along a law or a course that is found for every mechanism, good to some 1e-7 of the figure: steps of a thousandth of a number's range
/// leave some 1e-4 of that range's slope.
ValueWithGradient gradient_by_differences(const DesignSpace& space, const ObjectiveTerm& term, const VectorX& x) {
  constexpr double step = 1e-3;
  ValueWithGradient slope{simulate_figure(instantiate_checked(space, x), term), VectorX(x.size())};
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const FreeNumber& free = space.start.free_numbers[static_cast<std::size_t>(i)];
    const double reach = step * (free.upper - free.lower);
    VectorX up = x, down = x;
    up[i] = std::min(x[i] + reach, free.upper), down[i] = std::max(x[i] - reach, free.lower);
    const double high = simulate_figure(instantiate_checked(space, up), term);
    const double low = simulate_figure(instantiate_checked(space, down), term);
    // where only one side has a value the other serves
    slope.gradient[i] = std::isfinite(high - low) ? (high - low) / (up[i] - down[i])
                        : std::isfinite(high)     ? (high - slope.value) / (up[i] - x[i])
                                                  : (slope.value - low) / (x[i] - down[i]);
  }
  return slope;
}

}  // namespace

std::optional<std::vector<MaxTerm>> compute_max_terms(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                                      const FreeSprings& loose, const VectorX& x) {
  const DesignInstance trial = instantiate_checked(space, x);
  std::map<std::string, std::vector<std::string>> quantities;
  for (const ObjectiveTerm& term : terms) {
    if (term.size != ObjectiveTerm::Size::none || has_optimised_motion(space, term)) continue;
    std::vector<std::string>& names = quantities[term.trajectory];
    if (term.run == ObjectiveTerm::RunMeasure::figure) names.push_back(term.quantity);
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
      pieces.push_back(make_single_term(term.weight, size_with_gradient(space, trial.mechanism, term, loose, x)));
    else if (has_optimised_motion(space, term))
      pieces.push_back(make_single_term(term.weight, gradient_by_differences(space, term, x)));
    else
      add_figure(term, runs[term.trajectory], x.size(), pieces);
  return pieces;
}

}  // namespace balance
