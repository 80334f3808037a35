#include "balance/analysis/objective.hpp"

#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/objective_pieces.hpp"
#include "balance/analysis/robust_figure.hpp"
#include "balance/analysis/run_figure.hpp"
#include "balance/base/error.hpp"
#include "balance/cost/trajectory_cost.hpp"
#include "balance/design/features.hpp"
#include "balance/result/effort_names.hpp"
#include "balance/simulation/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <stdexcept>
#include <utility>

namespace balance {

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

}  // namespace balance
